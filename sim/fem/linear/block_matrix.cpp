#include "sim/fem/linear/block_matrix.h"

#include <algorithm>

namespace wry::fem {

namespace {

constexpr int PADDING = 8; // entries that vector loads may read past the last block
constexpr std::size_t ROW_GRAIN = 512;

void build_pattern(BlockMatrix::Section& section, const std::vector<std::array<std::int32_t, 4>>& tets) {
  const int first = section.nodes.first_node;
  const int count = section.nodes.node_count;
  std::vector<std::vector<std::int32_t>> rows(count);
  for (int node = 0; node < count; ++node)
    rows[node].push_back(node);
  for (const std::array<std::int32_t, 4>& tet : tets) {
    if (tet[0] < first || tet[0] >= first + count)
      continue;
    for (int k = 0; k < 4; ++k) {
      for (int l = k + 1; l < 4; ++l)
        rows[tet[k] - first].push_back(tet[l] - first);
    }
  }
  section.row_begin.assign(1, 0);
  for (std::vector<std::int32_t>& row : rows) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    section.column.insert(section.column.end(), row.begin(), row.end());
    section.row_begin.push_back(static_cast<std::int64_t>(section.column.size()));
  }
  const std::size_t entries = section.column.size() * section.nodes.dofs * section.nodes.dofs + PADDING;
  section.values.assign(entries, 0.0);
  section.single.assign(entries, 0.0f);
}

} // namespace

BlockMatrix::BlockMatrix(const DofLayout& layout, const std::vector<std::array<std::int32_t, 4>>& tets, Isa isa)
    : m_layout(&layout)
    , m_isa(isa)
    , m_products(select_block_products(isa)) {
  for (const NodeSection& nodes : layout.sections()) {
    Section& section = m_sections.emplace_back();
    section.nodes = nodes;
    build_pattern(section, tets);
    cut_into_chunks(static_cast<int>(m_sections.size()) - 1);
  }
  find_spill_sources();
  m_single_spills.assign(m_spill_count, 0.0f);
  m_double_spills.assign(m_spill_count, 0.0);
  m_partial_dots.assign(m_chunks.size(), 0.0);
}

void BlockMatrix::cut_into_chunks(int section_index) {
  const Section& section = m_sections[section_index];
  const int count = section.nodes.node_count;
  int span = 0;
  for (int row = 0; row < count; ++row)
    span = std::max(span, section.column[section.row_begin[row + 1] - 1] - row);
  // Long enough that spills are cheap beside blocks, short enough that eight threads find work.
  const int shortest = section.nodes.dofs == 3 ? 256 : 128;
  const int length = std::max(shortest, std::min(span, count / 8));
  for (int begin = 0; begin < count; begin += length) {
    Chunk chunk;
    chunk.section = section_index;
    chunk.begin = begin;
    chunk.end = std::min(count, begin + length);
    int furthest = chunk.end - 1;
    for (int row = begin; row < chunk.end; ++row)
      furthest = std::max(furthest, section.column[section.row_begin[row + 1] - 1]);
    chunk.spill_nodes = furthest - chunk.end + 1;
    chunk.spill_begin = m_spill_count;
    m_spill_count += static_cast<std::size_t>(chunk.spill_nodes) * section.nodes.stride();
    m_chunks.push_back(chunk);
  }
}

void BlockMatrix::find_spill_sources() {
  for (std::size_t index = 0; index < m_chunks.size(); ++index) {
    Chunk& chunk = m_chunks[index];
    chunk.first_source = index;
    for (std::size_t other = index; other-- > 0 && m_chunks[other].section == chunk.section;) {
      if (m_chunks[other].end + m_chunks[other].spill_nodes > chunk.begin)
        chunk.first_source = other;
    }
  }
}

std::int64_t BlockMatrix::find(int row, int column) const {
  for (const Section& section : m_sections) {
    const int local_row = row - section.nodes.first_node;
    if (local_row >= section.nodes.node_count)
      continue;
    const auto begin = section.column.begin() + section.row_begin[local_row];
    const auto end = section.column.begin() + section.row_begin[local_row + 1];
    const auto found = std::lower_bound(begin, end, column - section.nodes.first_node);
    if (found == end || *found != column - section.nodes.first_node)
      return -1;
    return found - section.column.begin();
  }
  return -1;
}

