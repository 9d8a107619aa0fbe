#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace wry::fem {

/// A run of consecutive nodes that all have the same number of unknowns.
struct NodeSection {
  int first_node = 0;
  int node_count = 0;
  int dofs = 3;                 ///< per node: 3 (v), or 6 (v, omega)
  std::size_t first_dof = 0;    ///< of the section's first node in a packed vector
  std::size_t first_padded = 0; ///< the same in a padded vector

  /// Entries of a node in a padded vector: rows are padded to a vector register.
  int stride() const { return dofs == 3 ? 4 : 8; }
};

/// Where the unknowns of each node stand. Packed vectors hold the unknowns [v0 v1 ...] or [v0 omega0 v1 omega1 ...]
/// without gaps; padded vectors hold 4 or 8 entries per node, the surplus ones zero.
class DofLayout {
public:
  /// Adds nodes after those that are there.
  void append(int node_count, int dofs);

  const std::vector<NodeSection>& sections() const { return m_sections; }
  int node_count() const { return m_node_count; }
  std::size_t dof_count() const { return m_dof_count; }
  std::size_t padded_count() const { return m_padded_count; }
  const NodeSection& section_of(int node) const;

  /// Place of a node's first unknown in a packed vector; omega, where there is one, follows v.
  std::size_t dof(int node) const { return m_node_dof[static_cast<std::size_t>(node)]; }
  int dofs(int node) const { return static_cast<int>(m_node_dof[node + 1] - m_node_dof[node]); }

private:
  std::vector<NodeSection> m_sections;
  std::vector<std::size_t> m_node_dof = {0};
  int m_node_count = 0;
  std::size_t m_dof_count = 0;
  std::size_t m_padded_count = 0;
};

} // namespace wry::fem
