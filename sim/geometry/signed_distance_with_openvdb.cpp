#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <new>
#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>
#include <tbb/task_arena.h>

#include "sim/geometry/mesh_checks.h"
#include "sim/geometry/signed_distance.h"

namespace wry::geometry {

namespace {

/// The samples of a level set in one block, where that takes little memory: a walk down OpenVDB's tree for each of
/// eight corners costs ten times the interpolation itself. Same samples, same arithmetic: the same bits.
class DenseSamples {
public:
  static constexpr std::int64_t MOST = 32'000'000; ///< samples; beyond, the tree is read

  explicit DenseSamples(const openvdb::FloatGrid& grid) {
    const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    const openvdb::Coord size = box.dim();
    if (box.empty() || static_cast<std::int64_t>(box.volume()) > MOST)
      return;
    m_low = {static_cast<double>(box.min().x()), static_cast<double>(box.min().y()),
             static_cast<double>(box.min().z())};
    m_size = {size.x(), size.y(), size.z()};
    m_outside = grid.background();
    m_values.resize(static_cast<std::size_t>(box.volume()));
    openvdb::tools::Dense<float, openvdb::tools::LayoutZYX> dense(box, m_values.data());
    openvdb::tools::copyToDense(grid, dense, true);
  }
  bool empty() const { return m_values.empty(); }
  std::size_t bytes() const { return m_values.size() * sizeof(float); }

  /// Trilinear, at a point in voxels.
  float value(const Vec3& index) const {
    std::array<double, 3> along;
    std::array<std::int64_t, 3> at;
    bool is_inner = true, is_near = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const double from_low = index[static_cast<Eigen::Index>(k)] - m_low[k];
      is_near = is_near && from_low >= -1.0 && from_low <= static_cast<double>(m_size[k]);
      if (!is_near)
        return m_outside;
      const double below = std::floor(index[static_cast<Eigen::Index>(k)]);
      along[k] = index[static_cast<Eigen::Index>(k)] - below;
      at[k] = static_cast<std::int64_t>(below - m_low[k]);
      is_inner = is_inner && at[k] >= 0 && at[k] + 1 < m_size[k];
    }
    return is_inner ? interpolate(at, along,
                                  [this](std::int64_t x, std::int64_t y, std::int64_t z) {
                                    return m_values[static_cast<std::size_t>((x * m_size[1] + y) * m_size[2] + z)];
                                  })
                    : interpolate(at, along, [this](std::int64_t x, std::int64_t y, std::int64_t z) {
                        return x < 0 || y < 0 || z < 0 || x >= m_size[0] || y >= m_size[1] || z >= m_size[2]
                                   ? m_outside
                                   : m_values[static_cast<std::size_t>((x * m_size[1] + y) * m_size[2] + z)];
                      });
  }

private:
  static float between(float a, float b, double share) {
    return a + static_cast<float>(static_cast<double>(b - a) * share);
  }
  template <class Sample>
  static float interpolate(const std::array<std::int64_t, 3>& at, const std::array<double, 3>& along,
                           const Sample& sample) {
    const auto row = [&](std::int64_t x, std::int64_t y) {
      return between(sample(x, y, at[2]), sample(x, y, at[2] + 1), along[2]);
    };
    const auto plane = [&](std::int64_t x) { return between(row(x, at[1]), row(x, at[1] + 1), along[1]); };
    return between(plane(at[0]), plane(at[0] + 1), along[0]);
  }

  std::array<double, 3> m_low{};
  std::array<std::int64_t, 3> m_size{};
  float m_outside = 0.0F;
  std::vector<float> m_values;
};

} // namespace

struct SignedDistance::Grid {
  openvdb::FloatGrid::Ptr grid;
  std::optional<DenseSamples> dense; ///< absent: too many, the tree is read
  double voxel = 0, per_voxel = 0;
  Vec3 low, high;
};

namespace {

/// What OpenVDB reads triangles from; positions in voxels.
class TriangleAdapter {
public:
  TriangleAdapter(const SurfaceMesh& surface, const openvdb::math::Transform& transform)
      : m_surface(surface)
      , m_transform(transform) {}
  std::size_t polygonCount() const { return static_cast<std::size_t>(m_surface.triangles.rows()); }
  std::size_t pointCount() const { return static_cast<std::size_t>(m_surface.vertices.rows()); }
  std::size_t vertexCount(std::size_t) const { return 3; }
  void getIndexSpacePoint(std::size_t triangle, std::size_t corner, openvdb::Vec3d& position) const {
    const auto row = m_surface.triangles(static_cast<Eigen::Index>(triangle), static_cast<Eigen::Index>(corner));
    const auto& x = m_surface.vertices;
    position = m_transform.worldToIndex(openvdb::Vec3d(x(row, 0), x(row, 1), x(row, 2)));
  }

private:
  const SurfaceMesh& m_surface;
  const openvdb::math::Transform& m_transform;
};

double surface_area(const SurfaceMesh& surface) {
  double area = 0;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const Vec3 a = surface.vertices.row(surface.triangles(t, 0)).transpose();
    const Vec3 b = surface.vertices.row(surface.triangles(t, 1)).transpose();
    const Vec3 c = surface.vertices.row(surface.triangles(t, 2)).transpose();
    area += (b - a).cross(c - a).norm() / 2;
  }
  return area;
}

