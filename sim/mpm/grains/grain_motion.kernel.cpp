#include "sim/mpm/grains/grain_batch.h"
#include "sim/mpm/kernels/weights.h"

namespace wry::mpm::WRY_ISA {

namespace {

using wry::WRY_ISA::Bits;
using wry::WRY_ISA::load;
using wry::WRY_ISA::max;
using wry::WRY_ISA::min;
using wry::WRY_ISA::Real;
using wry::WRY_ISA::splat;
using wry::WRY_ISA::sqrt;
using wry::WRY_ISA::store;
constexpr int REALS = wry::WRY_ISA::WIDTH;
constexpr int GRAINS = GRAINS_AT_ONCE;

/// As many floats as a Real has numbers.
typedef float Floats __attribute__((vector_size(WRY_ISA_BYTES / 2), aligned(4), may_alias));
WRY_INLINE Real widen(const float* from) {
  return __builtin_convertvector(*reinterpret_cast<const Floats*>(from), Real);
}
WRY_INLINE void narrow(float* to, Real value) {
  *reinterpret_cast<Floats*>(to) = __builtin_convertvector(value, Floats);
}
/// Whether there is a lane for which a comparison holds.
template <class Mask> WRY_INLINE bool any(Mask mask) {
  std::int64_t found = 0;
  for (int lane = 0; lane < REALS; ++lane)
    found |= mask[lane];
  return found != 0;
}

struct Three {
  Real x, y, z;
};
WRY_INLINE Three cross(const Three& a, const Three& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
WRY_INLINE Real dot(const Three& a, const Three& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
WRY_INLINE Three times(Real factor, const Three& a) {
  return {factor * a.x, factor * a.y, factor * a.z};
}
template <class Mask> WRY_INLINE Three choose(Mask mask, const Three& a, const Three& b) {
  return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}
struct Rows {
  Three row[3];
};
WRY_INLINE Three operator*(const Rows& m, const Three& v) {
  return {dot(m.row[0], v), dot(m.row[1], v), dot(m.row[2], v)};
}
struct Quaternion {
  Real w;
  Three v;
};
WRY_INLINE Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  const Three turned = cross(a.v, b.v);
  return {a.w * b.w - dot(a.v, b.v),
          {a.w * b.v.x + b.w * a.v.x + turned.x, a.w * b.v.y + b.w * a.v.y + turned.y,
           a.w * b.v.z + b.w * a.v.z + turned.z}};
}
WRY_INLINE Real squared_norm(const Quaternion& q) {
  return q.w * q.w + dot(q.v, q.v);
}

/// Where the grains of a batch are among the nodes, and their weights: quadratic B-splines.
struct Stencils {
  alignas(64) float from_first[3][GRAINS]; ///< x minus the first node, in [1/2, 3/2)
  alignas(64) float weight[3][3][GRAINS];
  alignas(64) float moment[3][3][GRAINS]; ///< weight times node minus point [cells]
  int first[GRAINS];                      ///< node of the halo
};

/// Around the midpoints of their ways. Nothing but `first` knows the block, so that a grain's answer is the same, bit
/// for bit, whichever block it is sorted into.
WRY_INLINE void find_stencils(const FlowNodes& nodes, double dt, const GrainBatch& batch, Stencils& out) {
  const double per_length = 1.0 / nodes.cell;
  for (int lane = 0; lane < GRAINS; lane += REALS) {
    Real first{};
    for (int axis = 0; axis < 3; ++axis) {
      const Real x = per_length * (load(batch.position[axis] + lane) + (0.5 * dt) * load(batch.velocity[axis] + lane));
      const Real base = nearest<double>(x) - 1.0;
      narrow(out.from_first[axis] + lane, x - base);
      const Real in_halo = base - nodes.origin[axis] + 1.0; // the halo begins a node earlier
      first = double(HALO_SIDE) * first + min(max(in_halo, Real{}), splat(double(HALO_SIDE - 3)));
    }
    for (int i = 0; i < REALS; ++i)
      out.first[lane + i] = static_cast<int>(first[i]);
  }
  constexpr int WIDE = LANES<float>;
  for (int axis = 0; axis < 3; ++axis) {
    for (int lane = 0; lane < GRAINS; lane += WIDE) {
      const Pack<float> f = load(out.from_first[axis] + lane);
      const Pack<float> to_end = 1.5F - f, from_start = f - 0.5F, middle = f - 1.0F;
      const Pack<float> weight[3] = {0.5F * to_end * to_end, 0.75F - middle * middle, 0.5F * from_start * from_start};
      for (int node = 0; node < 3; ++node) {
        store(out.weight[axis][node] + lane, weight[node]);
        store(out.moment[axis][node] + lane, weight[node] * (float(node) - f));
      }
    }
  }
}

/// Sums over nodes of flow: by component (velocity, activity), and times distance along each axis.
struct Sums {
  enum { PLAIN, X, Y, Z, COUNT };
  alignas(64) float of[COUNT][NODE_VALUES][GRAINS];
};

WRY_INLINE void put(const float* four, int grain, float (*to)[GRAINS]) {
  for (int i = 0; i < NODE_VALUES; ++i)
    to[i][grain] = four[i];
}

/// Axis by axis, since weights are products.
WRY_INLINE void sum_flow(const float* flow, const Stencils& stencils, int grain, Sums& sums) {
  using T = float;
  const float* at = flow + stencils.first[grain] * NODE_VALUES;
  Row<T> plain{}, along_x{}, along_y{};
  for (int i = 0; i < 3; ++i) {
    Row<T> plane{}, slope{};
    for (int j = 0; j < 3; ++j) {
      const float* row = at + i * NEXT_X + j * NEXT_Y;
      for (int r = 0; r < ROW<T>; ++r) {
        const Pack<T> value = load_loose(row + r * LANES<T>);
        plane.part[r] += stencils.weight[1][j][grain] * value;
        slope.part[r] += stencils.moment[1][j][grain] * value;
      }
    }
    for (int r = 0; r < ROW<T>; ++r) {
      plain.part[r] += stencils.weight[0][i][grain] * plane.part[r];
      along_x.part[r] += stencils.moment[0][i][grain] * plane.part[r];
      along_y.part[r] += stencils.weight[0][i][grain] * slope.part[r];
    }
  }
  float weights[NODE_VALUES] = {}, moments[NODE_VALUES] = {}, four[NODE_VALUES];
  for (int k = 0; k < 3; ++k) {
    weights[k] = stencils.weight[2][k][grain];
    moments[k] = stencils.moment[2][k][grain];
  }
  const Row<T> wz = per_node(weights);
  contract(plain, wz, four);
  put(four, grain, sums.of[Sums::PLAIN]);
  contract(along_x, wz, four);
  put(four, grain, sums.of[Sums::X]);
  contract(along_y, wz, four);
  put(four, grain, sums.of[Sums::Y]);
  contract(plain, per_node(moments), four);
  put(four, grain, sums.of[Sums::Z]);
}

WRY_INLINE float density_around(const float* density, const Stencils& stencils, int grain) {
  const float* at = density + stencils.first[grain];
  float sum = 0.0F;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const float* row = at + (i * HALO_SIDE + j) * HALO_SIDE;
      float along = 0.0F;
      for (int k = 0; k < 3; ++k)
        along += stencils.weight[2][k][grain] * row[k];
      sum += stencils.weight[0][i][grain] * stencils.weight[1][j][grain] * along;
    }
  }
  return sum;
}

/// (h^2/4) K^-1 of a stencil with inactive nodes, K their second moment about their mean; its inverse is damped where
/// the nodes lie in a plane, and one of a full stencil. Times a gradient, in place.
void shrink(const float* flow, const Stencils& s, int grain, double inverse, const double* centre,
            double (*gradient)[3]) {
  float squared[3][3]; // weight times squared distance, per axis and node
  for (int axis = 0; axis < 3; ++axis) {
    for (int node = 0; node < 3; ++node) {
      const float weight = s.weight[axis][node][grain], moment = s.moment[axis][node][grain];
      squared[axis][node] = weight > 1e-9F ? moment * moment / weight : 0.0F;
    }
  }
  float xx = 0.0F, yy = 0.0F, zz = 0.0F, yz = 0.0F, xz = 0.0F, xy = 0.0F;
  for (int i = 0; i < 3; ++i) {
    const float wx = s.weight[0][i][grain], dx = s.moment[0][i][grain];
    for (int j = 0; j < 3; ++j) {
      const float wy = s.weight[1][j][grain], dy = s.moment[1][j][grain];
      const float* row = flow + (s.first[grain] + (i * HALO_SIDE + j) * HALO_SIDE) * NODE_VALUES;
      float plain = 0.0F, slope = 0.0F, curve = 0.0F;
      for (int k = 0; k < 3; ++k) {
        const float active = row[k * NODE_VALUES + 3];
        plain += active * s.weight[2][k][grain];
        slope += active * s.moment[2][k][grain];
        curve += active * squared[2][k];
      }
      xx += squared[0][i] * wy * plain;
      yy += wx * squared[1][j] * plain;
      zz += wx * wy * curve;
      yz += wx * dy * slope;
      xz += dx * wy * slope;
      xy += dx * dy * plain;
    }
  }
  constexpr double DAMPING = 0.05;
  const double moments[3][3] = {{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
  double damped[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      damped[i][j] =
          (4.0 * (moments[i][j] * inverse - centre[i] * centre[j]) + (i == j ? DAMPING : 0.0)) / (1.0 + DAMPING);
  }
  double adjugate[3][3];
  for (int i = 0; i < 3; ++i) {
    const int a = (i + 1) % 3, b = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int c = (j + 1) % 3, d = (j + 2) % 3;
      adjugate[j][i] = damped[a][c] * damped[b][d] - damped[a][d] * damped[b][c];
    }
  }
  const double per_determinant =
      1.0 / (damped[0][0] * adjugate[0][0] + damped[0][1] * adjugate[1][0] + damped[0][2] * adjugate[2][0]);
  for (int i = 0; i < 3; ++i) {
    const double row[3] = {gradient[i][0], gradient[i][1], gradient[i][2]};
    for (int j = 0; j < 3; ++j)
      gradient[i][j] = per_determinant * (row[0] * adjugate[0][j] + row[1] * adjugate[1][j] + row[2] * adjugate[2][j]);
  }
}

/// The rotation nearest to I + G, by Newton's iteration, each squaring the error; not of unit length.
WRY_INLINE Quaternion nearest_turn(const Rows& G) {
  constexpr double SMALL = 1e-7; // the velocities have seven digits
  Rows R = G;
  R.row[0].x += 1.0;
  R.row[1].y += 1.0;
  R.row[2].z += 1.0;
  Real error = sqrt(dot(G.row[0], G.row[0]) + dot(G.row[1], G.row[1]) + dot(G.row[2], G.row[2]));
  for (int i = 0; i < 6; ++i, error *= error) {
    const auto goes_on = error > SMALL;
    if (!any(goes_on))
      break;
    const Rows cofactors = {{cross(R.row[1], R.row[2]), cross(R.row[2], R.row[0]), cross(R.row[0], R.row[1])}};
    const Real half = 0.5 / dot(R.row[0], cofactors.row[0]);
    for (int row = 0; row < 3; ++row) {
      const Three& c = cofactors.row[row];
      Three& r = R.row[row];
      r = choose(goes_on, {0.5 * r.x + half * c.x, 0.5 * r.y + half * c.y, 0.5 * r.z + half * c.z}, r);
    }
  }
  return {1.0 + R.row[0].x + R.row[1].y + R.row[2].z,
          {R.row[2].y - R.row[1].z, R.row[0].z - R.row[2].x, R.row[1].x - R.row[0].y}};
}

/// A turn by 4 |v| about v.
WRY_INLINE Quaternion turn_by_four(const Three& v) {
  // By 2 |v|, cos |v| and sin |v| / |v| v, twice; their series are short since the flow turns little between updates.
  const Real x = dot(v, v);
  constexpr double ALL_DIGITS = 0.5; // the first term left out is below 1e-17
  Real cosine = splat(1.0 / 20922789888000.0), sine = splat(1.0 / 355687428096000.0);
  constexpr double COSINE[] = {
      -1.0 / 87178291200.0, 1.0 / 479001600.0, -1.0 / 3628800.0, 1.0 / 40320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5, 1.0};
  constexpr double SINE[] = {-1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0, 1.0 / 362880.0,
                             -1.0 / 5040.0,          1.0 / 120.0,        -1.0 / 6.0,        1.0};
  for (int k = 0; k < 8; ++k) {
    cosine = cosine * x + COSINE[k];
    sine = sine * x + SINE[k];
  }
  if (any(x > ALL_DIGITS)) {
    for (int lane = 0; lane < REALS; ++lane) {
      if (!(x[lane] > ALL_DIGITS))
        continue;
      const double length = __builtin_sqrt(x[lane]);
      cosine[lane] = __builtin_cos(length);
      sine[lane] = __builtin_sin(length) / length;
    }
  }
  const Quaternion half = {cosine, times(sine, v)};
  return half * half;
}

/// exp(S) e made unit, for a unit e.
WRY_INLINE Three stretched(const Rows& S, Three e) {
  // A part of S at a time, so small that the series' first terms have all digits.
  constexpr double SMALL = 0.5, MOST_PARTS = 64.0; // beyond which only the longest axis is left
  constexpr int TERMS = 14;
  const Real size = sqrt(dot(S.row[0], S.row[0]) + dot(S.row[1], S.row[1]) + dot(S.row[2], S.row[2])) / SMALL;
  Real parts = splat(1.0);
  while (any((parts < size) & (parts < MOST_PARTS)))
    parts = (parts < size) & (parts < MOST_PARTS) ? 2.0 * parts : parts;
  const Real share = 1.0 / max(parts, size); // a larger S is made smaller: its axes stay
  for (double part = 0.0; any(parts > part); part += 1.0) {
    Three sum = e, term = e;
    for (int k = 1; k <= TERMS; ++k) {
      term = times(share / double(k), S * term);
      sum = {sum.x + term.x, sum.y + term.y, sum.z + term.z};
    }
    e = choose(parts > part, times(1.0 / sqrt(dot(sum, sum)), sum), e);
  }
  return e;
}

/// The grain's z turns by Jeffery's equation, by the midpoint rule in its own frame, and takes the other axes along:
/// half of the spin, the stretch, the other half.
WRY_INLINE Quaternion turn_by_flow(const Rows& G, double jeffery, const Three& spin, const Quaternion& q) {
  const Quaternion half = turn_by_four(times(splat(0.125), spin));
  const Quaternion h = half * q;
  const Three z = {2.0 * (h.v.x * h.v.z + h.w * h.v.y), 2.0 * (h.v.y * h.v.z - h.w * h.v.x),
                   h.w * h.w - h.v.x * h.v.x - h.v.y * h.v.y + h.v.z * h.v.z};
  const Real l = splat(jeffery), both = 0.5 * l;
  const Real yz = both * (G.row[1].z + G.row[2].y), xz = both * (G.row[0].z + G.row[2].x),
             xy = both * (G.row[0].y + G.row[1].x);
  const Rows S = {{{l * G.row[0].x, xy, xz}, {xy, l * G.row[1].y, yz}, {xz, yz, l * G.row[2].z}}};
  const Three wanted = stretched(S, z);
  const Quaternion shortest = {1.0 + dot(z, wanted), cross(z, wanted)};
  return half * (shortest * h);
}

/// A grain that no node carries: as if it stood in still matter.
WRY_INLINE void put_at_rest(int grain, Sums& sums) {
  for (auto& row : sums.of) {
    for (auto& component : row)
      component[grain] = 0.0F;
  }
  sums.of[Sums::PLAIN][3][grain] = 1.0F;
}

void carry(const FlowNodes& nodes, const GrainMotion& motion, int count, GrainBatch& batch) {
  // Lanes without a grain repeat the last.
  for (int lane = count; lane < GRAINS; ++lane) {
    for (int i = 0; i < 3; ++i) {
      batch.position[i][lane] = batch.position[i][count - 1];
      batch.velocity[i][lane] = batch.velocity[i][count - 1];
    }
    for (auto& component : batch.orientation)
      component[lane] = component[count - 1];
    batch.own[lane] = batch.own[count - 1];
  }
  Stencils stencils;
  Sums sums;
  find_stencils(nodes, motion.dt, batch, stencils);
  // Where every node is denser, so is their mean; a little more, for its rounding.
  const bool is_dense = nodes.least_density >= 1.0001 * motion.thinnest;
  for (int grain = 0; grain < GRAINS; ++grain) {
    if (grain < count)
      sum_flow(nodes.flow, stencils, grain, sums);
    const bool active = grain < count && sums.of[Sums::PLAIN][3][grain] > 1e-6F;
    batch.carried[grain] = active && (is_dense || density_around(nodes.density, stencils, grain) >= motion.thinnest);
    if (!active)
      put_at_rest(grain, sums);
  }
  const double slope = 4.0 / nodes.cell; // the second moment of a full stencil is h^2 / 4
  for (int lane = 0; lane < GRAINS; lane += REALS) {
    const Real activity = widen(sums.of[Sums::PLAIN][3] + lane);
    const Real inverse = 1.0 / activity;
    Real flow[3], centre[3], gradient[3][3];
    for (int c = 0; c < 3; ++c) {
      flow[c] = inverse * widen(sums.of[Sums::PLAIN][c] + lane);
      centre[c] = inverse * widen(sums.of[Sums::X + c][3] + lane);
    }
    for (int c = 0; c < 3; ++c) {
      for (int a = 0; a < 3; ++a)
        gradient[c][a] = slope * (inverse * widen(sums.of[Sums::X + a][c] + lane) - centre[a] * flow[c]);
    }
    const auto is_torn = activity < 0.999;
    if (any(is_torn)) {
      for (int i = 0; i < REALS; ++i) {
        if (!is_torn[i] || !batch.carried[lane + i])
          continue;
        const double middle[3] = {centre[0][i], centre[1][i], centre[2][i]};
        double one[3][3];
        for (int k = 0; k < 9; ++k)
          one[k / 3][k % 3] = gradient[k / 3][k % 3][i];
        shrink(nodes.flow, stencils, lane + i, inverse[i], middle, one);
        for (int k = 0; k < 9; ++k)
          gradient[k / 3][k % 3][i] = one[k / 3][k % 3];
      }
    }
    // What is not carried stays as it is.
    Bits carried;
    for (int i = 0; i < REALS; ++i)
      carried[i] = batch.carried[lane + i] ? -1 : 0;
    const Real own = load(batch.own + lane);
    for (int c = 0; c < 3; ++c) {
      const Real before = load(batch.velocity[c] + lane), place = load(batch.position[c] + lane);
      const Real after = own * before + (1.0 - own) * flow[c];
      store(batch.velocity[c] + lane, carried ? after : before);
      store(batch.position[c] + lane, carried ? place + motion.dt * after : place);
    }
    const Three spin = {0.5 * (gradient[2][1] - gradient[1][2]), 0.5 * (gradient[0][2] - gradient[2][0]),
                        0.5 * (gradient[1][0] - gradient[0][1])};
    store(batch.spin[0] + lane, spin.x);
    store(batch.spin[1] + lane, spin.y);
    store(batch.spin[2] + lane, spin.z);
    Rows G;
    for (int row = 0; row < 3; ++row)
      G.row[row] = {motion.dt * gradient[row][0], motion.dt * gradient[row][1], motion.dt * gradient[row][2]};
    const Quaternion before = {
        load(batch.orientation[0] + lane),
        {load(batch.orientation[1] + lane), load(batch.orientation[2] + lane), load(batch.orientation[3] + lane)}};
    const Quaternion turned = motion.turns_by_flow
                                  ? turn_by_flow(G, motion.jeffery, times(splat(motion.dt), spin), before)
                                  : nearest_turn(G) * before;
    const Real length = sqrt(squared_norm(turned));
    const Real unit = 1.0 / length;
    const auto turns = (length > 1e-9) & (length < 1e9) & carried; // not by half a turn, nor by no number
    const Real after[4] = {turned.w, turned.v.x, turned.v.y, turned.v.z};
    for (int i = 0; i < 4; ++i) {
      const Real old = load(batch.orientation[i] + lane);
      store(batch.orientation[i] + lane, turns ? unit * after[i] : old);
    }
  }
}

template <class Scalar>
void shape_flow(const Scalar* halo, double mass_of_full_cell, double least_share, FlowNodes& nodes) {
  float least = 1e30F;
  for (int node = 0; node < HALO_NODES; ++node) {
    // Through a float, as a snapshot of the grid has it.
    const double share = static_cast<double>(static_cast<float>(halo[node * NODE_VALUES + 3])) / mass_of_full_cell;
    const float active = share >= least_share ? 1.0F : 0.0F;
    nodes.density[node] = static_cast<float>(share);
    least = nodes.density[node] < least ? nodes.density[node] : least;
    float* flow = nodes.flow + node * NODE_VALUES;
    for (int c = 0; c < 3; ++c)
      flow[c] = share >= least_share ? static_cast<float>(halo[node * NODE_VALUES + c]) : 0.0F;
    flow[3] = active;
  }
  for (int i = HALO_NODES * NODE_VALUES; i < HALO_VALUES; ++i)
    nodes.flow[i] = 0.0F;
  nodes.least_density = least;
}

} // namespace

extern const GrainKernels grain_kernels;
constinit const GrainKernels grain_kernels = {carry, shape_flow<float>, shape_flow<double>};

} // namespace wry::mpm::WRY_ISA
