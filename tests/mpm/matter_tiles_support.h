#pragma once

#include <vector>

#include "sim/base/aligned.h"
#include "sim/mpm/matter/make_matter.h"
#include "tests/runnable_isas.h"

/// Matter kernels on particles that a test writes one by one.
namespace wry::mpm::test {

/// A particle in doubles.
struct Sample {
  Mat3 F = Mat3::Identity(); ///< F_e before the step
  Mat3 L = Mat3::Zero();     ///< velocity gradient, and APIC's C
  Vec4 frame = Vec4(1, 0, 0, 0);
  PlasticHistory history;
  Mat3 second_moment = Mat3::Identity() / 3.0;
  double stiffness = 1.0, strength = 1.0;
  Mat3 tau = Mat3::Zero();
  double energy = 0.0;
};

/// Runs the kernel of the material over the samples in place. The last tile is filled with copies of the last sample.
template <class T>
ConstitutiveReport run_kernel(const Material& material, Isa isa, double dt, std::vector<Sample>& samples);

using wry::test::runnable_isas;

} // namespace wry::mpm::test
