#include "pipeline/run/render_frames.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cache/sha256.h"
#include "pipeline/plan/build_id.h"
#include "pipeline/run/progress.h"
#include "pipeline/run/signals.h"
#include "pipeline/run/video.h"
#include "render/png.h"
#include "render/renderer.h"
#include "shots/resolved.h"

namespace wry::pipeline {

namespace {

namespace fs = std::filesystem;

constexpr const char* INPUTS = "wry:inputs";

/// A picture that is wanted: where it goes, what it is made from.
struct PictureJob {
  fs::path path;
  std::string inputs; ///< SHA-256 of everything that it depends on
  render::Picture picture;
  std::vector<render::PngText> texts;
};

bool is_up_to_date(const PictureJob& job) {
  const Result<render::PngContents> there = render::read_png(job.path);
  if (!there)
    return false;
  return std::any_of(there->texts.begin(), there->texts.end(),
                     [&](const render::PngText& text) { return text.key == INPUTS && text.value == job.inputs; });
}

/// Text that two equal plans share: what a picture depends on beside the frame itself.
std::string fingerprint(const render::RenderPlan& plan, const shots::Shot* shot) {
  std::string text = fmt::format("{} {} {}x{} {}", version(), render_build(), plan.size.width, plan.size.height,
                                 static_cast<int>(plan.framing));
  for (Eigen::Index i = 0; i < plan.bounds.outline().size(); ++i)
    text += fmt::format(" {}", plan.bounds.outline().data()[i]);
  for (const render::View& view : plan.views) {
    if (view.heat)
      text += fmt::format(" {} {} {}", view.name, view.heat->low, view.heat->high);
  }
  if (shot != nullptr) {
    for (const shots::FlatKey& key : shots::flatten(*shot)) {
      if (key.effect == shots::Effect::pictures)
        text += fmt::format(" {}={}", key.key, key.value);
    }
  }
  return text;
}

ValueRange range_of(const SceneStatic& scene, const FrameCache& cache, const std::string& channel_name,
                    Status& status) {
  ValueRange range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const CachedFrame& cached : cache.frames()) {
    const Result<Frame> frame = cache.read_frame(cached.number);
    if (!frame) {
      status = frame.error();
      return range;
    }
    for (std::size_t body = 0; body < scene.bodies.size(); ++body) {
      const Channel* channel = find_channel(frame->bodies[body], channel_name);
      if (channel == nullptr)
        continue;
      const auto components = static_cast<std::size_t>(channel->components);
      for (std::size_t row = 0; row + components <= channel->values.size(); row += components) {
        double square = 0.0;
        for (std::size_t i = 0; i < components; ++i)
          square += channel->values[row + i] * channel->values[row + i];
        const double value = components == 1 ? channel->values[row] : std::sqrt(square);
        range.low = std::min(range.low, value);
        range.high = std::max(range.high, value);
      }
    }
  }
  return range;
}

std::vector<std::string> slate_lines(const shots::Shot& shot, const Frame& frame) {
  if (!*shot.render.slate)
    return {};
  std::string line = fmt::format("{}   frame {}   {:.3f} s", *shot.shot.name, frame.number, frame.time);
  if (shot.sweep_case)
    line += "   " + **shot.sweep_case;
  return {line};
}

/// Draws pictures one after the other with one context, made when the first picture is really needed.
class Draughtsman {
public:
  Draughtsman(const render::RenderPlan& plan, const SceneStatic& scene)
      : m_plan(plan)
      , m_scene(scene) {}

  Status draw(const Frame& frame, PictureJob job) {
    if (!m_renderer) {
      Result<render::Renderer> made = render::Renderer::create(m_plan, m_scene);
      if (!made)
        return made.error();
      m_renderer.emplace(std::move(*made));
    }
    const Result<render::Image> image = m_renderer->draw(frame, job.picture);
    if (!image)
      return image.error();
    job.texts.push_back({INPUTS, job.inputs});
    job.texts.push_back({"wry:build", fmt::format("{} {}", version(), render_build())});
    job.texts.push_back({"wry:gl", m_renderer->gl_version().backend + " " + m_renderer->gl_version().version});
    return render::write_png(job.path, *image, job.texts);
  }

private:
  const render::RenderPlan& m_plan;
  const SceneStatic& m_scene;
  std::optional<render::Renderer> m_renderer;
};

Progress::Mode progress_mode(RenderOptions::Talk talk, int part) {
  return talk == RenderOptions::Talk::quiet || part != 0 ? Progress::Mode::quiet : Progress::Mode::automatic;
}

} // namespace

fs::path picture_path(const fs::path& out, const std::string& shot, const std::string& view, int frame) {
  return out / "images" / fmt::format("{}.{}.{:04}.png", shot, view, frame);
}

