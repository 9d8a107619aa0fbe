#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <mutex>

#include <suitesparse/cholmod.h>

#include "sim/fem/linear/sparse_factor.h"

namespace wry::fem {

namespace {

/// Debian's CHOLMOD runs two to four times slower when OpenMP and the BLAS under it may use more than one thread, and
/// results must not depend on how many there are: one thread each.
void pin_third_party_threads() {
  using Setter = void (*)(int);
  for (const char* name : {"omp_set_max_active_levels", "openblas_set_num_threads"}) {
    void* symbol = dlsym(RTLD_DEFAULT, name);
    if (symbol != nullptr)
      reinterpret_cast<Setter>(symbol)(name[0] == 'o' && name[1] == 'm' ? 0 : 1);
  }
}

/// OpenBLAS chooses its kernels by the processor's model number: an unknown new model gets those of 2004, three times
/// slower, and different machines get different bits. So the instruction set decides, unless the user's environment
/// does. Once for the process: the first solver's choice stays.
void pin_blas_kernels(Isa isa) {
  static std::once_flag once;
  std::call_once(once, [isa] {
    using Action = void (*)();
    void* quit = dlsym(RTLD_DEFAULT, "gotoblas_dynamic_quit");
    void* init = dlsym(RTLD_DEFAULT, "gotoblas_dynamic_init");
    if (quit == nullptr || init == nullptr || std::getenv("OPENBLAS_CORETYPE") != nullptr)
      return;
    setenv("OPENBLAS_CORETYPE", isa == Isa::avx512 ? "SKYLAKEX" : isa == Isa::avx2 ? "HASWELL" : "NEHALEM", 1);
    reinterpret_cast<Action>(quit)();
    reinterpret_cast<Action>(init)();
  });
}

class CholmodFactor final : public SparseFactor {
public:
  CholmodFactor() {
    cholmod_start(&m_common);
    m_common.supernodal = CHOLMOD_SUPERNODAL;
    m_common.quick_return_if_not_posdef = 1;
    m_common.print = 0;
    m_common.error_handler = nullptr;
    m_common.nmethods = 1;
    m_common.method[0].ordering = CHOLMOD_GIVEN;
    m_common.postorder = 1;
  }

  ~CholmodFactor() override {
    cholmod_free_dense(&m_solution, &m_common);
    cholmod_free_dense(&m_workspace, &m_common);
    cholmod_free_dense(&m_workspace_2, &m_common);
    cholmod_free_factor(&m_factor, &m_common);
    cholmod_free_sparse(&m_sparse, &m_common);
    cholmod_finish(&m_common);
  }

  bool analyse(const BlockMatrix& matrix) {
    pin_blas_kernels(matrix.isa());
    pin_third_party_threads();
    m_pair_rows = matrix.pairs().row_begin;
    m_pair_columns = matrix.pairs().column;
    build_pattern(matrix);
    if (m_sparse == nullptr)
      return false;
    std::vector<int> order = dof_order(matrix);
    m_factor = order.empty() ? nullptr : cholmod_analyze_p(m_sparse, order.data(), nullptr, 0, &m_common);
    if (m_factor == nullptr)
      return false;
    m_cost = {m_common.fl, m_common.lnz};
    return true;
  }

  bool factor(const BlockMatrix& matrix) override {
    pin_third_party_threads();
    const BlockMatrix::Pairs& pairs = matrix.pairs();
    if (pairs.row_begin != m_pair_rows || pairs.column != m_pair_columns) { // contacts came or went
      cholmod_free_factor(&m_factor, &m_common);
      cholmod_free_sparse(&m_sparse, &m_common);
      if (!analyse(matrix))
        return false;
    }
    copy_values(matrix);
    cholmod_factorize(m_sparse, m_factor, &m_common);
    return m_common.status == CHOLMOD_OK && m_factor->minor == m_factor->n;
  }

  void solve(const std::vector<double>& right_side, std::vector<double>& solution) override {
    pin_third_party_threads();
    cholmod_dense input{};
    input.nrow = input.d = input.nzmax = right_side.size();
    input.ncol = 1;
    input.x = const_cast<double*>(right_side.data());
    input.xtype = CHOLMOD_REAL;
    input.dtype = CHOLMOD_DOUBLE;
    cholmod_solve2(CHOLMOD_A, m_factor, &input, nullptr, &m_solution, nullptr, &m_workspace, &m_workspace_2, &m_common);
    const double* values = static_cast<const double*>(m_solution->x);
    solution.assign(values, values + right_side.size());
  }

  FactorCost cost() const override { return m_cost; }

private:
  /// Calls body(column, k) for the pairs of a node with later ones.
  template <class Body> static void for_later_pairs(const BlockMatrix::Pairs& pairs, int node, const Body& body) {
    if (pairs.row_begin.empty())
      return;
    for (std::int64_t k = pairs.row_begin[node]; k < pairs.row_begin[node + 1]; ++k) {
      if (pairs.column[k] > node)
        body(pairs.column[k], k);
    }
  }

