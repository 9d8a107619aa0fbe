#include "sim/base/pack.h"
#include "sim/fem/kernels/batch.h"

namespace wry::fem::WRY_ISA {

namespace {

#define WRY_INLINE [[gnu::always_inline]] inline

using wry::WRY_ISA::abs;
using wry::WRY_ISA::Bits;
using wry::WRY_ISA::load;
using wry::WRY_ISA::max;
using wry::WRY_ISA::Real;
using wry::WRY_ISA::sqrt;
using wry::WRY_ISA::store;
constexpr int WIDTH = wry::WRY_ISA::WIDTH;

WRY_INLINE bool any(Bits mask) {
  std::int64_t found = 0;
  for (int lane = 0; lane < WIDTH; ++lane)
    found |= mask[lane];
  return found != 0;
}

/// Share of the largest diagonal entry that passes for round-off: rigid motions have eigenvalue zero.
constexpr double ROUND_OFF = 1e-9;

/// The first entry of the block of nodes k <= l.
WRY_INLINE int block_at(int k, int l) {
  constexpr int FIRST[4] = {0, 3, 5, 6}; // 00 01 02 03 11 12 13 22 23 33
  return (FIRST[k] + l) * 9 * LANES;
}

/// Lanes whose matrix of twelve unknowns, inertia and all, is not positive semidefinite: an elimination meets a pivot
/// that is not positive.
WRY_INLINE Bits find_indefinite(const double* hessian, const Real* inertia) {
  constexpr int SIZE = 12;
  Real a[SIZE][SIZE]; // lower triangle
  Real scale{};
  for (int k = 0; k < 4; ++k) {
    for (int l = k; l < 4; ++l) {
      for (int i = 0; i < 9; ++i)
        a[3 * l + i % 3][3 * k + i / 3] = load(hessian + block_at(k, l) + i * LANES);
    }
    for (int i = 0; i < 3; ++i) {
      a[3 * k + i][3 * k + i] += inertia[k];
      scale = max(scale, abs(a[3 * k + i][3 * k + i]));
    }
  }
  Bits indefinite{};
  for (int j = 0; j < SIZE; ++j) {
    const Real pivot = a[j][j] + ROUND_OFF * scale;
    indefinite |= ~Bits(pivot > 0.0);
    const Real inverse = 1.0 / pivot;
    for (int i = j + 1; i < SIZE; ++i) {
      const Real factor = inverse * a[i][j];
      for (int k = j + 1; k <= i; ++k)
        a[i][k] -= factor * a[k][j];
    }
  }
  return indefinite;
}

/// Orthonormal differences of the four nodes: what is left beside their sum.
constexpr double DIFFERENCES[3][4] = {{0.5, 0.5, -0.5, -0.5}, {0.5, -0.5, 0.5, -0.5}, {0.5, -0.5, -0.5, 0.5}};

constexpr int SIZE = 9;

/// The matrix in those directions; upper triangle.
WRY_INLINE void apart_from_translations(const double* hessian, Real (*out)[SIZE]) {
  for (int b = 0; b < 3; ++b) {
    Real half[4][9]; // node k, times the difference b
    for (int k = 0; k < 4; ++k) {
      for (int i = 0; i < 9; ++i) {
        half[k][i] = Real{};
        for (int l = 0; l < 4; ++l) {
          const int transposed = i % 3 * 3 + i / 3;
          const Real entry =
              k <= l ? load(hessian + block_at(k, l) + i * LANES) : load(hessian + block_at(l, k) + transposed * LANES);
          half[k][i] += DIFFERENCES[b][l] * entry;
        }
      }
    }
    for (int a = 0; a <= b; ++a) {
      for (int i = 0; i < 9; ++i) {
        Real sum{};
        for (int k = 0; k < 4; ++k)
          sum += DIFFERENCES[a][k] * half[k][i];
        out[3 * a + i / 3][3 * b + i % 3] = sum;
      }
    }
  }
}

/// A turn in the plane of two of the unknowns.
struct Turn {
  int p, q;
  Real cosine, sine;
};

/// That which makes entry p, q vanish, by 45 degrees at most.
WRY_INLINE Turn find_turn(const Real (*a)[SIZE], int first, int second) {
  Turn turn;
  turn.p = first < second ? first : second;
  turn.q = first < second ? second : first;
  const Real gap = a[turn.q][turn.q] - a[turn.p][turn.p], twice = 2.0 * a[turn.p][turn.q];
  constexpr double TINY = 1e-290;
  const Real tangent = (gap < 0.0 ? -twice : twice) / (abs(gap) + sqrt(gap * gap + twice * twice) + TINY);
  turn.cosine = 1.0 / sqrt(1.0 + tangent * tangent);
  turn.sine = tangent * turn.cosine;
  return turn;
}

WRY_INLINE void rotate(const Turn& turn, Real& p, Real& q) {
  const Real before = p;
  p = turn.cosine * before - turn.sine * q;
  q = turn.sine * before + turn.cosine * q;
}

WRY_INLINE void apply(const Turn& turn, Real (*a)[SIZE], Real (*vectors)[SIZE]) {
  const int p = turn.p, q = turn.q;
  const Real c = turn.cosine, s = turn.sine;
  const Real pp = a[p][p], qq = a[q][q], pq = a[p][q];
  a[p][p] = c * c * pp - 2.0 * c * s * pq + s * s * qq;
  a[q][q] = s * s * pp + 2.0 * c * s * pq + c * c * qq;
  a[p][q] = c * s * (pp - qq) + (c * c - s * s) * pq;
  for (int k = 0; k < p; ++k)
    rotate(turn, a[k][p], a[k][q]);
  for (int k = p + 1; k < q; ++k)
    rotate(turn, a[p][k], a[k][q]);
  for (int k = q + 1; k < SIZE; ++k)
    rotate(turn, a[p][k], a[q][k]);
  for (int k = 0; k < SIZE; ++k)
    rotate(turn, vectors[p][k], vectors[q][k]);
}

/// Eigenvalues on the diagonal and eigenvectors in rows, by cyclic Jacobi rotations, until it holds for the lanes that
/// count. Pairs in rounds, as in a tournament: those of a round have nothing to do with each other.
void diagonalise(Real (*a)[SIZE], Real (*vectors)[SIZE], Bits counts) {
  constexpr int MOST_SWEEPS = 12;
  constexpr double DONE = 1e-28; // squared, over that of the whole
  for (int i = 0; i < SIZE; ++i) {
    for (int j = 0; j < SIZE; ++j)
      vectors[i][j] = Real{} + (i == j ? 1.0 : 0.0);
  }
  for (int sweep = 0; sweep < MOST_SWEEPS; ++sweep) {
    Real beside{}, whole{};
    for (int i = 0; i < SIZE; ++i) {
      whole += a[i][i] * a[i][i];
      for (int j = i + 1; j < SIZE; ++j)
        beside += a[i][j] * a[i][j];
    }
    if (!any((beside > DONE * (whole + beside)) & counts))
      return;
    for (int round = 0; round < SIZE; ++round) {
      constexpr int PAIRS = SIZE / 2;
      Turn turns[PAIRS];
      for (int i = 0; i < PAIRS; ++i)
        turns[i] = find_turn(a, (round + i + 1) % SIZE, (round + SIZE - i - 1) % SIZE);
      for (const Turn& turn : turns)
        apply(turn, a, vectors);
    }
  }
}

/// Adds lack v v^T to the matrices of some elements, v in the directions without translations.
WRY_INLINE void stiffen(double* hessian, const Real* v, Real lack, Bits which) {
  Real moved[4][3];
  for (int k = 0; k < 4; ++k) {
    for (int i = 0; i < 3; ++i)
      moved[k][i] = DIFFERENCES[0][k] * v[i] + DIFFERENCES[1][k] * v[3 + i] + DIFFERENCES[2][k] * v[6 + i];
  }
  for (int k = 0; k < 4; ++k) {
    for (int i = 0; i < 3; ++i) {
      const Real scaled = lack * moved[k][i];
      for (int l = k; l < 4; ++l) {
        double* row = hessian + block_at(k, l) + 3 * i * LANES;
        for (int j = 0; j < 3; ++j) {
          const Real before = load(row + j * LANES), after = before + scaled * moved[l][j];
          store(row + j * LANES, which ? after : before);
        }
      }
    }
  }
}

int project_elements(double* hessian, int count, const double (*inertia)[LANES]) {
  int projected = 0;
  for (int lane = 0; lane < count; lane += WIDTH) {
    Real at[4];
    for (int k = 0; k < 4; ++k)
      at[k] = load(inertia[k] + lane);
    Bits indefinite = find_indefinite(hessian + lane, at);
    for (int i = 0; i < WIDTH; ++i) {
      indefinite[i] = lane + i < count ? indefinite[i] : 0;
      projected += indefinite[i] != 0 ? 1 : 0;
    }
    if (!any(indefinite))
      continue;
    Real rest[SIZE][SIZE], vectors[SIZE][SIZE];
    apart_from_translations(hessian + lane, rest);
    diagonalise(rest, vectors, indefinite);
    Real least = at[0];
    for (int k = 1; k < 4; ++k)
      least = at[k] < least ? at[k] : least;
    for (int mode = 0; mode < SIZE; ++mode) {
      const Bits below = indefinite & (rest[mode][mode] < -least);
      if (any(below))
        stiffen(hessian + lane, vectors[mode], -least - rest[mode][mode], below);
    }
  }
  return projected;
}

} // namespace

int project(double* hessian, int count, const double (*inertia)[LANES]) {
  return project_elements(hessian, count, inertia);
}

} // namespace wry::fem::WRY_ISA
