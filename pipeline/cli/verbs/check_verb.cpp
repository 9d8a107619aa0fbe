#include <algorithm>
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include "pipeline/cache/verified_folder.h"
#include "pipeline/cli/shot_session.h"
#include "pipeline/cli/verb.h"
#include "pipeline/run/check_frames.h"
#include "render/png.h"
#include "shots/load.h"

namespace wry::pipeline {

namespace {

namespace fs = std::filesystem;

struct Tally {
  std::size_t good = 0;
  std::size_t damaged = 0;
  std::size_t intersecting = 0; ///< frames
};

Status check_manifest_folder(const fs::path& folder, Tally& tally) {
  if (!fs::exists(folder))
    return {};
  const Result<FolderReport> report = check_folder(folder);
  if (!report)
    return report.error();
  tally.good += report->good_files;
  for (const FolderFinding& finding : report->findings) {
    const bool damage = is_damage(finding.kind);
    tally.damaged += damage ? 1 : 0;
    fmt::print("{}: {}\n", damage ? "damaged" : "note", finding.message);
  }
  fmt::print("{}: {} files whole, every SHA-256 as the manifest says\n", folder.string(), report->good_files);
  return {};
}

Status check_pictures(const fs::path& folder, Tally& tally) {
  if (!fs::exists(folder))
    return {};
  std::vector<fs::path> pictures;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".png")
      pictures.push_back(entry.path());
  }
  std::sort(pictures.begin(), pictures.end());
  std::size_t whole = 0;
  for (const fs::path& picture : pictures) {
    const Status status = render::png_is_whole(picture);
    if (status.ok()) {
      ++whole;
      continue;
    }
    ++tally.damaged;
    fmt::print("damaged: {}\n", status.error().message);
  }
  tally.good += whole;
  if (!pictures.empty())
    fmt::print("{}: {} of {} pictures decode\n", folder.string(), whole, pictures.size());
  return {};
}

Status check_intersections(const shots::Shot& shot, const fs::path& folder, Tally& tally) {
  if (!shot.contact || tally.damaged > 0 || !fs::exists(folder / "frames"))
    return {};
  const Result<IntersectionReport> report = find_intersections(shot, folder, Threads());
  if (!report)
    return report.error();
  for (const std::string& finding : report->findings)
    fmt::print("intersecting: {}\n", finding);
  tally.intersecting += report->findings.size();
  fmt::print("{}: {} frames tested exactly, {} with intersections\n", folder.string(), report->frames,
             report->findings.size());
  return {};
}

Status check_output_folder(const fs::path& folder) {
  Tally tally;
  for (const char* part : {"frames", "checkpoints", "fields"}) {
    if (Status status = check_manifest_folder(folder / part, tally); !status)
      return status;
  }
  for (const char* part : {"images", "turntable"}) {
    if (Status status = check_pictures(folder / part, tally); !status)
      return status;
  }
  if (fs::exists(folder / "shot.toml")) {
    const Result<shots::Shot> shot = shots::load_shot((folder / "shot.toml").string());
    if (!shot) {
      ++tally.damaged;
      fmt::print("damaged: {}\n", shot.error().message);
    } else if (Status status = check_intersections(*shot, folder, tally); !status) {
      return status;
    }
  }
  if (tally.good == 0 && tally.damaged == 0)
    return make_error(ErrorCode::missing_input, "{} holds no frames, checkpoints or pictures of wry", folder.string());
  if (tally.intersecting > 0)
    return make_error(ErrorCode::check_failed, "{}: surfaces intersect in {} frames", folder.string(),
                      tally.intersecting);
  if (tally.damaged > 0)
    return make_error(ErrorCode::check_failed, "{}: {} damaged; `wry run` makes them again", folder.string(),
                      tally.damaged == 1 ? "a file is" : fmt::format("{} files are", tally.damaged));
  fmt::print("{}: whole\n", folder.string());
  return {};
}

} // namespace

Status check_verb(const Invocation& invocation) {
  if (fs::is_directory(invocation.subject))
    return check_output_folder(invocation.subject);
  const Result<ShotSession> session = open_session(invocation);
  if (!session)
    return session.error();
  const Result<ScenePlan> plan = plan_session(*session);
  if (!plan)
    return plan.error();
  for (const std::string& warning : plan->warnings)
    fmt::print("warning: {}\n", warning);
  fmt::print("{}: valid\n", invocation.subject);
  return {};
}

} // namespace wry::pipeline