  /// The lower half by columns: column (row r, i) holds row i of r's diagonal block from i on, then of its other
  /// blocks, then of its pairs.
  void build_pattern(const BlockMatrix& matrix) {
    const std::size_t size = matrix.layout().dof_count();
    double entries = 0.0;
    for (const BlockMatrix::Section& section : matrix.sections())
      entries += static_cast<double>(section.blocks()) * section.nodes.dofs * section.nodes.dofs;
    entries += 9.0 * static_cast<double>(m_pair_columns.size());
    if (entries > 2e9)
      return;
    const int sorted = m_pair_columns.empty() ? 1 : 0;
    m_sparse =
        cholmod_allocate_sparse(size, size, static_cast<std::size_t>(entries), sorted, 1, -1, CHOLMOD_REAL, &m_common);
    if (m_sparse == nullptr)
      return;
    int* starts = static_cast<int*>(m_sparse->p);
    int* rows = static_cast<int*>(m_sparse->i);
    int next = 0;
    for (const BlockMatrix::Section& section : matrix.sections()) {
      const int d = section.nodes.dofs;
      const int first = static_cast<int>(section.nodes.first_dof);
      for (int node = 0; node < section.nodes.node_count; ++node) {
        for (int i = 0; i < d; ++i) {
          starts[first + node * d + i] = next;
          for (int j = i; j < d; ++j)
            rows[next++] = first + node * d + j;
          for (std::int64_t k = section.row_begin[node] + 1; k < section.row_begin[node + 1]; ++k) {
            for (int j = 0; j < d; ++j)
              rows[next++] = first + section.column[k] * d + j;
          }
          for_later_pairs(matrix.pairs(), section.nodes.first_node + node, [&](std::int32_t column, std::int64_t) {
            for (int j = 0; i < 3 && j < 3; ++j)
              rows[next++] = static_cast<int>(matrix.layout().dof(column)) + j;
          });
        }
      }
    }
    starts[size] = next;
  }

  void copy_values(const BlockMatrix& matrix) {
    double* out = static_cast<double*>(m_sparse->x);
    for (const BlockMatrix::Section& section : matrix.sections()) {
      const int d = section.nodes.dofs;
      for (int node = 0; node < section.nodes.node_count; ++node) {
        const std::int64_t first = section.row_begin[node];
        for (int i = 0; i < d; ++i) {
          out = std::copy_n(section.values.data() + first * d * d + i * d + i, d - i, out);
          for (std::int64_t k = first + 1; k < section.row_begin[node + 1]; ++k)
            out = std::copy_n(section.values.data() + k * d * d + i * d, d, out);
          for_later_pairs(matrix.pairs(), section.nodes.first_node + node, [&](std::int32_t, std::int64_t k) {
            if (i < 3)
              out = std::copy_n(matrix.pairs().values.data() + 9 * k + 3 * i, 3, out);
          });
        }
      }
    }
  }

  /// A fill-reducing order of the nodes by METIS (AMD if that fails), spread out to their unknowns.
  std::vector<int> dof_order(const BlockMatrix& matrix) {
    const DofLayout& layout = matrix.layout();
    std::size_t blocks = 0;
    for (const BlockMatrix::Section& section : matrix.sections())
      blocks += static_cast<std::size_t>(section.blocks());
    blocks += m_pair_columns.size() / 2;
    const int sorted = m_pair_columns.empty() ? 1 : 0;
    cholmod_sparse* graph = cholmod_allocate_sparse(layout.node_count(), layout.node_count(), blocks, sorted, 1, -1,
                                                    CHOLMOD_PATTERN, &m_common);
    if (graph == nullptr)
      return {};
    int* starts = static_cast<int*>(graph->p);
    int* rows = static_cast<int*>(graph->i);
    int next = 0;
    for (const BlockMatrix::Section& section : matrix.sections()) {
      for (int node = 0; node < section.nodes.node_count; ++node) {
        starts[section.nodes.first_node + node] = next;
        for (std::int64_t k = section.row_begin[node]; k < section.row_begin[node + 1]; ++k)
          rows[next++] = section.nodes.first_node + section.column[k];
        for_later_pairs(matrix.pairs(), section.nodes.first_node + node,
                        [&](std::int32_t column, std::int64_t) { rows[next++] = column; });
      }
    }
    starts[layout.node_count()] = next;
    std::vector<int> nodes(layout.node_count());
    const bool ordered = cholmod_metis(graph, nullptr, 0, 1, nodes.data(), &m_common) ||
                         cholmod_amd(graph, nullptr, 0, nodes.data(), &m_common);
    cholmod_free_sparse(&graph, &m_common);
    std::vector<int> order;
    for (std::size_t i = 0; ordered && i < nodes.size(); ++i) {
      for (int k = 0; k < layout.dofs(nodes[i]); ++k)
        order.push_back(static_cast<int>(layout.dof(nodes[i])) + k);
    }
    return order;
  }

  std::vector<std::int64_t> m_pair_rows; ///< of the pattern that was analysed
  std::vector<std::int32_t> m_pair_columns;
  cholmod_common m_common{};
  cholmod_sparse* m_sparse = nullptr;
  cholmod_factor* m_factor = nullptr;
  cholmod_dense* m_solution = nullptr;
  cholmod_dense* m_workspace = nullptr;
  cholmod_dense* m_workspace_2 = nullptr;
  FactorCost m_cost;
};

} // namespace

Result<std::unique_ptr<SparseFactor>> SparseFactor::create(const BlockMatrix& matrix) {
  std::unique_ptr<CholmodFactor> factor = std::make_unique<CholmodFactor>();
  if (!factor->analyse(matrix))
    return make_error(
        ErrorCode::out_of_memory,
        "direct linear solve of {} unknowns: the factor's pattern does not fit into memory; use a coarser "
        "mesh or fem.linear_solver = \"pcg\"",
        matrix.layout().dof_count());
  return std::unique_ptr<SparseFactor>(std::move(factor));
}

} // namespace wry::fem
