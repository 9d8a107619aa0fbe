#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cache/frame_cache.h"
#include "pipeline/plan/compile_render.h"
#include "pipeline/plan/drawn_surfaces.h"
#include "shots/shot.h"

namespace wry::pipeline {

/// How pictures are drawn; none of it changes them.
struct RenderOptions {
  std::filesystem::path out;
  std::vector<int> frames; ///< that are asked for
  render::GlBackend backend = render::GlBackend::automatic;
  enum class Frames { cached, follow } source = Frames::cached; ///< follow: waits for frames that are being simulated
  int part = 0, parts = 1; ///< this process draws every parts'th picture, beginning with number `part`
  enum class Talk { normal, quiet } talk = Talk::normal;
};

struct RenderOutcome {
  int drawn = 0;
  int kept = 0; ///< were there, decoded, and came from the same inputs
};

/// Bounds and heat ranges of the whole cached sequence; bounds of the frames `only`, unless it is empty. Errors:
/// missing_input when it has no frame, io.
Result<SequenceFacts> gather_sequence(const shots::Shot& shot, const FrameCache& cache,
                                      const std::vector<int>& only = {});

/// Draws every view of every frame that is not there yet. Errors: missing_input for a frame that is not in the cache;
/// unavailable without OpenGL; stopped; cannot_write, io.
Result<RenderOutcome> render_frames(const shots::Shot& shot, const RenderOptions& options);

/// images/<shot>.<view>.0001.png
std::filesystem::path picture_path(const std::filesystem::path& out, const std::string& shot, const std::string& view,
                                   int frame);

/// Draws one turn around a frame (or around a bare mesh) into `folder` as <name>.0001.png ... Pictures that are there
/// from the same inputs are kept.
struct TurntableJob {
  std::filesystem::path folder;
  std::string name;
  std::string view = "beauty";
  std::string inputs_key; ///< hash of what is drawn
  int pictures = 96;
  int part = 0, parts = 1;
  RenderOptions::Talk talk = RenderOptions::Talk::normal;
};
Result<RenderOutcome> render_turntable(render::RenderPlan plan, const SceneStatic& scene, const Frame& frame,
                                       const TurntableJob& job);

/// The same, with the sequence playing over and over while it turns: picture i shows frame i of the cache.
Result<RenderOutcome> render_moving_turntable(render::RenderPlan plan, const DrawnSurfaces& surfaces,
                                              const FrameCache& cache, const TurntableJob& job);

/// One picture of up to 24 frames of a view, evenly spread, each with its number: images/<shot>.<view>.sheet.png.
Status write_contact_sheet(const shots::Shot& shot, const std::filesystem::path& out, const std::string& view,
                           const std::vector<int>& frames);

/// Whether a process holds the output folder's lock, so that frames may still come.
bool is_being_simulated(const std::filesystem::path& out);

/// The film of a sequence of pictures; only a note on stderr where there is no ffmpeg. Errors: as encode_video().
Status encode_film(const std::vector<std::filesystem::path>& pictures, const std::filesystem::path& film, double fps);

} // namespace wry::pipeline
