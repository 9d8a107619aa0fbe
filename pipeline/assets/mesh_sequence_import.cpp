#include "pipeline/assets/mesh_sequence_import.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pipeline/assets/numbered_vertices.h"
#include "pipeline/assets/point_cache.h"

namespace wry::pipeline {

namespace {

/// Vertices this near to each other, over the mesh's diagonal, were welded; single precision of the importer included.
constexpr double SAME_PLACE = 4e-6;
/// Vertices that were welded may come apart by this much of the diagonal.
constexpr double MOST_APART = 1e-4;

/// Which of a file's vertices became which of the welded mesh.
class VertexMap {
public:
  static Result<VertexMap> create(const Points& file, const Points& welded, const std::string& path) {
    VertexMap map;
    map.m_diagonal = (welded.colwise().maxCoeff() - welded.colwise().minCoeff()).norm();
    const double reach = SAME_PLACE * std::max(map.m_diagonal, welded.cwiseAbs().maxCoeff());
    std::vector<std::int32_t> along(static_cast<std::size_t>(file.rows())); // sorted along x
    std::iota(along.begin(), along.end(), 0);
    std::sort(along.begin(), along.end(),
              [&](std::int32_t a, std::int32_t b) { return std::pair(file(a, 0), a) < std::pair(file(b, 0), b); });
    for (Eigen::Index vertex = 0; vertex < welded.rows(); ++vertex) {
      const auto begin = std::lower_bound(along.begin(), along.end(), welded(vertex, 0) - reach,
                                          [&](std::int32_t row, double x) { return file(row, 0) < x; });
      std::vector<std::int32_t> here;
      for (auto it = begin; it != along.end() && file(*it, 0) <= welded(vertex, 0) + reach; ++it) {
        if ((file.row(*it) - welded.row(vertex)).cwiseAbs().maxCoeff() <= reach)
          here.push_back(*it);
      }
      if (here.empty())
        return make_error(ErrorCode::bad_input, "{}: vertex {} of the mesh is none of the {} that the file lists", path,
                          vertex, file.rows());
      std::sort(here.begin(), here.end());
      map.m_rows.push_back(here.front());
      for (std::size_t i = 1; i < here.size(); ++i)
        map.m_twins.push_back({here.front(), here[i]});
    }
    return map;
  }

