#include <algorithm>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cli/verb.h"
#include "pipeline/run/render_frames.h"
#include "render/compare_images.h"
#include "render/png.h"

namespace wry::pipeline {

namespace {

namespace fs = std::filesystem;

constexpr double FILM_FPS = 24.0;
/// Difference that takes the last colour; the eye sees one of two or three.
constexpr double FULL_DIFFERENCE = 64.0;

/// The pictures of an output folder by what stands behind the shot's name: "beauty.0001".
Result<std::map<std::string, fs::path>> pictures_of(const fs::path& out) {
  std::error_code failure;
  const fs::path folder = fs::is_directory(out / "images", failure) ? out / "images" : out;
  std::map<std::string, fs::path> found;
  for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end; entry.increment(failure)) {
    const fs::path& path = entry->path();
    const std::string stem = path.stem().string();
    const std::size_t number = stem.find_last_of('.');
    if (path.extension() != ".png" || number == std::string::npos || number == 0 ||
        stem.find_first_not_of("0123456789", number + 1) != std::string::npos)
      continue;
    const std::size_t view = stem.find_last_of('.', number - 1);
    found[view == std::string::npos ? stem : stem.substr(view + 1)] = path;
  }
  if (failure || found.empty())
    return make_error(ErrorCode::missing_input, "{} holds no pictures; draw them with `wry render`", folder.string());
  return found;
}

std::string label_of(const fs::path& out) {
  const fs::path whole = fs::absolute(out).lexically_normal();
  return whole.filename().empty() ? whole.parent_path().filename().string() : whole.filename().string();
}

/// Draws one pair; false when the pictures are the same.
Result<bool> compare_pair(const Invocation& invocation, const std::string& name, const fs::path& left,
                          const fs::path& right, const fs::path& target) {
  const Result<render::PngContents> a = render::read_png(left);
  if (!a)
    return a.error();
  const Result<render::PngContents> b = render::read_png(right);
  if (!b)
    return b.error();
  const auto at_pair = [&](const Error& error) { return Error{error.code, left.string() + ": " + error.message}; };
  const Result<render::ImageDifference> difference = render::difference_of_images(a->image, b->image, FULL_DIFFERENCE);
  if (!difference)
    return at_pair(difference.error());
  if (invocation.json)
    fmt::print("{{\"picture\": \"{}\", \"mean\": {:.6g}, \"greatest\": {}, \"pixels_apart\": {}}}\n", name,
               difference->mean, difference->greatest, difference->pixels_apart);
  else if (!invocation.quiet)
    fmt::print("{}: mean {:.4f}, greatest {} of 255, {} pixels apart\n", name, difference->mean, difference->greatest,
               difference->pixels_apart);
  render::Image drawn = difference->map;
  if (invocation.mode != "difference") {
    Result<render::Image> split =
        render::split_images(a->image, b->image, label_of(invocation.subject), label_of(invocation.with));
    if (!split)
      return at_pair(split.error());
    drawn = std::move(*split);
  }
  if (Status status = render::write_png(target, drawn, {{"wry:left", left.string()}, {"wry:right", right.string()}});
      !status)
    return status.error();
  return difference->pixels_apart > 0;
}

} // namespace

Status compare_verb(const Invocation& invocation) {
  if (invocation.with.empty())
    return make_error(ErrorCode::usage, "--with DIR: the folder to compare with is missing");
  if (!invocation.mode.empty() && invocation.mode != "split" && invocation.mode != "difference")
    return make_error(ErrorCode::usage, "--mode {}: expected split or difference", invocation.mode);
  const Result<std::map<std::string, fs::path>> left = pictures_of(invocation.subject);
  if (!left)
    return left.error();
  const Result<std::map<std::string, fs::path>> right = pictures_of(invocation.with);
  if (!right)
    return right.error();
  const std::string mode = invocation.mode.empty() ? "split" : invocation.mode;
  const fs::path folder = invocation.out.empty() ? fs::path("out") / "compare" : fs::path(invocation.out);
  if (Status status = prepare_folder(folder); !status)
    return status;
  std::map<std::string, std::vector<fs::path>> films;
  int compared = 0;
  int different = 0;
  for (const auto& [name, path] : *left) {
    const auto other = right->find(name);
    if (other == right->end())
      continue;
    const fs::path target = folder / fmt::format("{}.{}.png", mode, name);
    const Result<bool> apart = compare_pair(invocation, name, path, other->second, target);
    if (!apart)
      return apart.error();
    ++compared;
    different += *apart ? 1 : 0;
    films[name.substr(0, name.find('.'))].push_back(target);
  }
  if (compared == 0)
    return make_error(ErrorCode::missing_input, "{} and {} have no picture of the same view and frame",
                      invocation.subject, invocation.with);
  for (const auto& [view, pictures] : films) {
    if (pictures.size() < 2)
      continue;
    if (Status status = encode_film(pictures, folder / fmt::format("{}.{}.mp4", mode, view), FILM_FPS); !status)
      return status;
  }
  if (!invocation.quiet && !invocation.json)
    fmt::print("{} of {} pictures differ: {}\n", different, compared, folder.string());
  return {};
}

} // namespace wry::pipeline
