#pragma once

#include <limits>
#include <string>
#include <vector>

#include "pipeline/study/study.h"

namespace wry::pipeline {

/// One quantity that is compared: a measure over the frames, or what follows from the frames themselves.
struct ErrorValue {
  std::string quantity;                                    ///< "tip", "position", "energy"
  double error = std::numeric_limits<double>::quiet_NaN(); ///< relative; NaN: not to be had
};

/// Root mean square over common frames of the difference of a measure, over the largest value of the reference.
double measure_error(const StudyRow& row, const StudyRow& reference, const std::string& measure);

/// Difference of a measure's last value from its exact one, relative.
double exact_error(const StudyRow& row, const std::string& measure, double exact);

/// What two runs differ by, whatever they measure; always the same quantities in the same order:
/// position and rotation (microrotations, or orientations of grains) of all nodes or particles at the last frame, root
/// mean square, positions over the size of the scene, when there are as many of them;
/// energy: the sum of all energies over the frames, over the largest change of a part;
/// volume: of the tets at the last frame;
/// density: of particles at the last frame, as mass that lies elsewhere, from 0 to 1, on a grid of a sixteenth of the
/// reference's extents.
std::vector<ErrorValue> errors_of_frames(const StudyRow& row, const StudyRow& reference);

/// Root mean square difference of the pictures, in linear light from 0 to 1, over all views and frames asked for.
double picture_error(const StudyRow& row, const StudyRow& reference);

} // namespace wry::pipeline
