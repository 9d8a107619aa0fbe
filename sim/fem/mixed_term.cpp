#include "sim/fem/mixed_term.h"

#include <algorithm>
#include <memory>

#include <Eigen/Dense>

namespace wry::fem {

namespace {

/// Share of the largest diagonal entry that passes for round-off: rigid motions have eigenvalue zero.
constexpr double ROUND_OFF = 1e-9;

/// body(entry, row, column) for the entries of the upper blocks of an element; positions come before rotations.
template <class Body> void for_each_block(const MixedKernel& kernel, MixedDerivatives& d, const Body& body) {
  const int nodes = kernel.nodes, corners = kernel.corners;
  for (int k = 0; k < nodes; ++k) {
    for (int l = k; l < nodes; ++l)
      body(d.xx + 9 * upper_block(k, l, nodes) * LANES, 3 * k, 3 * l);
    for (int l = 0; l < corners; ++l)
      body(d.xa + 9 * (k * corners + l) * LANES, 3 * k, 3 * (nodes + l));
  }
  for (int k = 0; k < corners; ++k) {
    for (int l = k; l < corners; ++l)
      body(d.aa + 9 * upper_block(k, l, corners) * LANES, 3 * (nodes + k), 3 * (nodes + l));
  }
}

} // namespace

bool project_mixed(const MixedKernel& kernel, MixedDerivatives& derivatives, int lane,
                   std::span<const double> inertia) {
  const Eigen::Index size = 3 * (kernel.nodes + kernel.corners);
  Eigen::MatrixXd element(size, size);
  for_each_block(kernel, derivatives, [&](const double* block, Eigen::Index row, Eigen::Index column) {
    for (Eigen::Index i = 0; i < 9; ++i)
      element(row + i / 3, column + i % 3) = element(column + i % 3, row + i / 3) = block[i * LANES + lane];
  });
  for (std::size_t k = 0; k < inertia.size(); ++k)
    element.diagonal().segment<3>(3 * static_cast<Eigen::Index>(k)).array() += inertia[k];
  Eigen::MatrixXd shifted = element;
  shifted.diagonal().array() += ROUND_OFF * element.diagonal().cwiseAbs().maxCoeff();
  if (Eigen::LLT<Eigen::MatrixXd>(shifted).info() == Eigen::Success)
    return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(element);
  Eigen::MatrixXd clamped =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
  for (std::size_t k = 0; k < inertia.size(); ++k)
    clamped.diagonal().segment<3>(3 * static_cast<Eigen::Index>(k)).array() -= inertia[k];
  for_each_block(kernel, derivatives, [&](double* block, Eigen::Index row, Eigen::Index column) {
    for (Eigen::Index i = 0; i < 9; ++i)
      block[i * LANES + lane] = clamped(row + i / 3, column + i % 3);
  });
  return true;
}

MixedTerm::MixedTerm(MixedGroup group, std::vector<RestPlace> rest_places, RestCurvature rest_curvature,
                     const Threads& threads)
    : m_group(std::move(group))
    , m_rest_places(std::move(rest_places))
    , m_rest_curvature(std::move(rest_curvature))
    , m_threads(threads) {
  if (m_group.curvature == MixedCurvature::none)
    m_rest_curvature = nullptr;
  if (m_rest_curvature)
    m_group.rest_curvature.assign(static_cast<std::size_t>(m_group.batch_count) * 9 * m_group.kernel->points * LANES,
                                  0.0);
  colour_batches();
}

int MixedTerm::lanes_of(int batch) const {
  return std::min(LANES, m_group.element_count - batch * LANES);
}

std::vector<std::array<std::int32_t, 4>> MixedTerm::node_quadruples() const {
  // Nodes two by two; every two such couples make a quadruple.
  const int couples = (m_group.kernel->nodes + 1) / 2;
  std::vector<std::array<std::int32_t, 4>> quadruples;
  for (int element = 0; element < m_group.element_count; ++element) {
    const auto node = [&](int k) { return m_group.node(element, std::min(k, m_group.kernel->nodes - 1)); };
    for (int a = 0; a < couples; ++a) {
      for (int b = a + 1; b < couples; ++b) {
        std::array<std::int32_t, 4> quadruple = {node(2 * a), node(2 * a + 1), node(2 * b), node(2 * b + 1)};
        std::sort(quadruple.begin(), quadruple.end());
        quadruples.push_back(quadruple);
      }
    }
  }
  return quadruples;
}

void MixedTerm::colour_batches() {
  const int top = *std::max_element(m_group.nodes.begin(), m_group.nodes.end());
  std::vector<std::vector<char>> taken; // per colour and node
  for (int batch = 0; batch < m_group.batch_count; ++batch) {
    const auto first = m_group.nodes.begin() + static_cast<std::ptrdiff_t>(batch) * m_group.kernel->nodes * LANES;
    const auto last = first + m_group.kernel->nodes * LANES;
    std::size_t colour = 0;
    while (colour < taken.size() &&
           std::any_of(first, last, [&](std::int32_t node) { return taken[colour][static_cast<std::size_t>(node)]; }))
      ++colour;
    if (colour == taken.size()) {
      taken.emplace_back(static_cast<std::size_t>(top) + 1, 0);
      m_colours.emplace_back();
    }
    std::for_each(first, last, [&](std::int32_t node) { taken[colour][static_cast<std::size_t>(node)] = 1; });
    m_colours[colour].push_back(batch);
  }
}

void MixedTerm::bind_model(const FemModel& model, const BlockMatrix& matrix) {
  m_layout = &model.layout;
  for (int element = 0; element < m_group.element_count; ++element) {
    for (int k = 0; k < m_group.kernel->nodes; ++k)
      m_inertia.add_corner(m_group.node(element, k), element_volume(element));
  }
  m_inertia.finish(model.mass);
  const int first_node = m_group.nodes.front();
  for (std::size_t i = 0; i < matrix.sections().size(); ++i) {
    const NodeSection& nodes = matrix.sections()[i].nodes;
    if (first_node >= nodes.first_node && first_node < nodes.first_node + nodes.node_count)
      m_section = static_cast<int>(i);
  }
  m_places.clear();
  for (int element = 0; element < m_group.element_count; ++element) {
    for (int k = 0; k < m_group.kernel->nodes; ++k) {
      for (int l = k; l < m_group.kernel->nodes; ++l) {
        const int row = m_group.node(element, k), column = m_group.node(element, l);
        const std::int64_t block = matrix.find(std::min(row, column), std::max(row, column));
        m_places.push_back({static_cast<std::int32_t>(block), row > column});
      }
    }
  }
}

NodeFields MixedTerm::fields_of(const Trial& trial) const {
  return {trial.positions.data(), trial.increments.data(), m_rotations->data()};
}

std::size_t MixedTerm::memory_bytes() const {
  const MixedGroup& g = m_group;
  const std::size_t doubles = g.gradients.size() + 4 * g.volume.size() + g.moduli.size() + g.frame.size() +
                              g.rest_curvature.size() + g.point_rotations.size() + g.stretch_limit.size();
  return doubles * sizeof(double) + g.nodes.size() * sizeof(std::int32_t) + m_places.size() * sizeof(Place);
}

void MixedTerm::begin_solve(const Stage& stage, const Trial&) {
  update_rest_curvature(stage.time);
}

void MixedTerm::update_rest_curvature(double time) {
  if (!m_rest_curvature || (m_rest_curvature_known && (!m_rest_curvature_moves || m_rest_curvature_time == time)))
    return;
  const int points = m_group.kernel->points;
  for (int element = 0; element < m_group.element_count; ++element) {
    for (int point = 0; point < points; ++point) {
      const Mat3 value = m_rest_curvature(m_rest_places[static_cast<std::size_t>(points * element + point)], time);
      double* out = m_group.rest_curvature.data() +
                    (static_cast<std::size_t>(element / LANES) * 9 * points + point * 9) * LANES + element % LANES;
      for (int i = 0; i < 9; ++i)
        out[i * LANES] = value(i / 3, i % 3);
    }
  }
  m_rest_curvature_time = time;
  m_rest_curvature_known = true;
}

std::vector<double> MixedTerm::element_energies(const Trial& trial) const {
  const NodeFields fields = fields_of(trial);
  std::vector<double> energies(static_cast<std::size_t>(m_group.batch_count) * LANES);
  m_threads.for_each(m_group.batch_count, 16, [&](std::size_t batch) {
    MixedDerivatives out;
    m_group.kernel->energy(m_group.batch(static_cast<int>(batch)), fields, out);
    std::copy_n(out.energy, LANES, energies.begin() + static_cast<std::ptrdiff_t>(batch) * LANES);
  });
  energies.resize(static_cast<std::size_t>(m_group.element_count));
  return energies;
}

double MixedTerm::energy(const Stage&, const Trial& trial) const {
  double sum = 0.0;
  for (const double energy : element_energies(trial))
    sum += energy;
  return sum;
}

std::vector<double> MixedTerm::elastic_energies(const Trial& trial) {
  const MixedCurvature curvature = std::exchange(m_group.curvature, MixedCurvature::none);
  std::vector<double> energies = element_energies(trial);
  m_group.curvature = curvature;
  return energies;
}

double MixedTerm::elastic_energy(const Trial& trial) {
  double sum = 0.0;
  for (const double energy : elastic_energies(trial))
    sum += energy;
  return sum;
}

void MixedTerm::for_each_batch(const std::function<void(int)>& body) const {
  for (const std::vector<int>& colour : m_colours)
    m_threads.for_each(colour.size(), 4, [&](std::size_t i) { body(colour[i]); });
}

void MixedTerm::scatter_gradient(int batch, const MixedDerivatives& in, double beta, double* gradient) const {
  const MixedKernel& kernel = *m_group.kernel;
  for (int lane = 0; lane < lanes_of(batch); ++lane) {
    for (int k = 0; k < kernel.nodes; ++k) {
      double* out = gradient + m_layout->dof(m_group.node(batch * LANES + lane, k));
      for (int i = 0; i < 3; ++i) {
        out[i] += beta * in.gradient[(3 * k + i) * LANES + lane];
        if (k < kernel.corners)
          out[3 + i] += beta * in.gradient[(3 * (kernel.nodes + k) + i) * LANES + lane];
      }
    }
  }
}

namespace {

/// Adds a block, or its transpose, at a place of a row-major 6 x 6 block.
void add_block(const double* block, int lane, double scale, bool transpose, int row, int column, double* to) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      to[6 * (row + i) + column + j] += scale * block[(transpose ? 3 * j + i : 3 * i + j) * LANES + lane];
  }
}

} // namespace

