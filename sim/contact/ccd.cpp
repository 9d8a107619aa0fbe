#include "sim/contact/ccd.h"

#include <algorithm>

namespace wry::contact {

namespace {

/// Doubles end in safe times this small when the pair is closer than they resolve.
constexpr double DOUBTFUL = 1e-7;

void copy_lane(const CcdBatch& from, int lane, CcdBatch& to, int target) {
  for (int k = 0; k < 4; ++k) {
    for (int i = 0; i < 3; ++i) {
      to.start[k][i][target] = from.start[k][i][lane];
      to.end[k][i][target] = from.end[k][i][lane];
    }
  }
  to.separation[target] = from.separation[lane];
}

} // namespace

CcdTable select_ccd(Isa isa) {
  switch (isa) {
  case Isa::avx512:
    return avx512::ccd_table();
  case Isa::avx2:
    return avx2::ccd_table();
  case Isa::sse4:
    break;
  }
  return sse4::ccd_table();
}

void find_safe_times(const CcdTable& table, PairKind kind, CcdBatch& batch, int lanes, double* safe) {
  for (int lane = lanes; lane < CCD_LANES; ++lane)
    copy_lane(batch, 0, batch, lane);
  const bool edges = kind == PairKind::edge_edge;
  (edges ? table.edge_edge : table.point_triangle)(batch, safe);
  for (int lane = 0; lane < lanes; ++lane) {
    if (safe[lane] >= DOUBTFUL)
      continue;
    CcdBatch alone;
    double answers[CCD_LANES];
    for (int i = 0; i < CCD_LANES; ++i)
      copy_lane(batch, lane, alone, i);
    alone.ceiling = batch.ceiling;
    (edges ? table.edge_edge_precise : table.point_triangle_precise)(alone, answers);
    safe[lane] = std::max(safe[lane], answers[0]);
  }
}

double safe_time(PairKind kind, const Eigen::Matrix<double, 4, 3>& start, const Eigen::Matrix<double, 4, 3>& end,
                 double separation, Isa isa) {
  CcdBatch batch;
  for (int k = 0; k < 4; ++k) {
    for (int i = 0; i < 3; ++i) {
      batch.start[k][i][0] = start(k, i);
      batch.end[k][i][0] = end(k, i);
    }
  }
  batch.separation[0] = separation;
  batch.ceiling = 1.0;
  double safe[CCD_LANES];
  find_safe_times(select_ccd(isa), kind, batch, 1, safe);
  return safe[0];
}

} // namespace wry::contact
