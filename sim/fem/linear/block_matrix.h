#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/base/aligned.h"
#include "sim/base/parallel.h"
#include "sim/fem/linear/block_product.h"
#include "sim/fem/linear/dof_layout.h"

namespace wry::fem {

/// A symmetric matrix of one d x d block per pair of neighbouring nodes (d = 3 or 6), of which the upper half is
/// stored. The pattern is fixed; values are double, with a float copy for solves that need no more. Products are
/// parallel and give the same bits on any number of threads.
class BlockMatrix {
public:
  /// The rows of one section of the layout; node numbers are relative to the section.
  struct Section {
    NodeSection nodes;
    std::vector<std::int64_t> row_begin; ///< node_count + 1, in blocks
    std::vector<std::int32_t> column;    ///< per block, ascending in a row, the diagonal first
    AlignedVector<double> values;        ///< per block d x d row-major, and padding
    AlignedVector<float> single;         ///< copy of values
    std::int64_t blocks() const { return row_begin.back(); }
  };

  /// `tets`: the global nodes of each element, ascending; nodes of one element belong to one section.
  BlockMatrix(const DofLayout& layout, const std::vector<std::array<std::int32_t, 4>>& tets, Isa isa);

  const DofLayout& layout() const { return *m_layout; }
  Isa isa() const { return m_isa; }
  std::vector<Section>& sections() { return m_sections; }
  const std::vector<Section>& sections() const { return m_sections; }

  /// Number of a block within its section; row <= column, global nodes; -1 if the pattern has none.
  std::int64_t find(int row, int column) const;

  /// Adds to the v,v part of the diagonal block of a node.
  void add_velocity_diagonal(int node, const double* block3x3);
  /// Adds to the omega,omega part of the diagonal block of a node that has one.
  void add_angular_diagonal(int node, const double* block3x3);

  /// Adds to the v,v blocks of a pair of different nodes, row-major, and its mirror image. Pairs that the pattern lacks
  /// are kept beside it until set_zero; finish_pairs makes them count.
  void add_velocity_pair(int row, int column, const double* block3x3);
  /// Sums the pairs beside the pattern, in the order in which they were added. To be called once after the last one.
  void finish_pairs();
  bool has_pairs() const { return !m_pairs.column.empty(); }
  /// v,v blocks beside the pattern, both halves: row r at [row_begin[r], row_begin[r + 1]), all nodes in one numbering.
  struct Pairs {
    std::vector<std::int64_t> row_begin; ///< node_count + 1; empty without pairs
    std::vector<std::int32_t> column;    ///< ascending in a row
    std::vector<double> values;          ///< 3 x 3 row-major
    std::vector<float> single;
  };
  const Pairs& pairs() const { return m_pairs; }
  /// Puts pairs back that were taken from a matrix of the same layout.
  void set_pairs(Pairs pairs) { m_pairs = std::move(pairs); }

  void set_zero(const Threads& threads);
  /// Turns the rows and columns of the held unknowns (packed, nonzero: held) into those of the identity.
  void hold(const std::vector<char>& held, const Threads& threads);
  /// Renews the float copy.
  void update_single(const Threads& threads);
  /// Writes the diagonal to a packed vector.
  void diagonal(std::vector<double>& out) const;

  /// y <- A x for padded vectors; returns x . y.
  template <class Scalar>
  double multiply(const AlignedVector<Scalar>& x, AlignedVector<Scalar>& y, const Threads& threads) const;

  /// The functions that iterations on a section's vectors run.
  template <class Scalar> const BlockFunctions<Scalar>& functions(const Section& section) const {
    return block_functions<Scalar>(m_products, section.nodes.dofs);
  }

  std::size_t memory_bytes() const;
  /// Stored entries, for cost estimates.
  double entry_count() const;

private:
  /// Rows [begin, end) of a section are multiplied together; what they add to later rows waits in a spill.
  struct Chunk {
    int section = 0;
    int begin = 0, end = 0;
    int spill_nodes = 0;
    std::size_t spill_begin = 0;  ///< in entries of the workspace
    std::size_t first_source = 0; ///< the first chunk whose spill reaches this one
  };

  /// A block that was added beside the pattern.
  struct PairEntry {
    std::int32_t row, column;
    double values[9];
  };

  template <class Scalar> const Scalar* pair_values() const;
  template <class Scalar>
  void multiply_pairs(const NodeSection& nodes, int begin, int end, const Scalar* x, Scalar* y) const;
  void add_diagonal(int node, int offset, const double* block3x3);
  void cut_into_chunks(int section);
  void find_spill_sources();
  template <class Scalar> const Scalar* values_of(const Section& section) const;
  template <class Scalar>
  double gather_spills(std::size_t chunk, const AlignedVector<Scalar>& x, AlignedVector<Scalar>& y) const;
  template <class Scalar> AlignedVector<Scalar>& spills() const;

  const DofLayout* m_layout;
  Isa m_isa;
  std::vector<Section> m_sections;
  std::vector<Chunk> m_chunks;
  BlockProductTable m_products;
  std::size_t m_spill_count = 0;
  mutable AlignedVector<float> m_single_spills;
  mutable AlignedVector<double> m_double_spills;
  mutable std::vector<double> m_partial_dots;
  std::vector<PairEntry> m_pair_entries;
  std::vector<std::int64_t> m_pair_order;
  Pairs m_pairs;
  std::vector<std::size_t> m_padded_of_node; ///< filled with the first pairs
};

/// Packed to padded: surplus entries are zero.
template <class Scalar>
void pad(const DofLayout& layout, const std::vector<double>& packed, AlignedVector<Scalar>& padded);
/// Padded to packed.
template <class Scalar>
void unpad(const DofLayout& layout, const AlignedVector<Scalar>& padded, std::vector<double>& packed);

} // namespace wry::fem