Status check(const SurfaceMesh& surface, const SignedDistanceSettings& settings, const Vec3& low, const Vec3& high) {
  if (!(settings.voxel > 0))
    return make_error(ErrorCode::bad_input, "the voxel size is {} m; it must be positive", settings.voxel);
  const double box = ((high - low) / settings.voxel).array().max(1.0).prod();
  const double band = surface_area(surface) / (settings.voxel * settings.voxel) * 2 * (settings.exterior_band + 1);
  if (!(box + band <= static_cast<double>(settings.max_voxels)))
    return make_error(
        ErrorCode::bad_input,
        "a signed distance at {:.4g} m for a body of {:.4g} x {:.4g} x {:.4g} m takes about {:.3g} voxels, the "
        "limit is {:.3g}. Try a larger `resolution`.",
        settings.voxel, high.x() - low.x(), high.y() - low.y(), high.z() - low.z(), box + band,
        static_cast<double>(settings.max_voxels));
  return {};
}

openvdb::FloatGrid::Ptr convert(const SurfaceMesh& surface, const SignedDistanceSettings& settings) {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
  const openvdb::math::Transform::Ptr transform = openvdb::math::Transform::createLinearTransform(settings.voxel);
  const TriangleAdapter adapter(surface, *transform);
  openvdb::FloatGrid::Ptr grid;
  // One thread: the conversion is short, and its bits then cannot depend on scheduling.
  tbb::task_arena arena(1);
  arena.execute([&] {
    grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
        adapter, *transform, static_cast<float>(settings.exterior_band), std::numeric_limits<float>::max());
  });
  return grid;
}

} // namespace

Result<SignedDistance> SignedDistance::from_surface(const SurfaceMesh& surface,
                                                    const SignedDistanceSettings& settings) {
  const MeshReport report = inspect_mesh(surface);
  if (Status valid = check_valid(surface, report, "the surface"); !valid)
    return valid.error();
  if (Status closed = check_closed(report, "the surface"); !closed)
    return closed.error();
  auto result = std::make_shared<Grid>();
  result->low = surface.vertices.colwise().minCoeff().transpose();
  result->high = surface.vertices.colwise().maxCoeff().transpose();
  result->voxel = settings.voxel;
  result->per_voxel = 1.0 / settings.voxel;
  if (Status valid = check(surface, settings, result->low, result->high); !valid)
    return valid.error();
  try {
    result->grid = convert(surface, settings);
    result->dense.emplace(*result->grid);
    if (result->dense->empty())
      result->dense.reset();
  } catch (const std::bad_alloc&) {
    return make_error(ErrorCode::out_of_memory,
                      "no memory for a signed distance at {:.4g} m. Try a larger `resolution`.", settings.voxel);
  } catch (const std::exception& failure) {
    return make_error(ErrorCode::bad_input, "OpenVDB cannot make a signed distance at {:.4g} m: {}", settings.voxel,
                      failure.what());
  }
  bool any_inside = false;
  for (auto value = result->grid->cbeginValueOn(); value && !any_inside; ++value)
    any_inside = *value < 0;
  if (!any_inside)
    return make_error(ErrorCode::bad_input,
                      "the surface encloses nothing that a voxel of {:.4g} m can see: it is open, flat, or too thin. "
                      "Try a smaller `resolution`, or mend the mesh.",
                      settings.voxel);
  return SignedDistance(std::move(result));
}

double SignedDistance::value(const Vec3& point) const {
  const Vec3 index = point * m_grid->per_voxel;
  if (m_grid->dense)
    return static_cast<double>(m_grid->dense->value(index));
  return static_cast<double>(
      openvdb::tools::BoxSampler::sample(m_grid->grid->tree(), openvdb::Vec3d(index.x(), index.y(), index.z())));
}

Vec3 SignedDistance::gradient(const Vec3& point) const {
  const double step = m_grid->voxel / 2;
  Vec3 slope;
  for (int k = 0; k < 3; ++k)
    slope[k] = (value(point + step * Vec3::Unit(k)) - value(point - step * Vec3::Unit(k))) / (2 * step);
  return slope;
}

double SignedDistance::voxel() const {
  return m_grid->voxel;
}
std::int64_t SignedDistance::sampled_voxels() const {
  return static_cast<std::int64_t>(m_grid->grid->activeVoxelCount());
}
std::int64_t SignedDistance::bytes() const {
  return static_cast<std::int64_t>(m_grid->grid->memUsage() + (m_grid->dense ? m_grid->dense->bytes() : 0));
}
Vec3 SignedDistance::low() const {
  return m_grid->low;
}
Vec3 SignedDistance::high() const {
  return m_grid->high;
}

} // namespace wry::geometry
