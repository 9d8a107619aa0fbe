#include <cmath>
#include <sstream>

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/export/exporter.h"

namespace wry::pipeline {

namespace {

constexpr double CELLS_ACROSS = 128.0; ///< of the longest extent, where nothing says a finer length
constexpr float BAND = 3.f;            ///< half width of a level set [voxels]

/// Edge of a voxel: the mean edge of the rest mesh's triangles, so that a level set is as fine as its mesh; particles
/// get half their mean spacing in the volume that they fill at first.
double voxel_size(const SceneBody& body, const Points& positions) {
  const Vec3 extent = (positions.colwise().maxCoeff() - positions.colwise().minCoeff()).transpose();
  const double coarse = std::max(extent.maxCoeff(), 1e-6) / CELLS_ACROSS;
  if (!is_mesh(body)) {
    const double volume = std::max(extent.cwiseMax(coarse).prod(), 1e-30);
    return std::max(std::cbrt(volume / static_cast<double>(std::max<Eigen::Index>(positions.rows(), 1))),
                    0.25 * coarse);
  }
  double sum = 0.0;
  for (Eigen::Index i = 0; i < body.triangles.rows(); ++i)
    sum += (body.rest_positions.row(body.triangles(i, 0)) - body.rest_positions.row(body.triangles(i, 1))).norm();
  return std::max(sum / static_cast<double>(body.triangles.rows()), 0.25 * coarse);
}

openvdb::GridBase::Ptr level_set(const SceneBody& body, const Points& positions, double voxel) {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  for (Eigen::Index i = 0; i < positions.rows(); ++i)
    points.emplace_back(static_cast<float>(positions(i, 0)), static_cast<float>(positions(i, 1)),
                        static_cast<float>(positions(i, 2)));
  for (Eigen::Index i = 0; i < body.triangles.rows(); ++i)
    triangles.emplace_back(body.triangles(i, 0), body.triangles(i, 1), body.triangles(i, 2));
  const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
  const openvdb::FloatGrid::Ptr grid =
      openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(*transform, points, triangles, BAND);
  grid->setName(export_name(body.name) + "_surface");
  return grid;
}

/// Particles onto voxels by trilinear weights: how many per voxel, and their mean velocity.
std::vector<openvdb::GridBase::Ptr> splats(const SceneBody& body, const ExportPoints& points, double voxel) {
  const openvdb::FloatGrid::Ptr density = openvdb::FloatGrid::create(0.f);
  const openvdb::Vec3SGrid::Ptr velocity = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.f));
  for (const openvdb::GridBase::Ptr& grid : std::vector<openvdb::GridBase::Ptr>{density, velocity})
    grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel));
  density->setGridClass(openvdb::GRID_FOG_VOLUME);
  density->setName(export_name(body.name) + "_density");
  velocity->setName(export_name(body.name) + "_velocity");
  velocity->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
  auto mass = density->getAccessor();
  auto momentum = velocity->getAccessor();
  for (Eigen::Index i = 0; i < points.positions.rows(); ++i) {
    const Vec3 at = points.positions.row(i).transpose() / voxel;
    const Vec3 low(std::floor(at[0]), std::floor(at[1]), std::floor(at[2]));
    const Vec3 part = at - low;
    const Vec3 v = points.velocity.rows() > 0 ? Vec3(points.velocity.row(i).transpose()) : Vec3(Vec3::Zero());
    for (int corner = 0; corner < 8; ++corner) {
      float weight = 1.f;
      openvdb::Coord coord;
      for (int axis = 0; axis < 3; ++axis) {
        const int upper = corner >> axis & 1;
        weight *= static_cast<float>(upper != 0 ? part[axis] : 1.0 - part[axis]);
        coord[axis] = static_cast<int>(low[axis]) + upper;
      }
      mass.setValue(coord, mass.getValue(coord) + weight);
      momentum.setValue(
          coord,
          momentum.getValue(coord) +
              openvdb::Vec3s(static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])) * weight);
    }
  }
  for (auto cell = velocity->beginValueOn(); cell; ++cell)
    cell.setValue(*cell / std::max(mass.getValue(cell.getCoord()), 1e-6f));
  std::vector<openvdb::GridBase::Ptr> grids = {density};
  if (points.velocity.rows() > 0)
    grids.push_back(velocity);
  return grids;
}

/// The voxel of each body is that of the job's first frame, so that a sequence has one.
Status write_frame(const ExportJob& job, const Frame& frame, std::vector<double>& voxels) {
  openvdb::GridPtrVec grids;
  for (std::size_t b = 0; b < frame.bodies.size(); ++b) {
    const SceneBody& body = job.scene.bodies[b];
    const Result<ExportPoints> points = export_points(body, frame.bodies[b]);
    if (!points)
      return points.error();
    if (points->positions.rows() == 0)
      continue;
    if (voxels[b] == 0.0)
      voxels[b] = voxel_size(body, points->positions);
    if (points->is_mesh) {
      grids.push_back(level_set(body, points->positions, voxels[b]));
      continue;
    }
    const std::vector<openvdb::GridBase::Ptr> made = splats(body, *points, voxels[b]);
    grids.insert(grids.end(), made.begin(), made.end());
  }
  std::ostringstream bytes(std::ios::binary);
  openvdb::io::Stream(bytes).write(grids);
  return write_file_atomically(job.folder / sequence_name(job.name, frame.number, "vdb"), bytes.str());
}

} // namespace

Status export_vdb(const ExportJob& job) {
  openvdb::initialize();
  std::vector<double> voxels(job.scene.bodies.size(), 0.0);
  return for_each_frame(job, [&](const Frame& frame) -> Status {
    try {
      return write_frame(job, frame, voxels);
    } catch (const openvdb::Exception& problem) {
      return make_error(ErrorCode::io, "frame {}: OpenVDB says: {}", frame.number, problem.what());
    }
  });
}

} // namespace wry::pipeline