void MixedTerm::scatter_hessian(int batch, const MixedDerivatives& in, double scale, double* values) const {
  const int nodes = m_group.kernel->nodes, corners = m_group.kernel->corners;
  const Place* place = m_places.data() + static_cast<std::size_t>(batch) * LANES * pair_count();
  for (int lane = 0; lane < lanes_of(batch); ++lane) {
    for (int k = 0; k < nodes; ++k) {
      for (int l = k; l < nodes; ++l, ++place) {
        double* to = values + static_cast<std::size_t>(place->block) * 36;
        const bool swapped = place->swapped;
        add_block(in.xx + 9 * upper_block(k, l, nodes) * LANES, lane, scale, swapped, 0, 0, to);
        // x of the first node with a of the second: right of the block's diagonal, or below when nodes are swapped.
        if (l < corners)
          add_block(in.xa + 9 * (k * corners + l) * LANES, lane, scale, swapped, swapped ? 3 : 0, swapped ? 0 : 3, to);
        if (k < corners)
          add_block(in.xa + 9 * (l * corners + k) * LANES, lane, scale, !swapped, swapped ? 0 : 3, swapped ? 3 : 0, to);
        if (l < corners)
          add_block(in.aa + 9 * upper_block(k, l, corners) * LANES, lane, scale, swapped, 3, 3, to);
      }
    }
  }
}

