#include "pipeline/run/render_frames.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cache/sha256.h"
#include "pipeline/plan/build_id.h"
#include "pipeline/plan/compile_appearance.h"
#include "pipeline/plan/compile_camera.h"
#include "pipeline/plan/drawn_surfaces.h"
#include "pipeline/run/picture_job.h"
#include "pipeline/run/progress.h"
#include "pipeline/run/signals.h"
#include "pipeline/run/video.h"
#include "render/contact_sheet.h"
#include "render/png.h"
#include "shots/resolved.h"

namespace wry::pipeline {

namespace {

namespace fs = std::filesystem;

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
  for (const shots::Body& body : shot != nullptr ? shot->bodies : std::vector<shots::Body>()) {
    if (const auto* mesh = std::get_if<shots::MeshShape>(&body.shape)) {
      const Result<std::string> hash = sha256_of_file(*mesh->path);
      text += " " + (hash ? *hash : hash.error().message);
    }
  }
  if (shot != nullptr && shot->render.lights.image) {
    const Result<std::string> hash = sha256_of_file(**shot->render.lights.image);
    text += " " + (hash ? *hash : hash.error().message);
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

/// Whether a view is about the elements: their edges, or values that they or their vertices have.
bool shows_elements(const render::View& view) {
  return view.colouring == render::Colouring::heat || view.wire != render::Wire::none ||
         view.signs != render::Signs::none;
}

Progress::Mode progress_mode(RenderOptions::Talk talk, int part) {
  return talk == RenderOptions::Talk::quiet || part != 0 ? Progress::Mode::quiet : Progress::Mode::automatic;
}

} // namespace

fs::path picture_path(const fs::path& out, const std::string& shot, const std::string& view, int frame) {
  return out / "images" / fmt::format("{}.{}.{:04}.png", shot, view, frame);
}

Result<SequenceFacts> gather_sequence(const shots::Shot& shot, const FrameCache& cache, const std::vector<int>& only) {
  Result<SceneStatic> scene = cache.read_static();
  if (!scene)
    return scene.error();
  dress_scene(shot, *scene);
  SequenceFacts facts;
  for (const CachedFrame& cached : cache.frames()) {
    if (!only.empty() && std::find(only.begin(), only.end(), cached.number) == only.end())
      continue;
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

bool is_being_simulated(const fs::path& out) {
  const int file = ::open((out / "lock").c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0)
    return false;
  const bool held = ::flock(file, LOCK_SH | LOCK_NB) != 0;
  ::close(file);
  return held;
}

namespace {

const CachedFrame* find_frame(const std::vector<CachedFrame>& frames, int number) {
  const auto found =
      std::find_if(frames.begin(), frames.end(), [&](const CachedFrame& frame) { return frame.number == number; });
  return found != frames.end() ? &*found : nullptr;
}

Error not_cached(int number, const fs::path& out) {
  return make_error(ErrorCode::missing_input, "frame {} is not in the cache {}; simulate it first", number,
                    (out / "frames").string());
}

/// Waits for a frame that is being simulated. Errors: missing_input when nobody simulates any more; stopped.
Status wait_for_frame(FrameCache& cache, int number, const fs::path& out) {
  constexpr int GRACE = 20; // looks, half a second apart, at a folder that nobody holds: the simulation may be about to
                            // begin or just have ended
  for (int idle = 0; idle < GRACE;) {
    if (Status status = cache.refresh(); !status)
      return status;
    if (cache.has_frame(number))
      return {};
    if (stop_requested())
      return stopped_by_signal(fmt::format("frame {} is the next to draw", number));
    idle = is_being_simulated(out) ? 0 : idle + 1;
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
  return not_cached(number, out);
}

render::RenderPlan
with_appearances(render::RenderPlan plan,
                 const std::map<std::string, std::shared_ptr<const render::MeshAppearance>>& appearances) {
  plan.appearances.insert(appearances.begin(), appearances.end());
  return plan;
}

/// The whole of one run of render_frames().
class SequenceDrawing {
public:
  SequenceDrawing(const shots::Shot& shot, const RenderOptions& options, FrameCache& cache, const SceneStatic& scene,
                  const DrawnSurfaces& surfaces, const render::RenderPlan& plan, const CameraMotion& camera)
      : m_shot(shot)
      , m_options(options)
      , m_cache(cache)
      , m_plan(plan)
      , m_camera(camera)
      , m_surfaces(surfaces)
      , m_shape_plan(with_appearances(plan, surfaces.appearances()))
      , m_settings(fingerprint(plan, &shot))
      , m_elements(plan, scene)
      , m_shapes(m_shape_plan, surfaces.scene()) {}

  Status draw_frame(int number) {
    if (m_options.source == RenderOptions::Frames::follow) {
      if (Status status = wait_for_frame(m_cache, number, m_options.out); !status)
        return status;
    }
    const std::vector<CachedFrame> cached = m_cache.frames();
    const CachedFrame* entry = find_frame(cached, number);
    if (entry == nullptr)
      return not_cached(number, m_options.out);
    std::optional<Frame> frame;
    for (const render::View& view : m_plan.views) {
      if (stop_requested())
        return stopped_by_signal(fmt::format("frame {} is the next to draw", number));
      if (Status status = draw_view(view, *entry, frame); !status)
        return status;
    }
    return {};
  }

  const RenderOutcome& outcome() const { return m_outcome; }

private:
  Status draw_view(const render::View& view, const CachedFrame& entry, std::optional<Frame>& frame) {
    PictureJob job;
    job.path = picture_path(m_options.out, *m_shot.shot.name, view.name, entry.number);
    job.inputs = sha256_of_bytes(entry.sha256 + " " + view.name + " " + m_settings);
    if (view.name == "beauty") {
      for (const shots::Located<std::string>& layer : m_shot.render.exr)
        job.layers.push_back(*layer);
    }
    if (is_up_to_date(job)) {
      ++m_outcome.kept;
      return {};
    }
    if (!frame) {
      Result<Frame> read = m_cache.read_frame(entry.number);
      if (!read)
        return read.error();
      frame = std::move(*read);
    }
    job.picture.view = view.name;
    job.picture.slate = slate_lines(m_shot, *frame);
    if (m_camera.moves()) {
      Result<render::CameraPlan> camera = m_camera.at(*frame);
      if (!camera)
        return camera.error();
      job.picture.camera = std::move(*camera);
    }
    job.texts = {{"wry:shot", *m_shot.shot.name},
                 {"wry:frame", std::to_string(entry.number)},
                 {"wry:time", fmt::format("{}", frame->time)},
                 {"wry:view", view.name},
                 {"wry:frame_sha256", entry.sha256}};
    const Status status = shows_elements(view) ? m_elements.draw(*frame, std::move(job))
                                               : m_shapes.draw(m_surfaces.carry(*frame), std::move(job));
    if (!status)
      return status;
    ++m_outcome.drawn;
    return {};
  }

  const shots::Shot& m_shot;
  const RenderOptions& m_options;
  FrameCache& m_cache;
  const render::RenderPlan& m_plan;
  const CameraMotion& m_camera;
  const DrawnSurfaces& m_surfaces;
  render::RenderPlan m_shape_plan;
  std::string m_settings;
  Draughtsman m_elements, m_shapes;
  RenderOutcome m_outcome;
};

/// While frames are still to come their reach is not known: room is left about what is there.
void leave_room(render::SubjectBounds& bounds) {
  constexpr double ROOM = 1.25;
  const Vec3 centre = bounds.centre();
  render::SubjectBounds wider = bounds;
  wider.include(Points(((bounds.outline().rowwise() - centre.transpose()) * ROOM).rowwise() + centre.transpose()));
  bounds = wider;
}

} // namespace

Result<RenderOutcome> render_frames(const shots::Shot& shot, const RenderOptions& options) {
  Result<FrameCache> cache = FrameCache::open_to_read(options.out / "frames");
  if (!cache)
    return cache.error();
  const bool follows = options.source == RenderOptions::Frames::follow;
  if (follows && !options.frames.empty()) {
    // The first frame alone settles the framing, so that it is the same for every process and every frame to come.
    if (Status status = wait_for_frame(*cache, options.frames.front(), options.out); !status)
      return status.error();
  }
  const std::vector<int> framed = follows ? std::vector<int>{options.frames.front()} : std::vector<int>{};
  Result<SequenceFacts> facts = gather_sequence(shot, *cache, framed);
  if (!facts)
    return facts.error();
  if (follows)
    leave_room(facts->bounds);
  Result<SceneStatic> scene = cache->read_static();
  if (!scene)
    return scene.error();
  dress_scene(shot, *scene);
  const Result<CameraMotion> camera = CameraMotion::create(shot, *scene, facts->bounds);
  if (!camera)
    return camera.error();
  Result<render::RenderPlan> plan = compile_render(shot, *facts, camera->plan(), options.backend);
  if (!plan)
    return plan.error();
  auto appearances = compile_appearances(shot, *scene);
  if (!appearances)
    return appearances.error();
  plan->appearances = std::move(*appearances);
  const Result<DrawnSurfaces> surfaces = DrawnSurfaces::create(shot, *scene);
  if (!surfaces)
    return surfaces.error();
  if (options.talk != RenderOptions::Talk::quiet && options.part == 0) {
    for (const std::string& note : surfaces->notes())
      fmt::print(stderr, "note: {}\n", note);
  }
  if (Status status = prepare_folder(options.out / "images"); !status)
    return status.error();
  SequenceDrawing drawing(shot, options, *cache, *scene, *surfaces, *plan, *camera);
  Progress progress(*shot.shot.name + ": render", static_cast<double>(options.frames.size()), 0.0,
                    progress_mode(options.talk, options.part));
  for (std::size_t i = 0; i < options.frames.size(); ++i) {
    progress.update(static_cast<double>(i), fmt::format("frame {}", options.frames[i]));
    if (static_cast<int>(i) % options.parts != options.part)
      continue;
    if (Status status = drawing.draw_frame(options.frames[i]); !status)
      return status.error();
  }
  progress.update(static_cast<double>(options.frames.size()), "done");
  return drawing.outcome();
}

namespace {

/// One turn, where `frame_of` gives what picture i shows.
Result<RenderOutcome> draw_turn(render::RenderPlan plan, const SceneStatic& scene, const TurntableJob& job,
                                const std::function<Result<Frame>(int)>& frame_of) {
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
    const Result<Frame> frame = frame_of(i);
    if (!frame)
      return frame.error();
    if (Status status = draughtsman.draw(*frame, std::move(picture)); !status)
      return status.error();
    ++outcome.drawn;
  }
  progress.update(job.pictures, "done");
  return outcome;
}

} // namespace

Result<RenderOutcome> render_turntable(render::RenderPlan plan, const SceneStatic& scene, const Frame& frame,
                                       const TurntableJob& job) {
  return draw_turn(std::move(plan), scene, job, [&](int) { return Result<Frame>(frame); });
}

Result<RenderOutcome> render_moving_turntable(render::RenderPlan plan, const DrawnSurfaces& surfaces,
                                              const FrameCache& cache, const TurntableJob& job) {
  const std::vector<CachedFrame> frames = cache.frames();
  if (frames.empty())
    return make_error(ErrorCode::missing_input, "there is no frame in the cache; run `wry simulate` first");
  return draw_turn(std::move(plan), surfaces.scene(), job, [&](int i) -> Result<Frame> {
    const Result<Frame> frame = cache.read_frame(frames[static_cast<std::size_t>(i) % frames.size()].number);
    return frame ? Result<Frame>(surfaces.carry(*frame)) : frame.error();
  });
}

Status write_contact_sheet(const shots::Shot& shot, const fs::path& out, const std::string& view,
                           const std::vector<int>& frames) {
  constexpr std::size_t MOST = 24;
  const std::size_t count = std::min(frames.size(), MOST);
  std::vector<render::SheetEntry> entries;
  for (std::size_t i = 0; i < count; ++i) {
    const int number = frames[count > 1 ? i * (frames.size() - 1) / (count - 1) : 0];
    Result<render::PngContents> picture = render::read_png(picture_path(out, *shot.shot.name, view, number));
    if (!picture)
      return picture.error();
    entries.push_back({std::move(picture->image), fmt::format("{}", number)});
  }
  const Result<render::Image> sheet = render::make_contact_sheet(entries);
  if (!sheet)
    return sheet.error();
  return render::write_png(out / "images" / fmt::format("{}.{}.sheet.png", *shot.shot.name, view), *sheet,
                           {{"wry:shot", *shot.shot.name}, {"wry:view", view}});
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
