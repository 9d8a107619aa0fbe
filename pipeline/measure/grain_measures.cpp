#include "pipeline/measure/grain_measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "pipeline/measure/pile_measures.h"
#include "sim/geometry/closest_point_tree.h"
#include "sim/scene/collider_field.h"
#include "sim/scene/distance_bounds.h"

namespace wry::pipeline {

namespace {

constexpr double NOTHING = std::numeric_limits<double>::quiet_NaN();
constexpr double FAR = std::numeric_limits<double>::infinity();
constexpr double STILL = 0.02; ///< [m/s]

const FrameBody* grains_of(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame) {
  const std::string name = scene.bodies[plan.body].name + ".grains";
  for (const FrameBody& body : frame.bodies) {
    if (body.name == name)
      return &body;
  }
  return nullptr;
}

} // namespace

struct DrawnColliders::Surface {
  std::shared_ptr<const scene::Collider> collider;
  std::unique_ptr<geometry::ClosestPointTree> tree;          ///< of closed meshes
  std::unique_ptr<const scene::DistanceBounds> lower_bounds; ///< of the distance to `tree`
  std::optional<scene::ColliderField> field;                 ///< of shapes exact by formula, meshes that deform
  scene::ObstacleBounds bounds;

  /// `now`: of what deforms, as it is at the time.
  double distance(const Vec3& at_rest, double reach, const scene::ColliderField* now) const {
    const Vec3 beyond = (bounds.low - at_rest).cwiseMax(at_rest - bounds.high);
    if (beyond.maxCoeff() > reach || (lower_bounds && lower_bounds->around(at_rest).least > reach))
      return FAR;
    return tree ? tree->signed_distance(at_rest) : (now != nullptr ? *now : *field).distance({}, at_rest);
  }
};

DrawnColliders::DrawnColliders(std::vector<std::shared_ptr<const scene::Collider>> colliders) {
  for (std::shared_ptr<const scene::Collider>& collider : colliders) {
    auto surface = std::make_unique<Surface>();
    surface->bounds = scene::obstacle_bounds(collider->shape);
    const auto* mesh = std::get_if<scene::MeshObstacle>(&collider->shape);
    if (mesh != nullptr && mesh->closed && !mesh->sequence) {
      constexpr double CUBES_ALONG_DIAGONAL = 150.0;
      surface->tree = std::make_unique<geometry::ClosestPointTree>(*mesh->mesh);
      const scene::ObstacleBounds& box = surface->bounds;
      surface->lower_bounds = std::make_unique<const scene::DistanceBounds>(
          scene::Cubes(box.low, box.high, (box.high - box.low).norm() / CUBES_ALONG_DIAGONAL), 1.0,
          [tree = surface->tree.get()](const Vec3& centre) { return tree->signed_distance(centre); });
    } else {
      Result<scene::ColliderField> field = scene::ColliderField::create(collider, {});
      if (!field)
        continue; // nothing that could be drawn
      surface->field = std::move(*field);
    }
    surface->collider = std::move(collider);
    m_surfaces.push_back(std::move(surface));
  }
}

DrawnColliders::~DrawnColliders() = default;

class DrawnColliders::At {
public:
  At(const DrawnColliders& colliders, double time)
      : m_colliders(colliders) {
    for (const auto& surface : colliders.m_surfaces) {
      m_poses.push_back(surface->collider->motion.pose(time));
      m_deformed.emplace_back();
      if (surface->collider->sequence() == nullptr)
        continue;
      m_deformed.back() = surface->field;
      m_deformed.back()->deform_to(time);
    }
  }
  double distance(const Vec3& point, double reach) const {
    double nearest = FAR;
    for (std::size_t i = 0; i < m_poses.size(); ++i)
      nearest = std::min(nearest, m_colliders.m_surfaces[i]->distance(m_poses[i].apply_inverse(point), reach,
                                                                      m_deformed[i] ? &*m_deformed[i] : nullptr));
    return nearest;
  }

private:
  const DrawnColliders& m_colliders;
  std::vector<scene::Pose> m_poses;
  std::vector<std::optional<scene::ColliderField>> m_deformed; ///< of those that deform
};

double grains_inside(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame) {
  const FrameBody* grains = grains_of(plan, scene, frame);
  if (grains == nullptr || plan.drawn_colliders == nullptr)
    return NOTHING;
  const DrawnColliders::At colliders(*plan.drawn_colliders, frame.time);
  const PointMap positions = point_channel(*grains, "position");
  double count = 0.0;
  for (Eigen::Index i = 0; i < positions.rows(); ++i)
    count += colliders.distance(positions.row(i), 0.0) < 0.0 ? 1.0 : 0.0;
  return count;
}

namespace {

/// Grains by cells of space, to find those beneath one.
class GrainCells {
public:
  GrainCells(const PointMap& positions, double side)
      : m_positions(positions)
      , m_side(side) {
    for (Eigen::Index i = 0; i < positions.rows(); ++i)
      m_cells[key(cell_of(positions.row(i)))].push_back(i);
  }
  /// Whether another grain's middle is lower, within `side` of this one.
  bool has_beneath(Eigen::Index grain, const Vec3& up) const {
    const Vec3 point = m_positions.row(grain);
    const std::array<std::int64_t, 3> cell = cell_of(point);
    for (int n = 0; n < 27; ++n) {
      const auto found = m_cells.find(key({cell[0] + n / 9 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n % 3 - 1}));
      if (found == m_cells.end())
        continue;
      for (const Eigen::Index other : found->second) {
        const Vec3 away = m_positions.row(other).transpose() - point;
        if (other != grain && away.dot(up) < -0.05 * m_side && away.squaredNorm() < m_side * m_side)
          return true;
      }
    }
    return false;
  }

private:
  std::array<std::int64_t, 3> cell_of(const Vec3& point) const {
    const auto along = [&](int axis) { return static_cast<std::int64_t>(std::floor(point[axis] / m_side)); };
    return {along(0), along(1), along(2)};
  }
  static std::uint64_t key(const std::array<std::int64_t, 3>& cell) {
    constexpr std::uint64_t MASK = (1u << 21) - 1; // two million cells along each axis, beyond them around again
    std::uint64_t packed = 0;
    for (const std::int64_t along : cell)
      packed = packed << 21 | (static_cast<std::uint64_t>(along) & MASK);
    return packed;
  }

