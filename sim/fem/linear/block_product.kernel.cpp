#include <cstdint>

#include "sim/fem/linear/block_product_isa.h"

// Compiled once per instruction set: no inline functions of other headers may be used here.

namespace wry::fem::WRY_ISA {

namespace {

template <class Scalar, int STRIDE> struct Lanes {
  typedef Scalar Vector __attribute__((vector_size(sizeof(Scalar) * STRIDE)));
  typedef Scalar Loose __attribute__((vector_size(sizeof(Scalar) * STRIDE), aligned(sizeof(Scalar)), may_alias));
};

template <class Scalar, int D, int STRIDE>
void multiply(const BlockRows<Scalar>& rows, int begin, int end, const Scalar* __restrict x, Scalar* __restrict y,
              Scalar* __restrict spill, int spill_nodes) {
  using Vector = typename Lanes<Scalar, STRIDE>::Vector;
  using Loose = typename Lanes<Scalar, STRIDE>::Loose;
  for (std::int64_t i = std::int64_t(begin) * STRIDE; i < std::int64_t(end) * STRIDE; ++i)
    y[i] = 0;
  for (std::int64_t i = 0; i < std::int64_t(spill_nodes) * STRIDE; ++i)
    spill[i] = 0;
  for (int row = begin; row < end; ++row) {
    const std::int64_t first = rows.row_begin[row];
    const std::int64_t last = rows.row_begin[row + 1];
    Vector mine[D];
    Vector sums[D];
    const Vector own = *reinterpret_cast<const Loose*>(x + std::int64_t(row) * STRIDE);
    const Scalar* block = rows.values + first * (D * D);
    for (int i = 0; i < D; ++i) {
      mine[i] = own[i] - Vector{};
      sums[i] = *reinterpret_cast<const Loose*>(block + i * D) * own;
    }
    for (std::int64_t k = first + 1; k < last; ++k) {
      block += D * D;
      const std::int64_t column = rows.column[k];
      const Vector other = *reinterpret_cast<const Loose*>(x + column * STRIDE);
      Scalar* target = column < end ? y + column * STRIDE : spill + (column - end) * STRIDE;
      Vector mirrored = *reinterpret_cast<const Loose*>(target);
      for (int i = 0; i < D; ++i) {
        const Vector entries = *reinterpret_cast<const Loose*>(block + i * D);
        sums[i] += entries * other;
        mirrored += entries * mine[i];
      }
      *reinterpret_cast<Loose*>(target) = mirrored;
    }
    Scalar* out = y + std::int64_t(row) * STRIDE;
    for (int i = 0; i < D; ++i) {
      Scalar sum = sums[i][0];
      for (int j = 1; j < D; ++j)
        sum += sums[i][j];
      out[i] += sum;
    }
    for (int i = D; i < STRIDE; ++i)
      out[i] = 0;
  }
}

/// Nodes whose dot products are summed in the vectors' own precision before they go into a double.
constexpr int DOT_RUN = 32;

template <class Scalar, int STRIDE> double sum_of(const typename Lanes<Scalar, STRIDE>::Vector& lanes) {
  double sum = 0.0;
  for (int i = 0; i < STRIDE; ++i)
    sum += static_cast<double>(lanes[i]);
  return sum;
}

template <class Scalar, int D, int STRIDE>
void update(int begin, int end, Scalar alpha, const Scalar* __restrict inverses, const Scalar* __restrict p,
            const Scalar* __restrict q, Scalar* __restrict x, Scalar* __restrict r, Scalar* __restrict z,
            double* dots) {
  using Vector = typename Lanes<Scalar, STRIDE>::Vector;
  using Loose = typename Lanes<Scalar, STRIDE>::Loose;
  dots[0] = dots[1] = 0.0;
  for (int first = begin; first < end; first += DOT_RUN) {
    const int last = first + DOT_RUN < end ? first + DOT_RUN : end;
    Vector squares{};
    Vector products{};
    for (int node = first; node < last; ++node) {
      const std::int64_t at = std::int64_t(node) * STRIDE;
      const Scalar* inverse = inverses + at * D;
      *reinterpret_cast<Loose*>(x + at) += alpha * *reinterpret_cast<const Loose*>(p + at);
      const Vector residual = *reinterpret_cast<const Loose*>(r + at) - alpha * *reinterpret_cast<const Loose*>(q + at);
      *reinterpret_cast<Loose*>(r + at) = residual;
      Vector turned = *reinterpret_cast<const Loose*>(inverse) * residual[0];
      for (int column = 1; column < D; ++column)
        turned += *reinterpret_cast<const Loose*>(inverse + column * STRIDE) * residual[column];
      *reinterpret_cast<Loose*>(z + at) = turned;
      squares += residual * residual;
      products += residual * turned;
    }
    dots[0] += sum_of<Scalar, STRIDE>(squares);
    dots[1] += sum_of<Scalar, STRIDE>(products);
  }
}

template <class Scalar, int STRIDE>
double dot(int begin, int end, const Scalar* __restrict x, const Scalar* __restrict y) {
  using Vector = typename Lanes<Scalar, STRIDE>::Vector;
  using Loose = typename Lanes<Scalar, STRIDE>::Loose;
  double sum = 0.0;
  for (int first = begin; first < end; first += DOT_RUN) {
    const int last = first + DOT_RUN < end ? first + DOT_RUN : end;
    Vector products{};
    for (int node = first; node < last; ++node) {
      const std::int64_t at = std::int64_t(node) * STRIDE;
      products += *reinterpret_cast<const Loose*>(x + at) * *reinterpret_cast<const Loose*>(y + at);
    }
    sum += sum_of<Scalar, STRIDE>(products);
  }
  return sum;
}

template <class Scalar, int D, int STRIDE> BlockFunctions<Scalar> functions() {
  return {&multiply<Scalar, D, STRIDE>, &update<Scalar, D, STRIDE>, &dot<Scalar, STRIDE>};
}

} // namespace

BlockProductTable block_products() {
  return {functions<float, 3, 4>(), functions<float, 6, 8>(), functions<double, 3, 4>(), functions<double, 6, 8>()};
}

} // namespace wry::fem::WRY_ISA