void BlockMatrix::add_velocity_diagonal(int node, const double* block3x3) {
  add_diagonal(node, 0, block3x3);
}

void BlockMatrix::add_angular_diagonal(int node, const double* block3x3) {
  add_diagonal(node, 3, block3x3);
}

void BlockMatrix::add_diagonal(int node, int offset, const double* block3x3) {
  for (Section& section : m_sections) {
    const int row = node - section.nodes.first_node;
    if (row >= section.nodes.node_count)
      continue;
    const int d = section.nodes.dofs;
    double* block = section.values.data() + section.row_begin[row] * d * d;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j)
        block[(offset + i) * d + offset + j] += block3x3[i * 3 + j];
    }
    return;
  }
}

void BlockMatrix::add_velocity_pair(int row, int column, const double* block) {
  if (row > column) {
    const double mirrored[9] = {block[0], block[3], block[6], block[1], block[4],
                                block[7], block[2], block[5], block[8]};
    return add_velocity_pair(column, row, mirrored);
  }
  if (const std::int64_t number = find(row, column); number >= 0) {
    for (Section& section : m_sections) {
      if (row - section.nodes.first_node >= section.nodes.node_count)
        continue;
      const int d = section.nodes.dofs;
      double* out = section.values.data() + number * d * d;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j)
          out[i * d + j] += block[i * 3 + j];
      }
      return;
    }
  }
  PairEntry& entry = m_pair_entries.emplace_back();
  entry.row = row;
  entry.column = column;
  std::copy_n(block, 9, entry.values);
}

void BlockMatrix::finish_pairs() {
  m_pairs.column.clear();
  m_pairs.values.clear();
  m_pairs.row_begin.clear();
  if (m_pair_entries.empty())
    return;
  const std::size_t nodes = static_cast<std::size_t>(m_layout->node_count());
  if (m_padded_of_node.empty()) {
    for (const NodeSection& section : m_layout->sections()) {
      for (int node = 0; node < section.node_count; ++node)
        m_padded_of_node.push_back(section.first_padded + static_cast<std::size_t>(node * section.stride()));
    }
  }
  // Sorted by row (counting), then by column; entries of one block stay in the order in which they came.
  std::vector<std::int64_t> fill(nodes + 1, 0);
  for (const PairEntry& entry : m_pair_entries) {
    ++fill[static_cast<std::size_t>(entry.row) + 1];
    ++fill[static_cast<std::size_t>(entry.column) + 1];
  }
  for (std::size_t row = 0; row < nodes; ++row)
    fill[row + 1] += fill[row];
  const std::vector<std::int64_t> begin = fill;
  m_pair_order.resize(2 * m_pair_entries.size()); // even: the entry, odd: its mirror image
  for (std::size_t i = 0; i < m_pair_entries.size(); ++i) {
    m_pair_order[fill[m_pair_entries[i].row]++] = static_cast<std::int64_t>(2 * i);
    m_pair_order[fill[m_pair_entries[i].column]++] = static_cast<std::int64_t>(2 * i + 1);
  }
  const auto column_of = [&](std::int64_t order) {
    const PairEntry& entry = m_pair_entries[static_cast<std::size_t>(order / 2)];
    return order % 2 == 0 ? entry.column : entry.row;
  };
  m_pairs.row_begin.assign(1, 0);
  for (std::size_t row = 0; row < nodes; ++row) {
    const auto first = m_pair_order.begin() + begin[row];
    const auto last = m_pair_order.begin() + begin[row + 1];
    std::sort(first, last, [&](std::int64_t a, std::int64_t b) {
      return column_of(a) != column_of(b) ? column_of(a) < column_of(b) : a < b;
    });
    for (auto it = first; it != last; ++it) {
      const std::int32_t column = column_of(*it);
      if (it == first || m_pairs.column.back() != column) {
        m_pairs.column.push_back(column);
        m_pairs.values.resize(m_pairs.values.size() + 9, 0.0);
      }
      const double* block = m_pair_entries[static_cast<std::size_t>(*it / 2)].values;
      double* out = m_pairs.values.data() + m_pairs.values.size() - 9;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j)
          out[3 * i + j] += *it % 2 == 0 ? block[3 * i + j] : block[3 * j + i];
      }
    }
    m_pairs.row_begin.push_back(static_cast<std::int64_t>(m_pairs.column.size()));
  }
}