  const PointMap& m_positions;
  double m_side;
  std::unordered_map<std::uint64_t, std::vector<Eigen::Index>> m_cells;
};

} // namespace

double grain_hover(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame) {
  const FrameBody* grains = grains_of(plan, scene, frame);
  if (grains == nullptr || plan.drawn_colliders == nullptr)
    return NOTHING;
  const PointMap positions = point_channel(*grains, "position"), velocities = point_channel(*grains, "velocity"),
                 sizes = point_channel(*grains, "size");
  if (positions.rows() == 0 || velocities.rows() != positions.rows() || sizes.rows() != positions.rows())
    return NOTHING;
  const DrawnColliders::At colliders(*plan.drawn_colliders, frame.time);
  const double length = sizes.rowwise().maxCoeff().mean();
  const GrainCells cells(positions, length);
  std::vector<double> gaps;
  for (Eigen::Index i = 0; i < positions.rows(); ++i) {
    if (velocities.row(i).norm() > STILL || cells.has_beneath(i, plan.up))
      continue;
    const double gap = colliders.distance(positions.row(i), 10.0 * length) - 0.5 * sizes.row(i).minCoeff();
    gaps.push_back(std::clamp(gap, 0.0, 10.0 * length));
  }
  if (gaps.empty())
    return 0.0;
  const auto most = gaps.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(gaps.size() - 1));
  std::nth_element(gaps.begin(), most, gaps.end());
  return *most;
}

} // namespace wry::pipeline
