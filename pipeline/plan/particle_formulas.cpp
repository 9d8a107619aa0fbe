#include "pipeline/plan/particle_formulas.h"

#include <limits>

#include "pipeline/plan/compile_fem.h"
#include "sim/scene/expression.h"

namespace wry::pipeline {

namespace {

/// The attributes of a mesh at a point of its surface, component by component.
void interpolate_attributes(const geometry::SurfaceMesh& mesh, const geometry::ClosestPoint& at,
                            std::vector<double>& values) {
  values.clear();
  for (const geometry::VertexAttribute& attribute : mesh.attributes) {
    for (int component = 0; component < attribute.components; ++component) {
      double value = 0.0;
      for (int corner = 0; corner < 3; ++corner) {
        const auto vertex = static_cast<std::size_t>(mesh.triangles(at.triangle, corner));
        value += at.barycentric[corner] * attribute.values[vertex * static_cast<std::size_t>(attribute.components) +
                                                           static_cast<std::size_t>(component)];
      }
      values.push_back(value);
    }
  }
}

} // namespace

ParticleFormulas::ParticleFormulas(const geometry::SurfaceMesh& surface) {
  if (surface.attributes.empty())
    return;
  m_names = scene::component_names(surface.attributes);
  m_surface = std::make_shared<const geometry::ClosestPointTree>(surface);
}

Result<ParticleFormula> ParticleFormulas::compile(const shots::Located<shots::Expression>& expression) const {
  if (expression->constant)
    return ParticleFormula([value = *expression->constant](const Vec3&) { return value; });
  Result<scene::Expression> compiled = scene::Expression::compile(expression->text, m_names);
  if (!compiled)
    return at_source(expression.source, compiled.error());
  const auto shared = std::make_shared<scene::Expression>(std::move(*compiled));
  bool uses_attributes = false;
  for (const std::string& name : m_names)
    uses_attributes = uses_attributes || shared->uses(name);
  return ParticleFormula([shared, names = m_names.size(), surface = m_surface, uses_attributes](const Vec3& point) {
    scene::ExpressionPoint at;
    at.position = point;
    std::vector<double> attributes(names, 0.0);
    if (uses_attributes)
      interpolate_attributes(surface->mesh(), surface->closest(point), attributes);
    at.attributes = attributes;
    const Result<double> value = shared->evaluate(at);
    return value ? *value : std::numeric_limits<double>::quiet_NaN();
  });
}

} // namespace wry::pipeline
