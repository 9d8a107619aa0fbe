#pragma once

namespace wry::contact {

/// Queries of a batch, whatever the instruction set.
inline constexpr int CCD_LANES = 8;

/// Pairs whose four points move linearly: [point][axis][lane]. Point-triangle: the point, then the triangle.
/// Edge-edge: the ends of one, then of the other.
struct alignas(64) CcdBatch {
  double start[4][3][CCD_LANES];
  double end[4][3][CCD_LANES];
  double separation[CCD_LANES]; ///< the distance that must be kept [m], not negative
  double ceiling;               ///< times beyond this one are of no interest
};

/// Writes per lane a time in [0, 1] up to which the pair is proven to stay further apart than its separation; 1 when it
/// does all the way, 0 when nothing can be proven.
using CcdFunction = void (*)(const CcdBatch& batch, double* safe);

/// For one instruction set. The precise ones compute in 113 bits: slow, for pairs at the edge of what doubles resolve.
struct CcdTable {
  CcdFunction point_triangle, edge_edge;
  CcdFunction point_triangle_precise, edge_edge_precise;
};

namespace sse4 {
CcdTable ccd_table();
}
namespace avx2 {
CcdTable ccd_table();
}
namespace avx512 {
CcdTable ccd_table();
}

} // namespace wry::contact
