#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <new>

#include <Eigen/Geometry>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>
#include <tbb/task_arena.h>

#include "sim/geometry/mesh_checks.h"
#include "sim/geometry/signed_distance.h"

namespace wry::geometry {

struct SignedDistance::Grid {
  openvdb::FloatGrid::Ptr grid;
  double voxel = 0;
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
  if (Status valid = check(surface, settings, result->low, result->high); !valid)
    return valid.error();
  try {
    result->grid = convert(surface, settings);
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
  const openvdb::Vec3d index = m_grid->grid->worldToIndex(openvdb::Vec3d(point.x(), point.y(), point.z()));
  return static_cast<double>(openvdb::tools::BoxSampler::sample(m_grid->grid->tree(), index));
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
  return static_cast<std::int64_t>(m_grid->grid->memUsage());
}
Vec3 SignedDistance::low() const {
  return m_grid->low;
}
Vec3 SignedDistance::high() const {
  return m_grid->high;
}

} // namespace wry::geometry
