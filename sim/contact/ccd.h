#pragma once

#include "sim/base/isa.h"
#include "sim/base/types.h"
#include "sim/contact/ccd_batch.h"

namespace wry::contact {

/// What a pair of primitives is.
enum class PairKind { point_triangle, edge_edge };

/// The functions of an instruction set.
CcdTable select_ccd(Isa isa);

/// Conservative continuous collision detection of one batch: per lane a time in [0, 1] up to which the pair, whose
/// points move linearly, is proven to stay further apart than its separation. It is below the first time of touch, in
/// exact arithmetic on the doubles given, and above zero unless the pair touches at the start. Lanes that doubles
/// cannot decide are asked again in 113 bits.
void find_safe_times(const CcdTable& table, PairKind kind, CcdBatch& batch, int lanes, double* safe);

/// One pair: 4 points at the start and at the end, a row each.
double safe_time(PairKind kind, const Eigen::Matrix<double, 4, 3>& start, const Eigen::Matrix<double, 4, 3>& end,
                 double separation, Isa isa);

} // namespace wry::contact
