#pragma once

#include <span>

#include "sim/base/types.h"

/// Rotations as unit quaternions (w, x, y, z) with Hamilton's product. R(q) maps material to world, its columns are the
/// directors. Signs are never canonicalised: a quaternion field is differentiated, so q and -q are not exchangeable
/// there.
namespace wry {

Vec4 identity_quaternion();

/// Hamilton product a b: first b, then a.
Vec4 quaternion_product(const Vec4& a, const Vec4& b);
Vec4 quaternion_conjugate(const Vec4& q);

/// R(q) = (w^2 - |u|^2) I + 2 u u^T + 2 w cross(u); of |q| != 1: times |q|^2.
Mat3 rotation_matrix(const Vec4& q);

/// A unit quaternion of a rotation matrix (orthonormal, det +1). Its sign is arbitrary.
Vec4 quaternion_of(const Mat3& rotation);

/// cross(v): the matrix of w -> v x w.
Mat3 cross_matrix(const Vec3& v);

/// The incremental update of the micropolar paper (eq 26), q0 + (0, a) q0 / 2, made unit: Cayley's map, a turn by
/// 2 atan(|a| / 2) about the world axis a = dt omega. Its product with q0 is positive, so signs stay aligned.
Vec4 cayley_update(const Vec4& q0, const Vec3& a);

/// The increment a that turns q0 into q (up to the sign of q): 2 vec(d) / Re(d), d = q conj(q0). Infinite for half
/// turns.
Vec3 cayley_increment(const Vec4& q0, const Vec4& q);

/// A turn by |v| radians about v.
Vec4 quaternion_exponential(const Vec3& v);
/// The matrix of that turn (Rodrigues' formula).
Mat3 rodrigues(const Vec3& v);

/// The rotation vector of a unit quaternion, of length [0, pi]; the same for q and -q.
Vec3 rotation_vector(const Vec4& q);

/// Angle between two rotations in [0, pi], the same for q and -q; exact for small ones.
double rotation_distance(const Vec4& a, const Vec4& b);

/// Weighted mean of rotations on the sphere of quaternions (Buss and Fillmore, algorithm A1). Signs are aligned to the
/// first one; the result has its sign. Weights sum to one and rotations lie within a half-sphere.
Vec4 spherical_average(std::span<const Vec4> rotations, std::span<const double> weights);

/// The rotation nearest to F in Frobenius norm, det +1 whatever the sign of det F.
Mat3 polar_rotation(const Mat3& F);

} // namespace wry
