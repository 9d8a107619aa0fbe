#include "sim/fem/linear/dof_layout.h"

namespace wry::fem {

void DofLayout::append(int node_count, int dofs) {
  if (!m_sections.empty() && m_sections.back().dofs == dofs)
    m_sections.back().node_count += node_count;
  else
    m_sections.push_back({m_node_count, node_count, dofs, m_dof_count, m_padded_count});
  for (int node = 0; node < node_count; ++node)
    m_node_dof.push_back(m_node_dof.back() + static_cast<std::size_t>(dofs));
  m_node_count += node_count;
  m_dof_count += static_cast<std::size_t>(node_count) * dofs;
  m_padded_count += static_cast<std::size_t>(node_count) * m_sections.back().stride();
}

const NodeSection& DofLayout::section_of(int node) const {
  for (const NodeSection& section : m_sections) {
    if (node < section.first_node + section.node_count)
      return section;
  }
  return m_sections.back();
}

} // namespace wry::fem