Result<SequenceFacts> gather_sequence(const shots::Shot& shot, const FrameCache& cache) {
  const Result<SceneStatic> scene = cache.read_static();
  if (!scene)
    return scene.error();
  SequenceFacts facts;
  for (const CachedFrame& cached : cache.frames()) {
    const Result<Frame> frame = cache.read_frame(cached.number);
    if (!frame)
      return frame.error();
    if (Status status = facts.bounds.include(*scene, *frame); !status)
      return status.error();
  }
  if (facts.bounds.empty())
    return make_error(ErrorCode::missing_input, "there is no frame in the cache; run `wry simulate` first");
  for (const shots::Located<shots::View>& view : shot.render.views) {
    ValueRange range;
    if (view->kind == shots::ViewKind::heat) {
      Status status;
      range = range_of(*scene, cache, view->channel, status);
      if (!status)
        return status.error();
      if (!(range.low <= range.high))
        return make_error(ErrorCode::bad_input, "{}: view {}: no frame has a channel '{}'", view.source.text(),
                          view->name, view->channel);
      for (const shots::HeatRange& given : shot.render.heat) {
        if (given.channel != view->channel)
          continue;
        range.low = given.min ? **given.min : range.low;
        range.high = given.max ? **given.max : range.high;
      }
      if (!(range.high > range.low))
        range.high = range.low + 1.0;
    }
    facts.heat.push_back(range);
  }
  return facts;
}

Result<RenderOutcome> render_frames(const shots::Shot& shot, const RenderOptions& options) {
  const Result<FrameCache> cache = FrameCache::open_to_read(options.out / "frames");
  if (!cache)
    return cache.error();
  const Result<SequenceFacts> facts = gather_sequence(shot, *cache);
  if (!facts)
    return facts.error();
  const Result<render::RenderPlan> plan = compile_render(shot, *facts, options.backend);
  if (!plan)
    return plan.error();
  Result<SceneStatic> scene = cache->read_static();
  if (!scene)
    return scene.error();
  dress_scene(shot, *scene);
  const std::string settings = fingerprint(*plan, &shot);
  const std::vector<CachedFrame> cached = cache->frames();

  if (Status status = prepare_folder(options.out / "images"); !status)
    return status.error();
  RenderOutcome outcome;
  Draughtsman draughtsman(*plan, *scene);
  Progress progress(*shot.shot.name + ": render", static_cast<double>(options.frames.size()), 0.0,
                    progress_mode(options.talk, options.part));
  for (std::size_t i = 0; i < options.frames.size(); ++i) {
    const int number = options.frames[i];
    progress.update(static_cast<double>(i), fmt::format("frame {}", number));
    if (static_cast<int>(i) % options.parts != options.part)
      continue;
    const auto entry =
        std::find_if(cached.begin(), cached.end(), [&](const CachedFrame& frame) { return frame.number == number; });
    if (entry == cached.end())
      return make_error(ErrorCode::missing_input, "frame {} is not in the cache {}; simulate it first", number,
                        (options.out / "frames").string());
    std::optional<Frame> frame;
    for (const render::View& view : plan->views) {
      if (stop_requested())
        return stopped_by_signal(fmt::format("frame {} is the next to draw", number));
      PictureJob job;
      job.path = picture_path(options.out, *shot.shot.name, view.name, number);
      job.inputs = sha256_of_bytes(entry->sha256 + " " + view.name + " " + settings);
      if (is_up_to_date(job)) {
        ++outcome.kept;
        continue;
      }
      if (!frame) {
        Result<Frame> read = cache->read_frame(number);
        if (!read)
          return read.error();
        frame = std::move(*read);
      }
      job.picture.view = view.name;
      job.picture.slate = slate_lines(shot, *frame);
      job.texts = {{"wry:shot", *shot.shot.name},
                   {"wry:frame", std::to_string(number)},
                   {"wry:time", fmt::format("{}", frame->time)},
                   {"wry:view", view.name},
                   {"wry:frame_sha256", entry->sha256}};
      if (Status status = draughtsman.draw(*frame, std::move(job)); !status)
        return status.error();
      ++outcome.drawn;
    }
  }
  progress.update(static_cast<double>(options.frames.size()), "done");
  return outcome;
}

Result<RenderOutcome> render_turntable(render::RenderPlan plan, const SceneStatic& scene, const Frame& frame,
                                       const TurntableJob& job) {
  plan.framing = render::Framing::orbit;
  const std::string settings = fingerprint(plan, nullptr) + job.inputs_key;
  RenderOutcome outcome;
  Draughtsman draughtsman(plan, scene);
  Progress progress(job.name + ": turntable", job.pictures, 0.0, progress_mode(job.talk, job.part));
  for (int i = 0; i < job.pictures; ++i) {
    progress.update(i, fmt::format("picture {}", i + 1));
    if (i % job.parts != job.part)
      continue;
    if (stop_requested())
      return stopped_by_signal(fmt::format("picture {} is the next to draw", i + 1));
    PictureJob picture;
    picture.path = job.folder / fmt::format("{}.{:04}.png", job.name, i + 1);
    picture.inputs = sha256_of_bytes(fmt::format("{} {} {}/{}", settings, job.view, i, job.pictures));
    if (is_up_to_date(picture)) {
      ++outcome.kept;
      continue;
    }
    picture.picture.view = job.view;
    picture.picture.orbit_turns = render::turntable_turns(i, job.pictures);
    picture.texts = {{"wry:turntable", fmt::format("{}/{}", i + 1, job.pictures)}};
    if (Status status = draughtsman.draw(frame, std::move(picture)); !status)
      return status.error();
    ++outcome.drawn;
  }
  progress.update(job.pictures, "done");
  return outcome;
}

Status encode_film(const std::vector<fs::path>& pictures, const fs::path& film, double fps) {
  VideoSettings settings;
  settings.fps = fps;
  const Status status = encode_video(pictures, film, settings);
  if (!status && status.error().code == ErrorCode::unavailable) {
    fmt::print(stderr, "note: no film: {}\n", status.error().message);
    return {};
  }
  return status;
}

} // namespace wry::pipeline
