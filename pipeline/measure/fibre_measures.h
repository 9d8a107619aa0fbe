#pragma once

#include "pipeline/measure/measure.h"

namespace wry::pipeline {

// Measures of particles with axes; NaN without the channel that they need.

/// Mean over the particles of the squared cosine between their grains and the measure's direction: 1 along it, 1/3 when
/// they point anywhere. Without a direction (zero): along each particle's own velocity; those that stand still do not
/// count. Of materials that reorient it is of their second moments, else of their frames' z.
double mean_alignment(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);
/// The greatest eigenvalue of the mean second moment: 1 when all point one way, 1/3 when anywhere.
double second_moment(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);
/// Part of the particles in the largest piece. Particles are of one piece when their cells, of the size of the grid's,
/// share a face, an edge or a corner.
double largest_fragment(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);

} // namespace wry::pipeline
