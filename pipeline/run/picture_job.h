#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "render/png.h"
#include "render/renderer.h"

namespace wry::pipeline {

/// A picture that is wanted: where it goes, what it is made from.
struct PictureJob {
  std::filesystem::path path;
  std::vector<std::string> layers; ///< of an OpenEXR file beside it; empty: none
  std::string inputs;              ///< SHA-256 of everything that it depends on
  render::Picture picture;
  std::vector<render::PngText> texts;
};

/// Whether the picture, and the OpenEXR file beside it if there is to be one, decode and are of these inputs.
bool is_up_to_date(const PictureJob& job);

/// Draws pictures one after the other with one context, made when the first picture is really needed. `plan` and
/// `scene` must outlive it.
class Draughtsman {
public:
  Draughtsman(const render::RenderPlan& plan, const SceneStatic& scene)
      : m_plan(plan)
      , m_scene(scene) {}

  /// Errors: those of the renderer; io when a file cannot be written.
  Status draw(const Frame& frame, PictureJob job);

private:
  /// Linear light with the data of each pixel.
  Status write_layers(const Frame& frame, const PictureJob& job);

  const render::RenderPlan& m_plan;
  const SceneStatic& m_scene;
  std::optional<render::Renderer> m_renderer;
};

} // namespace wry::pipeline
