#include "pipeline/study/study_pictures.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cache/sha256.h"
#include "pipeline/run/render_frames.h"
#include "pipeline/run/signals.h"
#include "pipeline/run/video.h"
#include "pipeline/study/study_table.h"
#include "render/contact_sheet.h"
#include "render/png.h"
#include "render/text/draw_text.h"

namespace wry::pipeline {

namespace {

namespace fs = std::filesystem;

constexpr double STRIP_PIXELS = 3e6; ///< of one strip, so that a browser holds dozens
constexpr int LARGEST_CELL = 320, SMALLEST_CELL = 96;
constexpr std::size_t MOST_STRIP_FRAMES = 240, MOST_MOSAIC_FRAMES = 1000;
constexpr const char* INPUTS = "wry:inputs";

/// Every stride'th of the frames, the last among them.
std::vector<int> thinned(const std::vector<int>& frames, std::size_t most) {
  const std::size_t stride = (frames.size() + most - 1) / std::max<std::size_t>(most, 1);
  if (stride <= 1)
    return frames;
  std::vector<int> kept;
  for (std::size_t i = 0; i < frames.size(); i += stride)
    kept.push_back(frames[i]);
  if (kept.back() != frames.back())
    kept.push_back(frames.back());
  return kept;
}

/// A dark card with words instead of a picture.
render::Image placeholder(int width, int height, const std::string& reason) {
  render::Image image(width, height);
  render::fill_rectangle(image, 0, 0, width, height, {0.16f, 0.10f, 0.11f}, 1.f);
  render::TextStyle style;
  style.capital_height = std::max(7.0, height / 18.0);
  style.halo = 0.f;
  const auto letters = static_cast<std::size_t>(1.5 * width / style.capital_height);
  std::string text = reason;
  std::replace(text.begin(), text.end(), '\n', ' ');
  double y = 0.25 * height;
  for (std::size_t at = 0; at < text.size() && y < 0.95 * height; at += letters, y += 2.0 * style.capital_height)
    render::draw_text(image, 0.05 * width, y, text.substr(at, letters), style);
  return image;
}

class PictureMaker {
public:
  PictureMaker(const fs::path& folder, const std::vector<StudyRow>& rows)
      : m_folder(folder)
      , m_rows(rows)
      , m_grid(study_grid(rows)) {}

  Result<StudyPictures> make() {
    if (!find_first())
      return m_made;
    m_inputs = m_grid ? "by parameters\n" : "";
    if (Status status = make_sheet(); !status)
      return status.error();
    for (const StudyRow& row : m_rows) {
      if (stop_requested())
        return stopped_by_signal("while the sweep's pictures were made");
      m_inputs +=
          fmt::format("{} {} {} {}\n", row.variant.id(), row.variant.name, outcome_name(row.outcome), row.reason);
      if (Status status = make_strip(row); !status)
        return status.error();
    }
    if (Status status = make_mosaic(); !status)
      return status.error();
    return m_made;
  }

private:
  /// The first picture there is: it gives view and size.
  bool find_first() {
    for (const StudyRow& row : m_rows) {
      if (!row.shot || row.shot->render.views.empty() || row.frames.empty())
        continue;
      m_made.view = row.shot->render.views.front()->name;
      if (const Result<render::PngContents> first = render::read_png(picture(row, row.frames.back())); first) {
        m_width = first->image.width;
        m_height = first->image.height;
        return true;
      }
    }
    return false;
  }

  fs::path picture(const StudyRow& row, int frame) const {
    return picture_path(row.folder, row.shot ? *row.shot->shot.name : "", m_made.view, frame);
  }

  render::Image picture_or_reason(const StudyRow& row, int frame, int width) const {
    const int height = std::max(1, width * m_height / m_width);
    if (row.shot) {
      if (const Result<render::PngContents> read = render::read_png(picture(row, frame)); read)
        return render::shrunk(read->image, std::min(width, read->image.width), std::min(height, read->image.height));
    }
    return placeholder(width, height, fmt::format("{}: {}", outcome_name(row.outcome), row.reason));
  }

  /// All variants on one of their frames: by parameters where they are a grid, else as square as their count allows.
  template <class FrameOf> Result<render::Image> make_sheet_of(int width, const FrameOf& frame_of) const {
    render::SheetSettings settings;
    const auto square = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(m_rows.size()))));
    std::vector<std::size_t> order(m_rows.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    if (m_grid) {
      order = m_grid->order;
      settings.column_heads = m_grid->column_heads;
      settings.row_heads = m_grid->row_heads;
    }
    const std::size_t columns = m_grid ? settings.column_heads.size() : square;
    settings.cell_width = std::clamp(width / static_cast<int>(columns), 64, 480);
    std::vector<render::SheetEntry> entries;
    for (const std::size_t i : order) {
      const StudyRow& row = m_rows[i];
      const std::string number = row.variant.id().substr(0, 3);
      entries.push_back({picture_or_reason(row, frame_of(row), settings.cell_width),
                         m_grid ? number : fmt::format("{} {}", number, row.variant.name)});
    }
    return render::make_contact_sheet(entries, settings);
  }

