#include "sim/fem/element_term.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "sim/fem/element_projection.h"
#include "sim/fem/rotation_interpolation.h"

namespace wry::fem {

namespace {

constexpr int NO_MORE_COLOURS = 64;

int node_of(const ElementGroup& group, int batch, int corner, int lane) {
  return group.nodes[(static_cast<std::size_t>(batch) * 4 + corner) * LANES + lane];
}

} // namespace

ElementTerm::ElementTerm(ElementGroup group, std::vector<RestPlace> rest_places, RestCurvature rest_curvature, Isa isa,
                         const Threads& threads)
    : m_group(std::move(group))
    , m_isa(isa)
    , m_kernel(select_kernel(m_group, isa))
    , m_project(find_projection(isa))
    , m_rest_places(std::move(rest_places))
    , m_rest_curvature(std::move(rest_curvature))
    , m_threads(threads) {
  if (m_group.curvature == CurvatureModel::none)
    m_rest_curvature = nullptr;
  if (m_rest_curvature)
    m_group.rest_curvature.assign(static_cast<std::size_t>(m_group.batch_count) * 36 * LANES, 0.0);
  colour_chunks();
}

int ElementTerm::lanes_of(int batch) const {
  return std::min(LANES, m_group.element_count - batch * LANES);
}

std::vector<std::array<std::int32_t, 4>> ElementTerm::node_quadruples() const {
  std::vector<std::array<std::int32_t, 4>> nodes(m_group.element_count);
  for (int element = 0; element < m_group.element_count; ++element) {
    for (int k = 0; k < 4; ++k)
      nodes[element][k] = node_of(m_group, element / LANES, k, element % LANES);
  }
  return nodes;
}

void ElementTerm::colour_chunks() {
  const int length = std::clamp(m_group.batch_count / 64, 4, 32);
  const int top = *std::max_element(m_group.nodes.begin(), m_group.nodes.end());
  std::vector<std::uint64_t> taken(static_cast<std::size_t>(top) + 1, 0); // colours of the chunks at each node
  for (int begin = 0; begin < m_group.batch_count; begin += length) {
    const Chunk chunk{begin, std::min(m_group.batch_count, begin + length)};
    std::uint64_t forbidden = 0;
    const auto first = m_group.nodes.begin() + static_cast<std::ptrdiff_t>(chunk.begin) * 4 * LANES;
    const auto last = m_group.nodes.begin() + static_cast<std::ptrdiff_t>(chunk.end) * 4 * LANES;
    std::for_each(first, last, [&](std::int32_t node) { forbidden |= taken[node]; });
    std::size_t colour = 0;
    while (colour + 1 < NO_MORE_COLOURS && (forbidden >> colour & 1) != 0)
      ++colour;
    const bool free = (forbidden >> colour & 1) == 0;
    if (m_colours.size() <= colour)
      m_colours.resize(colour + 1);
    if (free) {
      std::for_each(first, last, [&](std::int32_t node) { taken[node] |= std::uint64_t{1} << colour; });
      m_colours[colour].push_back(static_cast<int>(m_chunks.size()));
    } else { // meshes with a hub: a colour of its own
      m_colours.push_back({static_cast<int>(m_chunks.size())});
    }
    m_chunks.push_back(chunk);
  }
}

void ElementTerm::bind_model(const FemModel& model, const BlockMatrix& matrix) {
  m_layout = &model.layout;
  for (int element = 0; element < m_group.element_count; ++element) {
    for (int k = 0; k < 4; ++k)
      m_inertia.add_corner(node_of(m_group, element / LANES, k, element % LANES), element_volume(element));
  }
  m_inertia.finish(model.mass);
  m_block_numbers.assign(static_cast<std::size_t>(m_group.batch_count) * 10 * LANES, 0);
  const int first_node = m_group.nodes.front();
  for (std::size_t i = 0; i < matrix.sections().size(); ++i) {
    const NodeSection& nodes = matrix.sections()[i].nodes;
    if (first_node >= nodes.first_node && first_node < nodes.first_node + nodes.node_count)
      m_section = static_cast<int>(i);
  }
  for (int batch = 0; batch < m_group.batch_count; ++batch) {
    for (int lane = 0; lane < lanes_of(batch); ++lane) {
      int block = 0;
      for (int k = 0; k < 4; ++k) {
        for (int l = k; l < 4; ++l, ++block)
          m_block_numbers[(static_cast<std::size_t>(batch) * 10 + block) * LANES + lane] = static_cast<std::int32_t>(
              matrix.find(node_of(m_group, batch, k, lane), node_of(m_group, batch, l, lane)));
      }
    }
  }
}

NodeFields ElementTerm::fields_of(const Trial& trial) const {
  NodeFields fields;
  fields.positions = trial.positions.data();
  if (is_micropolar(m_group.model)) {
    fields.rotation_increments = trial.increments.data();
    fields.rotations = m_rotations->data();
  }
  return fields;
}

std::size_t ElementTerm::memory_bytes() const {
  const std::size_t doubles = m_group.shape_gradients.size() + 4 * m_group.volume.size() +
                              m_group.curvature_moduli.size() + m_group.curvature_basis.size() +
                              m_group.rest_curvature.size() + m_group.point_rotations.size();
  return doubles * sizeof(double) + (m_group.nodes.size() + m_block_numbers.size()) * sizeof(std::int32_t);
}

void ElementTerm::begin_solve(const Stage& stage, const Trial&) {
  update_rest_curvature(stage.time);
}

void ElementTerm::update_rest_curvature(double time) {
  if (!m_rest_curvature || (m_rest_curvature_known && (m_rest_curvature_time == time || !m_rest_curvature_moves)))
    return;
  m_threads.for_each(m_group.element_count, 64, [&](std::size_t element) {
    for (std::size_t point = 0; point < POINTS; ++point) {
      const Mat3 value = m_rest_curvature(m_rest_places[4 * element + point], time);
      double* out = m_group.rest_curvature.data() + (element / LANES * 36 + point * 9) * LANES + element % LANES;
      for (int i = 0; i < 9; ++i)
        out[i * LANES] = value(i / 3, i % 3);
    }
  });
  m_rest_curvature_time = time;
  m_rest_curvature_known = true;
}

double ElementTerm::energy(const Stage&, const Trial& trial) const {
  const NodeFields fields = fields_of(trial);
  return m_threads.sum_chunks(m_chunks.size(), 1, [&](std::size_t index, std::size_t) {
    alignas(64) double energies[LANES];
    double sum = 0.0;
    for (int batch = m_chunks[index].begin; batch < m_chunks[index].end; ++batch) {
      m_kernel.energy(m_group, fields, batch, energies);
      for (int lane = 0; lane < lanes_of(batch); ++lane)
        sum += energies[lane];
    }
    return sum;
  });
}

void ElementTerm::for_each_chunk(const std::function<void(int)>& body) const {
  for (const std::vector<int>& colour : m_colours)
    m_threads.for_each(colour.size(), 1, [&](std::size_t i) { body(colour[i]); });
}

template <int D>
void ElementTerm::scatter_gradient(int batch, const BatchDerivatives& in, double beta, double* gradient) const {
  for (int lane = 0; lane < lanes_of(batch); ++lane) {
    for (int k = 0; k < 4; ++k) {
      double* out = gradient + m_layout->dof(node_of(m_group, batch, k, lane));
      for (int i = 0; i < D; ++i)
        out[i] += beta * in.gradient[(k * D + i) * LANES + lane];
    }
  }
}

template <int D>
void ElementTerm::scatter_hessian(int batch, const BatchDerivatives& in, double scale, double* values) const {
  const int lanes = lanes_of(batch);
  for (int block = 0; block < 10; ++block) {
    const std::int32_t* numbers = m_block_numbers.data() + (static_cast<std::size_t>(batch) * 10 + block) * LANES;
    const double* source = in.hessian + block * D * D * LANES;
    for (int lane = 0; lane < lanes; ++lane) {
      double* out = values + static_cast<std::size_t>(numbers[lane]) * (D * D);
      for (int i = 0; i < D * D; ++i)
        out[i] += scale * source[i * LANES + lane];
    }
  }
}

double ElementTerm::add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const {
  const NodeFields fields = fields_of(trial);
  std::vector<double> energies(m_chunks.size(), 0.0);
  for_each_chunk([&](int index) {
    BatchDerivatives out;
    for (int batch = m_chunks[index].begin; batch < m_chunks[index].end; ++batch) {
      m_kernel.gradient(m_group, fields, batch, out);
      for (int lane = 0; lane < lanes_of(batch); ++lane)
        energies[index] += out.energy[lane];
      if (m_group.dofs_per_node() == 3)
        scatter_gradient<3>(batch, out, stage.beta, gradient.data());
      else
        scatter_gradient<6>(batch, out, stage.beta, gradient.data());
    }
  });
  double sum = 0.0;
  for (const double energy : energies)
    sum += energy;
  return sum;
}

int ElementTerm::project_batch(int batch, const Stage& stage, Projection projection, double* hessian) const {
  const int lanes = lanes_of(batch);
  alignas(64) double inertia[4][LANES] = {};
  for (int k = 0; k < 4; ++k) {
    for (int lane = 0; lane < lanes; ++lane)
      inertia[k][lane] =
          m_inertia.at(node_of(m_group, batch, k, lane), m_group.volume[static_cast<std::size_t>(batch) * LANES + lane],
                       stage, projection);
  }
  if (m_group.dofs_per_node() == 3)
    return m_project(hessian, lanes, inertia);
  int projected = 0;
  for (int lane = 0; lane < lanes; ++lane)
    projected +=
        project_element(hessian, lane, {inertia[0][lane], inertia[1][lane], inertia[2][lane], inertia[3][lane]});
  return projected;
}

int ElementTerm::add_hessian(const Stage& stage, const Trial& trial, Projection projection, BlockMatrix& matrix) const {
  const NodeFields fields = fields_of(trial);
  const double scale = stage.beta * stage.beta;
  double* values = matrix.sections()[m_section].values.data();
  const bool classic = m_group.dofs_per_node() == 3;
  std::vector<int> projected(m_chunks.size(), 0);
  for_each_chunk([&](int index) {
    BatchDerivatives out;
    for (int batch = m_chunks[index].begin; batch < m_chunks[index].end; ++batch) {
      m_kernel.hessian(m_group, fields, batch, out);
      if (is_of_elements(projection))
        projected[index] += project_batch(batch, stage, projection, out.hessian);
      if (classic)
        scatter_hessian<3>(batch, out, scale, values);
      else
        scatter_hessian<6>(batch, out, scale, values);
    }
  });
  int sum = 0;
  for (const int count : projected)
    sum += count;
  return sum;
}

void ElementTerm::advance_rotations(const Trial& trial) {
  if (m_kernel.advance_rotations == nullptr)
    return;
  const NodeFields fields = fields_of(trial);
  m_threads.for_each(m_group.batch_count, 64,
                     [&](std::size_t batch) { m_kernel.advance_rotations(m_group, fields, static_cast<int>(batch)); });
}

void ElementTerm::reset_point_rotations(PointRotations rule) {
  if (m_group.point_rotations.empty())
    return;
  const Eigen::Matrix4d weights = quadrature_weights();
  m_threads.for_each(m_group.element_count, 64, [&](std::size_t element) {
    const int batch = static_cast<int>(element / LANES);
    const int lane = static_cast<int>(element % LANES);
    std::array<Vec4, 4> corners;
    for (int k = 0; k < 4; ++k)
      corners[k] = m_rotations->row(node_of(m_group, batch, k, lane)).transpose();
    for (int point = 0; point < POINTS; ++point) {
      const Vec4 row = weights.row(point);
      const Vec4 q = interpolate_rotation(rule, corners, {row.data(), 4});
      double* out = m_group.point_rotations.data() + (static_cast<std::size_t>(batch) * 16 + 4 * point) * LANES + lane;
      for (int i = 0; i < 4; ++i)
        out[i * LANES] = q[i];
    }
  });
}

std::vector<double> ElementTerm::element_energies(const Trial& trial) const {
  const NodeFields fields = fields_of(trial);
  std::vector<double> energies(static_cast<std::size_t>(m_group.batch_count) * LANES);
  m_threads.for_each(m_group.batch_count, 64, [&](std::size_t batch) {
    alignas(64) double lanes[LANES];
    m_kernel.energy(m_group, fields, static_cast<int>(batch), lanes);
    std::copy_n(lanes, LANES, energies.begin() + static_cast<std::ptrdiff_t>(batch) * LANES);
  });
  energies.resize(m_group.element_count);
  return energies;
}

std::vector<double> ElementTerm::elastic_energies(const Trial& trial) {
  const CurvatureModel curvature = m_group.curvature;
  const ElementKernel kernel = m_kernel;
  m_group.curvature = CurvatureModel::none;
  m_kernel = select_kernel(m_group, m_isa);
  std::vector<double> energies = element_energies(trial);
  m_group.curvature = curvature;
  m_kernel = kernel;
  return energies;
}

double ElementTerm::elastic_energy(const Trial& trial) {
  double sum = 0.0;
  for (const double energy : elastic_energies(trial))
    sum += energy;
  return sum;
}

void ElementTerm::add_deformations(const Points& positions, std::vector<Mat3>& sums) const {
  for (int element = 0; element < m_group.element_count; ++element) {
    const std::size_t batch = element / LANES;
    const int lane = element % LANES;
    std::int32_t nodes[4];
    for (std::size_t k = 0; k < 4; ++k)
      nodes[k] = m_group.nodes[(batch * 4 + k) * LANES + lane];
    Mat3 edges;
    Mat3 gradients;
    for (int k = 0; k < 3; ++k) {
      edges.col(k) = positions.row(nodes[k + 1]) - positions.row(nodes[0]);
      for (int j = 0; j < 3; ++j)
        gradients(k, j) = m_group.shape_gradients[(batch * 9 + 3 * k + j) * LANES + lane];
    }
    const Mat3 weighted = m_group.volume[batch * LANES + lane] * (edges * gradients);
    for (const std::int32_t node : nodes)
      sums[node] += weighted;
  }
}

} // namespace wry::fem
