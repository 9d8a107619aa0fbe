#include <algorithm>

#include <fmt/format.h>

#include "pipeline/cli/shot_session.h"
#include "pipeline/cli/verb.h"
#include "pipeline/export/exporter.h"
#include "pipeline/plan/drawn_surfaces.h"

namespace wry::pipeline {

namespace {

char up_letter(shots::Axis axis) {
  return axis == shots::Axis::x ? 'x' : axis == shots::Axis::y ? 'y' : 'z';
}

/// The formats that --to names.
Result<std::vector<const Exporter*>> formats_of(const std::string& words) {
  std::vector<const Exporter*> chosen;
  std::string known;
  for (const Exporter& exporter : exporters())
    known += (known.empty() ? "" : ", ") + std::string(exporter.name);
  std::size_t begin = 0;
  while (begin <= words.size()) {
    const std::size_t end = std::min(words.find(',', begin), words.size());
    const std::string word = words.substr(begin, end - begin);
    const auto exporter =
        std::find_if(exporters().begin(), exporters().end(), [&](const Exporter& e) { return e.name == word; });
    if (exporter == exporters().end())
      return make_error(ErrorCode::usage, "--to {}: there is no such format; expected one or more of {}{}", word, known,
                        word == "abc" ? "; Alembic is not in Debian 12, usda carries the same" : "");
    chosen.push_back(&*exporter);
    begin = end + 1;
  }
  return chosen;
}

} // namespace

Status export_verb(const Invocation& invocation) {
  const Result<std::vector<const Exporter*>> formats = formats_of(invocation.to);
  if (!formats)
    return formats.error();
  const Result<ShotSession> session = open_session(invocation);
  if (!session)
    return session.error();
  const Result<FrameCache> cache = FrameCache::open_to_read(session->out / "frames");
  if (!cache)
    return cache.error();
  const Result<SceneStatic> scene = cache->read_static();
  if (!scene)
    return scene.error();
  const Result<DrawnSurfaces> surfaces = DrawnSurfaces::create(session->shot, *scene);
  if (!surfaces)
    return surfaces.error();
  for (const int frame : session->frames) {
    if (!cache->has_frame(frame))
      return make_error(ErrorCode::missing_input, "frame {} is not in {}; run `wry simulate {}` first", frame,
                        (session->out / "frames").string(), invocation.subject);
  }
  for (const Exporter* exporter : *formats) {
    ExportJob job{*cache,
                  *scene,
                  surfaces->scene(),
                  [&](const Frame& frame) { return surfaces->carry(frame); },
                  session->out / "frames",
                  session->out / "exports" / exporter->name,
                  *session->shot.shot.name,
                  session->frames,
                  session->shot.shot.frames->first(),
                  *session->shot.shot.fps,
                  up_letter(*session->shot.shot.up)};
    if (Status status = prepare_folder(job.folder); !status)
      return status;
    if (Status status = exporter->write(job); !status)
      return status;
    if (!invocation.quiet)
      fmt::print("{}: {} frames in {}\n", exporter->name, job.frames.size(), job.folder.string());
  }
  return {};
}

} // namespace wry::pipeline
