#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "shots/shot.h"
#include "sim/base/result.h"
#include "sim/geometry/closest_point_tree.h"
#include "sim/geometry/surface_mesh.h"

namespace wry::pipeline {

/// A formula at the place where a particle starts [m]; not a number where it has no value.
using ParticleFormula = std::function<double(const Vec3&)>;

/// Formulas of a body of particles: of X, Y, Z, and of the attributes of the artist's mesh that it fills. A particle
/// takes an attribute from the nearest point of the mesh's surface.
class ParticleFormulas {
public:
  /// Of a body that fills a part of space: there are no attributes.
  ParticleFormulas() = default;
  /// Of a body that fills this surface.
  explicit ParticleFormulas(const geometry::SurfaceMesh& surface);

  /// Errors: bad_input with the key's line; an unknown name is answered with the nearest known one.
  Result<ParticleFormula> compile(const shots::Located<shots::Expression>& expression) const;

private:
  std::vector<std::string> m_names;                            ///< of the components of the attributes
  std::shared_ptr<const geometry::ClosestPointTree> m_surface; ///< null without attributes
};

} // namespace wry::pipeline