void BlockMatrix::set_zero(const Threads& threads) {
  m_pair_entries.clear();
  m_pairs = {};
  for (Section& section : m_sections) {
    threads.for_chunks(section.values.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
      std::fill(section.values.begin() + begin, section.values.begin() + end, 0.0);
    });
  }
}

void BlockMatrix::hold(const std::vector<char>& held, const Threads& threads) {
  for (std::size_t row = 0; has_pairs() && row + 1 < m_pairs.row_begin.size(); ++row) {
    const char* row_mask = held.data() + m_layout->dof(static_cast<int>(row));
    for (std::int64_t k = m_pairs.row_begin[row]; k < m_pairs.row_begin[row + 1]; ++k) {
      const char* column_mask = held.data() + m_layout->dof(m_pairs.column[k]);
      for (int i = 0; i < 9; ++i) {
        if (row_mask[i / 3] || column_mask[i % 3])
          m_pairs.values[static_cast<std::size_t>(9 * k + i)] = 0.0;
      }
    }
  }
  for (Section& section : m_sections) {
    const int d = section.nodes.dofs;
    const char* mask = held.data() + section.nodes.first_dof;
    std::vector<char> node_held(section.nodes.node_count);
    for (int node = 0; node < section.nodes.node_count; ++node)
      node_held[node] = std::any_of(mask + node * d, mask + (node + 1) * d, [](char value) { return value != 0; });
    threads.for_each(section.nodes.node_count, ROW_GRAIN, [&](std::size_t row) {
      for (std::int64_t k = section.row_begin[row]; k < section.row_begin[row + 1]; ++k) {
        const std::size_t column = section.column[k];
        if (!node_held[row] && !node_held[column])
          continue;
        double* block = section.values.data() + k * d * d;
        for (int i = 0; i < d; ++i) {
          for (int j = 0; j < d; ++j) {
            if (mask[row * d + i] || mask[column * d + j])
              block[i * d + j] = (column == row && i == j) ? 1.0 : 0.0;
          }
        }
      }
    });
  }
}

void BlockMatrix::update_single(const Threads& threads) {
  m_pairs.single.assign(m_pairs.values.begin(), m_pairs.values.end());
  for (Section& section : m_sections) {
    threads.for_chunks(section.values.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        section.single[i] = static_cast<float>(section.values[i]);
    });
  }
}

void BlockMatrix::diagonal(std::vector<double>& out) const {
  out.resize(m_layout->dof_count());
  for (const Section& section : m_sections) {
    const int d = section.nodes.dofs;
    for (int row = 0; row < section.nodes.node_count; ++row) {
      for (int i = 0; i < d; ++i)
        out[section.nodes.first_dof + static_cast<std::size_t>(row) * d + i] =
            section.values[section.row_begin[row] * d * d + i * d + i];
    }
  }
}

template <> const float* BlockMatrix::values_of<float>(const Section& section) const {
  return section.single.data();
}
template <> const double* BlockMatrix::values_of<double>(const Section& section) const {
  return section.values.data();
}
template <> AlignedVector<float>& BlockMatrix::spills<float>() const {
  return m_single_spills;
}
template <> AlignedVector<double>& BlockMatrix::spills<double>() const {
  return m_double_spills;
}

template <> const float* BlockMatrix::pair_values<float>() const {
  return m_pairs.single.data();
}
template <> const double* BlockMatrix::pair_values<double>() const {
  return m_pairs.values.data();
}

/// Rows [begin, end) of a section, whose pairs may stand in any section.
template <class Scalar>
void BlockMatrix::multiply_pairs(const NodeSection& nodes, int begin, int end, const Scalar* x, Scalar* y) const {
  const Scalar* values = pair_values<Scalar>();
  for (int row = nodes.first_node + begin; row < nodes.first_node + end; ++row) {
    Scalar* out = y + m_padded_of_node[row];
    for (std::int64_t k = m_pairs.row_begin[row]; k < m_pairs.row_begin[row + 1]; ++k) {
      const Scalar* block = values + 9 * k;
      const Scalar* in = x + m_padded_of_node[m_pairs.column[k]];
      for (int i = 0; i < 3; ++i)
        out[i] += block[3 * i] * in[0] + block[3 * i + 1] * in[1] + block[3 * i + 2] * in[2];
    }
  }
}