  /// The welded mesh's vertices among a file's. Error: bad_input when those at one place have come apart.
  Result<Points> pick(const Points& file, const std::string& where) const {
    for (const auto& [kept, other] : m_twins) {
      const double apart = (file.row(kept) - file.row(other)).norm();
      if (apart > MOST_APART * m_diagonal)
        return make_error(ErrorCode::bad_input,
                          "{}: vertices {} and {} are at one place in the mesh, but {:.3g} m apart here; weld the "
                          "mesh before it is animated, or open the seam in the mesh too",
                          where, kept, other, apart);
    }
    Points picked(static_cast<Eigen::Index>(m_rows.size()), 3);
    for (std::size_t i = 0; i < m_rows.size(); ++i)
      picked.row(static_cast<Eigen::Index>(i)) = file.row(m_rows[i]);
    return picked;
  }

private:
  double m_diagonal = 0.0;
  std::vector<std::int32_t> m_rows;                           ///< per vertex of the welded mesh
  std::vector<std::pair<std::int32_t, std::int32_t>> m_twins; ///< rows at the same place
};

void place(const MeshSequenceSource& source, Points& points) {
  for (const scene::Similarity& placement : source.placements)
    scene::apply(placement, points);
}

/// The name with the digits of a frame in place of #; empty when there is not one run of them.
std::string numbered_name(const std::string& pattern, int frame) {
  const std::size_t begin = pattern.find('#');
  const std::size_t end = begin == std::string::npos ? begin : pattern.find_first_not_of('#', begin);
  if (begin == std::string::npos || end == std::string::npos || pattern.find('#', end) != std::string::npos)
    return {};
  return fmt::format("{}{:0{}}{}", pattern.substr(0, begin), frame, end - begin, pattern.substr(end));
}

Result<ImportedMeshSequence> from_point_cache(const MeshSequenceSource& source, const NumberedVertices& mesh,
                                              const VertexMap& map) {
  Result<PointCache> cache = read_point_cache(source.sequence, mesh.positions.rows());
  if (!cache)
    return cache.error();
  const double last = cache->first_frame + cache->frames_per_sample * static_cast<double>(cache->samples.size() - 1);
  constexpr double ROUNDING = 1e-3; // frames
  if (cache->first_frame > source.first_frame + ROUNDING || last < source.last_frame - ROUNDING)
    return make_error(ErrorCode::bad_input,
                      "{}: holds frames {:g} to {:g}, but the shot has {} to {}; bake all of them, or shorten "
                      "shot.frames",
                      source.sequence, cache->first_frame, last, source.first_frame, source.last_frame);
  ImportedMeshSequence made{{}, cache->first_frame, cache->frames_per_sample, {source.sequence}};
  for (Points& sample : cache->samples) {
    place(source, sample);
    Result<Points> picked = map.pick(sample, fmt::format("{}, sample {}", source.sequence, made.samples.size()));
    if (!picked)
      return picked.error();
    made.samples.push_back(std::move(*picked));
    sample.resize(0, 3);
  }
  return made;
}

Result<ImportedMeshSequence> from_numbered_meshes(const MeshSequenceSource& source, const NumberedVertices& mesh,
                                                  const VertexMap& map) {
  ImportedMeshSequence made;
  made.first_frame = source.first_frame;
  for (int frame = source.first_frame; frame <= source.last_frame; ++frame) {
    const std::string name = numbered_name(source.sequence, frame);
    if (std::error_code ignored; !std::filesystem::exists(name, ignored))
      return make_error(ErrorCode::missing_input, "there is no file {} for frame {}; the shot has frames {} to {}",
                        name, frame, source.first_frame, source.last_frame);
    Result<NumberedVertices> read = read_numbered_vertices(name);
    if (!read)
      return read.error();
    if (read->positions.rows() != mesh.positions.rows())
      return make_error(ErrorCode::bad_input,
                        "{}: has {} vertices, the mesh {} has {}; the number may not change over a sequence", name,
                        read->positions.rows(), source.mesh, mesh.positions.rows());
    if (read->faces != mesh.faces &&
        std::filesystem::path(name).extension() == std::filesystem::path(source.mesh).extension())
      return make_error(ErrorCode::bad_input,
                        "{}: its faces are not those of the mesh {}; export both from one object, in one format, "
                        "without modifiers that change the topology",
                        name, source.mesh);
    place(source, read->positions);
    Result<Points> picked = map.pick(read->positions, name);
    if (!picked)
      return picked.error();
    made.samples.push_back(std::move(*picked));
    made.files.push_back(name);
  }
  return made;
}

} // namespace

Result<ImportedMeshSequence> import_mesh_sequence(const MeshSequenceSource& source, const Points& placed) {
  const bool is_cache = std::filesystem::path(source.sequence).extension() == ".pc2";
  if (!is_cache && numbered_name(source.sequence, 1).empty())
    return make_error(ErrorCode::bad_input,
                      "{}: neither a .pc2 file nor numbered meshes; write one # for each digit of the frame, as in "
                      "\"wave.####.obj\"",
                      source.sequence);
  Result<NumberedVertices> mesh = read_numbered_vertices(source.mesh);
  if (!mesh)
    return mesh.error();
  Points positions = mesh->positions;
  place(source, positions);
  const Result<VertexMap> map = VertexMap::create(positions, placed, source.mesh);
  if (!map)
    return map.error();
  return is_cache ? from_point_cache(source, *mesh, *map) : from_numbered_meshes(source, *mesh, *map);
}

} // namespace wry::pipeline
