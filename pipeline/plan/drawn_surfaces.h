#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "render/mesh_appearance.h"
#include "shots/shot.h"
#include "sim/base/parallel.h"
#include "sim/base/result.h"
#include "sim/geometry/surface_embedding.h"
#include "sim/state/frame.h"

namespace wry::pipeline {

/// The scene as it is shown: bodies that were made from an artist's mesh, a ball or a ring appear as that very surface,
/// carried by the simulated elements, in place of the coarse faces of these elements. Nothing of it is cached: it is
/// made anew from the shot and the frames.
class DrawnSurfaces {
public:
  /// `simulated` is the cache's scene. Errors: as mesh_body() for a file that cannot be read any more; bad_input with
  /// the key's line where the shot insists on the shape (`draw = "shape"`, own_materials) and there is none, or part of
  /// it lies further from the elements than half an edge. Where the shot leaves it open, such bodies keep their
  /// elements and a note says so.
  static Result<DrawnSurfaces> create(const shots::Shot& shot, const SceneStatic& simulated);

  /// `simulated` with the shapes in place of elements; same bodies, same order.
  const SceneStatic& scene() const { return m_scene; }

  /// A frame of the cache for scene(). Carried bodies keep numbers and vectors on vertices; positions follow Phong
  /// deformation.
  Frame carry(const Frame& simulated) const;

  /// What carried bodies wear of their files, by body.
  const std::map<std::string, std::shared_ptr<const render::MeshAppearance>>& appearances() const {
    return m_appearances;
  }

  /// Sentences for the user.
  const std::vector<std::string>& notes() const { return m_notes; }

private:
  struct Carried {
    std::size_t body; ///< of the scene
    geometry::SurfaceEmbedding embedding;
  };

  Status add(const shots::Shot& shot, const shots::Body& body, std::size_t index);

  SceneStatic m_scene;
  std::vector<Carried> m_carried;
  std::map<std::string, std::shared_ptr<const render::MeshAppearance>> m_appearances;
  std::vector<std::string> m_notes;
};

} // namespace wry::pipeline
