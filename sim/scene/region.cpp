#include "sim/scene/region.h"

#include <cmath>

#include "sim/scene/expression.h"

namespace wry::scene {

namespace {

using Chosen = Result<std::vector<char>>;

// Everything that the kinds of regions need to choose from.
struct Choice {
  const RestPoints& points;
  const Threads& threads;
  double slack; // [m]

  template <class Inside> Chosen where(const Inside& inside) const {
    std::vector<char> chosen(static_cast<std::size_t>(points.positions.rows()));
    for (std::size_t i = 0; i < chosen.size(); ++i)
      chosen[i] = inside(Vec3(points.positions.row(static_cast<Eigen::Index>(i)).transpose()));
    return chosen;
  }

  Chosen operator()(const BoxRegion& box) const {
    if (!(box.min.array() <= box.max.array()).all())
      return make_error(ErrorCode::bad_input, "a box region needs min <= max; it has ({}, {}, {}) and ({}, {}, {})",
                        box.min.x(), box.min.y(), box.min.z(), box.max.x(), box.max.y(), box.max.z());
    return where([&](const Vec3& p) {
      return (p.array() >= box.min.array() - slack).all() && (p.array() <= box.max.array() + slack).all();
    });
  }

  Chosen operator()(const SphereRegion& sphere) const {
    if (!(sphere.radius > 0))
      return make_error(ErrorCode::bad_input, "a sphere region needs a positive radius; it is {} m", sphere.radius);
    return where([&](const Vec3& p) { return (p - sphere.centre).norm() <= sphere.radius + slack; });
  }

  Chosen operator()(const CylinderRegion& cylinder) const {
    const double length = (cylinder.to - cylinder.from).norm();
    if (!(cylinder.radius > 0) || !(length > 0))
      return make_error(ErrorCode::bad_input,
                        "a cylinder region needs a positive radius and two different ends; radius {} m, length {} m",
                        cylinder.radius, length);
    const Vec3 axis = (cylinder.to - cylinder.from) / length;
    return where([&](const Vec3& p) {
      const double along = (p - cylinder.from).dot(axis);
      const double away = (p - cylinder.from - along * axis).norm();
      return along >= -slack && along <= length + slack && away <= cylinder.radius + slack;
    });
  }

  Chosen operator()(const ExpressionRegion& region) const {
    const Result<Expression> expression = Expression::compile(region.text, component_names(points.attributes));
    if (!expression)
      return expression.error();
    if (expression->uses("t"))
      return make_error(ErrorCode::bad_input, "the region '{}' depends on the time t; regions are chosen once, at rest",
                        region.text);
    const Result<std::vector<double>> values = expression->evaluate_all(points, 0.0, threads);
    if (!values)
      return values.error();
    std::vector<char> chosen(values->size());
    for (std::size_t i = 0; i < chosen.size(); ++i)
      chosen[i] = (*values)[i] != 0;
    return chosen;
  }

  Chosen operator()(const AttributeRegion& region) const {
    std::vector<std::string> names;
    for (const geometry::VertexAttribute& attribute : points.attributes) {
      names.push_back(attribute.name);
      if (attribute.name != region.name)
        continue;
      const auto width = static_cast<std::size_t>(attribute.components);
      std::vector<char> chosen(static_cast<std::size_t>(points.positions.rows()));
      for (std::size_t i = 0; i < chosen.size(); ++i) {
        double squared = 0;
        for (std::size_t k = 0; k < width; ++k)
          squared += attribute.values[i * width + k] * attribute.values[i * width + k];
        chosen[i] = (width == 1 ? attribute.values[i] : std::sqrt(squared)) > region.threshold;
      }
      return chosen;
    }
    return make_error(ErrorCode::bad_input, "the mesh has no attribute '{}'; it has {}", region.name,
                      names.empty() ? std::string("none") : fmt::format("{}", fmt::join(names, ", ")));
  }
};

} // namespace

Result<std::vector<std::int32_t>> select_points(const Region& region, const RestPoints& points,
                                                const Threads& threads) {
  if (points.positions.rows() == 0)
    return make_error(ErrorCode::bad_input, "there are no points to choose a region from");
  const Vec3 lower = points.positions.colwise().minCoeff().transpose();
  const Vec3 upper = points.positions.colwise().maxCoeff().transpose();
  const Chosen chosen = std::visit(Choice{points, threads, 1e-9 * (upper - lower).norm()}, region);
  if (!chosen)
    return chosen.error();
  std::vector<std::int32_t> indices;
  for (std::size_t i = 0; i < chosen->size(); ++i)
    if ((*chosen)[i])
      indices.push_back(static_cast<std::int32_t>(i));
  if (indices.empty())
    return make_error(ErrorCode::bad_input,
                      "no node of the body is in this region; the body spans X {:.6g}..{:.6g}, Y {:.6g}..{:.6g}, Z "
                      "{:.6g}..{:.6g} m",
                      lower.x(), upper.x(), lower.y(), upper.y(), lower.z(), upper.z());
  return indices;
}

} // namespace wry::scene
