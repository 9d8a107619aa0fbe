#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "pipeline/assets/mesh_import.h"
#include "pipeline/cache/atomic_file.h"
#include "pipeline/cache/sha256.h"
#include "pipeline/cli/shot_session.h"
#include "pipeline/cli/verb.h"
#include "pipeline/plan/compile_appearance.h"
#include "pipeline/plan/compile_camera.h"
#include "pipeline/run/render_frames.h"
#include "render/mesh_scene.h"
#include "shots/resolved.h"

namespace wry::pipeline {

namespace {

namespace fs = std::filesystem;

constexpr int MESH_PICTURES = 96;
constexpr double FILM_FPS = 24.0;

/// Frames that play while their scene turns.
struct MovingSubject {
  FrameCache cache;
  DrawnSurfaces surfaces;
};

/// What turns: a scene on one frame, and how it is drawn.
struct Subject {
  render::RenderPlan plan;
  SceneStatic scene;
  Frame frame;
  TurntableJob job;
  std::optional<MovingSubject> moving; ///< the frames that play while it turns; absent: `frame` stands still
};

Result<Subject> shot_subject(const ShotSession& session, const Invocation& invocation, render::GlBackend backend) {
  Result<FrameCache> cache = FrameCache::open_to_read(session.out / "frames");
  if (!cache)
    return cache.error();
  const std::vector<CachedFrame> frames = cache->frames();
  if (frames.empty())
    return make_error(ErrorCode::missing_input, "{} has no frames yet; run `wry simulate` first", session.out.string());
  const shots::Turntable& turntable = session.shot.render.turntable;
  int number = frames.back().number;
  if (invocation.turntable_frame > 0)
    number = invocation.turntable_frame;
  else if (turntable.frame)
    number = static_cast<int>(**turntable.frame);
  Result<Frame> frame = cache->read_frame(number);
  if (!frame)
    return frame.error();
  Result<SceneStatic> scene = cache->read_static();
  if (!scene)
    return scene.error();
  dress_scene(session.shot, *scene);
  SequenceFacts facts;
  facts.heat.resize(session.shot.render.views.size());
  if (Status status = facts.bounds.include(*scene, *frame); !status)
    return status.error();
  const bool moving = *turntable.moving && invocation.turntable_frame == 0;
  if (moving) {
    Result<SequenceFacts> all = gather_sequence(session.shot, *cache);
    if (!all)
      return all.error();
    facts = std::move(*all);
  }
  const Result<CameraMotion> camera = CameraMotion::create(session.shot, *scene, facts.bounds);
  if (!camera)
    return camera.error();
  Result<render::RenderPlan> plan = compile_render(session.shot, facts, camera->plan(), backend);
  if (!plan)
    return plan.error();
  auto appearances = compile_appearances(session.shot, *scene);
  if (!appearances)
    return appearances.error();
  plan->appearances = std::move(*appearances);
  Result<DrawnSurfaces> surfaces = DrawnSurfaces::create(session.shot, *scene);
  if (!surfaces)
    return surfaces.error();
  plan->appearances.insert(surfaces->appearances().begin(), surfaces->appearances().end());
  TurntableJob job;
  job.folder = session.out / "turntable";
  job.name = fmt::format("{}.{:04}", *session.shot.shot.name, number);
  job.pictures = static_cast<int>(*turntable.frames);
  if (moving)
    job.name = *session.shot.shot.name;
  for (const CachedFrame& cached : frames)
    job.inputs_key += moving || cached.number == number ? cached.sha256 : "";
  for (const shots::FlatKey& key : shots::flatten(session.shot))
    job.inputs_key += key.effect == shots::Effect::pictures ? key.key + "=" + key.value + " " : "";
  Subject subject{std::move(*plan), surfaces->scene(), surfaces->carry(*frame), std::move(job), std::nullopt};
  if (moving)
    subject.moving.emplace(MovingSubject{std::move(*cache), std::move(*surfaces)});
  return subject;
}

Result<Subject> mesh_subject(const Invocation& invocation, render::GlBackend backend) {
  const fs::path path = invocation.subject;
  for (const auto& [option, given] :
       {std::pair("--set", !invocation.sets.empty()), std::pair("--case", !invocation.wedge.empty()),
        std::pair("--frames", !invocation.frames.empty())}) {
    if (given)
      return make_error(
          ErrorCode::usage,
          "{} is for shots, and {} is a mesh with no shot: write a shot with this mesh as a body to use it", option,
          path.filename().string());
  }
  const Result<ImportedMesh> imported = import_mesh(path.string());
  if (!imported)
    return imported.error();
  const std::string name = path.stem().string();
  render::MeshScene scene = render::make_mesh_scene(imported->mesh, name, "clay");
  Subject subject;
  subject.plan.bounds = scene.bounds;
  subject.plan.backend = backend;
  subject.plan.looks = render::built_in_looks();
  if (imported->appearance)
    subject.plan.appearances[name] = std::make_shared<render::MeshAppearance>(*imported->appearance);
  for (const std::string& note :
       invocation.part.empty() && !invocation.quiet ? imported->notes : std::vector<std::string>())
    fmt::print(stderr, "note: {}: {}\n", path.filename().string(), note);
  subject.scene = std::move(scene.scene);
  subject.frame = std::move(scene.frame);
  subject.job.folder = (invocation.out.empty() ? fs::path("out") / name : fs::path(invocation.out)) / "turntable";
  subject.job.name = name;
  subject.job.pictures = MESH_PICTURES;
  const Result<std::string> hash = sha256_of_file(path);
  if (!hash)
    return hash.error();
  subject.job.inputs_key = *hash;
  return subject;
}

Status draw_in_processes(const Invocation& invocation, int processes) {
  std::vector<std::vector<std::string>> command_lines;
  for (int part = 0; part < processes; ++part) {
    std::vector<std::string> words = {"turntable"};
    words.insert(words.end(), invocation.original_arguments.begin(), invocation.original_arguments.end());
    words.push_back("--part");
    words.push_back(fmt::format("{}/{}", part, processes));
    command_lines.push_back(std::move(words));
  }
  return run_self_to_success(command_lines);
}

} // namespace

Status turntable_verb(const Invocation& invocation) {
  const Result<render::GlBackend> backend = render::parse_gl_backend(invocation.gl);
  if (!backend)
    return backend.error();
  const bool is_shot = fs::path(invocation.subject).extension() == ".toml";
  Result<Subject> subject = make_error(ErrorCode::usage, "nothing to turn");
  if (is_shot) {
    const Result<ShotSession> session = open_session(invocation);
    if (!session)
      return session.error();
    subject = shot_subject(*session, invocation, *backend);
  } else {
    subject = mesh_subject(invocation, *backend);
  }
  if (!subject)
    return subject.error();
  TurntableJob& job = subject->job;
  job.talk = invocation.quiet ? RenderOptions::Talk::quiet : RenderOptions::Talk::normal;
  job.view = subject->plan.views.front().name;
  if (!invocation.part.empty()) {
    if (std::sscanf(invocation.part.c_str(), "%d/%d", &job.part, &job.parts) != 2 || job.parts < 1)
      return make_error(ErrorCode::usage, "--part {}: expected i/n", invocation.part);
    const Result<RenderOutcome> outcome =
        subject->moving ? render_moving_turntable(subject->plan, subject->moving->surfaces, subject->moving->cache, job)
                        : render_turntable(subject->plan, subject->scene, subject->frame, job);
    return outcome ? Status() : Status(outcome.error());
  }
  if (Status status = prepare_folder(job.folder); !status)
    return status;
  if (Status status = draw_in_processes(invocation, rendering_processes(invocation, job.pictures)); !status)
    return status;
  std::vector<fs::path> pictures;
  for (int i = 1; i <= job.pictures; ++i)
    pictures.push_back(job.folder / fmt::format("{}.{:04}.png", job.name, i));
  if (Status status = encode_film(pictures, job.folder / (job.name + ".mp4"), FILM_FPS); !status)
    return status;
  if (!invocation.quiet)
    fmt::print("turntable: {}\n", job.folder.string());
  return {};
}

} // namespace wry::pipeline