template <class Scalar>
double BlockMatrix::gather_spills(std::size_t index, const AlignedVector<Scalar>& all_x,
                                  AlignedVector<Scalar>& all_y) const {
  const Chunk& chunk = m_chunks[index];
  const NodeSection& nodes = m_sections[chunk.section].nodes;
  const int stride = nodes.stride();
  const Scalar* x = all_x.data() + nodes.first_padded;
  Scalar* y = all_y.data() + nodes.first_padded;
  for (std::size_t other = chunk.first_source; other < index; ++other) {
    const Chunk& source = m_chunks[other];
    const Scalar* spill = spills<Scalar>().data() + source.spill_begin;
    const int begin = std::max(chunk.begin, source.end);
    const int end = std::min(chunk.end, source.end + source.spill_nodes);
    for (int node = begin; node < end; ++node) {
      for (int i = 0; i < nodes.dofs; ++i)
        y[node * stride + i] += spill[(node - source.end) * stride + i];
    }
  }
  if (has_pairs())
    multiply_pairs(nodes, chunk.begin, chunk.end, all_x.data(), all_y.data());
  return block_functions<Scalar>(m_products, nodes.dofs).dot(chunk.begin, chunk.end, x, y);
}

template <class Scalar>
double BlockMatrix::multiply(const AlignedVector<Scalar>& x, AlignedVector<Scalar>& y, const Threads& threads) const {
  threads.for_each(m_chunks.size(), 1, [&](std::size_t index) {
    const Chunk& chunk = m_chunks[index];
    const Section& section = m_sections[chunk.section];
    const BlockRows<Scalar> rows{section.row_begin.data(), section.column.data(), values_of<Scalar>(section)};
    const std::size_t first = section.nodes.first_padded;
    functions<Scalar>(section).product(rows, chunk.begin, chunk.end, x.data() + first, y.data() + first,
                                       spills<Scalar>().data() + chunk.spill_begin, chunk.spill_nodes);
  });
  threads.for_each(m_chunks.size(), 1, [&](std::size_t index) { m_partial_dots[index] = gather_spills(index, x, y); });
  double dot = 0.0;
  for (const double partial : m_partial_dots)
    dot += partial;
  return dot;
}

template double BlockMatrix::multiply<float>(const AlignedVector<float>&, AlignedVector<float>&, const Threads&) const;
template double BlockMatrix::multiply<double>(const AlignedVector<double>&, AlignedVector<double>&,
                                              const Threads&) const;

std::size_t BlockMatrix::memory_bytes() const {
  std::size_t bytes = m_spill_count * (sizeof(float) + sizeof(double));
  for (const Section& section : m_sections)
    bytes += section.values.size() * (sizeof(double) + sizeof(float)) + section.column.size() * sizeof(std::int32_t);
  return bytes;
}

double BlockMatrix::entry_count() const {
  double count = 0.0;
  for (const Section& section : m_sections)
    count += static_cast<double>(section.values.size());
  return count;
}

template <class Scalar>
void pad(const DofLayout& layout, const std::vector<double>& packed, AlignedVector<Scalar>& padded) {
  padded.assign(layout.padded_count(), Scalar(0));
  for (const NodeSection& section : layout.sections()) {
    const double* in = packed.data() + section.first_dof;
    Scalar* out = padded.data() + section.first_padded;
    for (int node = 0; node < section.node_count; ++node) {
      for (int i = 0; i < section.dofs; ++i)
        out[node * section.stride() + i] = static_cast<Scalar>(in[node * section.dofs + i]);
    }
  }
}

template <class Scalar>
void unpad(const DofLayout& layout, const AlignedVector<Scalar>& padded, std::vector<double>& packed) {
  packed.resize(layout.dof_count());
  for (const NodeSection& section : layout.sections()) {
    double* out = packed.data() + section.first_dof;
    const Scalar* in = padded.data() + section.first_padded;
    for (int node = 0; node < section.node_count; ++node) {
      for (int i = 0; i < section.dofs; ++i)
        out[node * section.dofs + i] = static_cast<double>(in[node * section.stride() + i]);
    }
  }
}

template void pad<float>(const DofLayout&, const std::vector<double>&, AlignedVector<float>&);
template void pad<double>(const DofLayout&, const std::vector<double>&, AlignedVector<double>&);
template void unpad<float>(const DofLayout&, const AlignedVector<float>&, std::vector<double>&);
template void unpad<double>(const DofLayout&, const AlignedVector<double>&, std::vector<double>&);

} // namespace wry::fem