double MixedTerm::add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const {
  const NodeFields fields = fields_of(trial);
  std::vector<double> energies(static_cast<std::size_t>(m_group.batch_count), 0.0);
  for_each_batch([&](int batch) {
    MixedDerivatives out;
    m_group.kernel->gradient(m_group.batch(batch), fields, out);
    for (int lane = 0; lane < lanes_of(batch); ++lane)
      energies[static_cast<std::size_t>(batch)] += out.energy[lane];
    scatter_gradient(batch, out, stage.beta, gradient.data());
  });
  double sum = 0.0;
  for (const double energy : energies)
    sum += energy;
  return sum;
}

int MixedTerm::add_hessian(const Stage& stage, const Trial& trial, Projection projection, BlockMatrix& matrix) const {
  const NodeFields fields = fields_of(trial);
  double* values = matrix.sections()[m_section].values.data();
  std::vector<int> projected(static_cast<std::size_t>(m_group.batch_count), 0);
  for_each_batch([&](int batch) {
    MixedDerivatives out;
    m_group.kernel->hessian(m_group.batch(batch), fields, out);
    for (int lane = 0; is_of_elements(projection) && lane < lanes_of(batch); ++lane) {
      const int element = batch * LANES + lane;
      std::array<double, MIXED_NODES> inertia;
      for (int k = 0; k < m_group.kernel->nodes; ++k)
        inertia[static_cast<std::size_t>(k)] =
            m_inertia.at(m_group.node(element, k), element_volume(element), stage, projection);
      projected[static_cast<std::size_t>(batch)] +=
          project_mixed(*m_group.kernel, out, lane, {inertia.data(), static_cast<std::size_t>(m_group.kernel->nodes)});
    }
    scatter_hessian(batch, out, stage.beta * stage.beta, values);
  });
  int sum = 0;
  for (const int count : projected)
    sum += count;
  return sum;
}

void MixedTerm::advance_rotations(const Trial& trial) {
  const NodeFields fields = fields_of(trial);
  m_threads.for_each(m_group.batch_count, 64, [&](std::size_t batch) {
    double* rotations = m_group.point_rotations.data() + batch * 4 * m_group.kernel->points * LANES;
    m_group.kernel->advance(m_group.batch(static_cast<int>(batch)), fields, rotations);
  });
}

} // namespace wry::fem