  Status make_sheet() {
    const Result<render::Image> sheet =
        make_sheet_of(4096, [](const StudyRow& row) { return row.frames.empty() ? 0 : row.frames.back(); });
    if (!sheet)
      return sheet.error();
    m_made.sheet = fmt::format("sheet.{}.png", m_made.view);
    return render::write_png(m_folder / m_made.sheet, *sheet, {{"Title", "contact sheet"}});
  }

  Status make_strip(const StudyRow& row) {
    std::vector<int> frames;
    for (const int frame : row.frames) {
      if (row.shot && fs::exists(picture(row, frame)))
        frames.push_back(frame);
    }
    frames = thinned(frames, MOST_STRIP_FRAMES);
    if (frames.empty())
      return {};
    FrameStrip strip;
    const double aspect = static_cast<double>(m_height) / m_width;
    strip.cell_width =
        std::clamp(static_cast<int>(std::sqrt(STRIP_PIXELS / aspect / static_cast<double>(frames.size()))),
                   SMALLEST_CELL, std::min(LARGEST_CELL, std::max(m_width, SMALLEST_CELL)));
    strip.cell_height = std::max(1, static_cast<int>(std::lround(strip.cell_width * aspect)));
    strip.columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(frames.size()))));
    strip.frames = std::move(frames);
    strip.file = fmt::format("strips/{}.png", row.variant.id());
    m_made.strips[row.variant.id()] = strip;
    return draw_strip(row, strip);
  }

  /// Draws a strip unless it is there from the same pictures.
  Status draw_strip(const StudyRow& row, const FrameStrip& strip) {
    std::string inputs = fmt::format("{} {}", strip.cell_width, strip.columns);
    for (const int frame : strip.frames) {
      const Result<std::string> hash = sha256_of_file(picture(row, frame));
      inputs += hash ? *hash : std::string("-");
    }
    inputs = sha256_of_bytes(inputs);
    m_inputs += inputs + "\n";
    if (const Result<render::PngContents> before = render::read_png(m_folder / strip.file); before) {
      const auto same = [&](const render::PngText& text) { return text.key == INPUTS && text.value == inputs; };
      if (std::any_of(before->texts.begin(), before->texts.end(), same))
        return {};
    }
    const int rows = (static_cast<int>(strip.frames.size()) + strip.columns - 1) / strip.columns;
    render::Image image(strip.columns * strip.cell_width, rows * strip.cell_height);
    for (std::size_t i = 0; i < strip.frames.size(); ++i) {
      const render::Image cell = picture_or_reason(row, strip.frames[i], strip.cell_width);
      const int x0 = static_cast<int>(i) % strip.columns * strip.cell_width;
      const int y0 = static_cast<int>(i) / strip.columns * strip.cell_height;
      for (int y = 0; y < std::min(cell.height, strip.cell_height); ++y)
        std::copy_n(cell.at(0, y), static_cast<std::size_t>(std::min(cell.width, strip.cell_width)) * 4,
                    image.at(x0, y0 + y));
    }
    if (Status status = prepare_folder(m_folder / "strips"); !status)
      return status;
    return render::write_png(m_folder / strip.file, image, {{INPUTS, inputs}});
  }

  /// Every frame that some variant shows.
  std::vector<int> all_frames() const {
    std::set<int> frames;
    for (const auto& [id, strip] : m_made.strips)
      frames.insert(strip.frames.begin(), strip.frames.end());
    return thinned({frames.begin(), frames.end()}, MOST_MOSAIC_FRAMES);
  }

  Status make_mosaic() {
    const std::vector<int> frames = all_frames();
    if (frames.size() < 2 || m_rows.size() < 2 || !has_video_program())
      return {};
    m_made.mosaic = fmt::format("mosaic.{}.mp4", m_made.view);
    const fs::path key = m_folder / "strips" / "mosaic.key"; // of the pictures that the film was made from
    const std::string inputs = sha256_of_bytes(m_inputs);
    if (const Result<std::string> before = read_whole_file(key);
        before && *before == inputs && fs::exists(m_folder / m_made.mosaic))
      return {};
    const fs::path folder = m_folder / "mosaic.aside";
    if (Status status = prepare_folder(folder); !status)
      return status;
    std::vector<fs::path> pictures;
    for (const int frame : frames) {
      if (stop_requested())
        return stopped_by_signal("while the mosaic was made");
      const Result<render::Image> sheet = make_sheet_of(1920, [frame](const StudyRow&) { return frame; });
      if (!sheet)
        return sheet.error();
      pictures.push_back(folder / fmt::format("{:06}.png", frame));
      if (Status status = render::write_png(pictures.back(), *sheet, {}); !status)
        return status;
    }
    VideoSettings video;
    video.fps = fps();
    const Status encoded = encode_video(pictures, m_folder / m_made.mosaic, video);
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    return encoded ? write_file_atomically(key, inputs) : encoded;
  }

  double fps() const {
    for (const StudyRow& row : m_rows) {
      if (row.shot)
        return *row.shot->shot.fps;
    }
    return 24.0;
  }

  const fs::path& m_folder;
  const std::vector<StudyRow>& m_rows;
  std::optional<StudyGrid> m_grid;
  StudyPictures m_made;
  int m_width = 0, m_height = 0;
  std::string m_inputs; ///< of all that the film shows
};

} // namespace

Result<StudyPictures> make_study_pictures(const fs::path& folder, const std::vector<StudyRow>& rows) {
  return PictureMaker(folder, rows).make();
}

} // namespace wry::pipeline
