#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/look.h"
#include "render/view.h"
#include "sim/base/result.h"
#include "sim/state/frame.h"

namespace wry::render {

/// One particle ready to be drawn, relative to the centre of the plan's bounds.
struct DrawGrain {
  std::array<float, 3> centre;              ///< [m]
  std::array<std::array<float, 3>, 3> axes; ///< half extents along the local x, y and z [m]
  std::array<float, 3> velocity;            ///< [m/s]; zero without the channel
  std::uint32_t word;                       ///< what the surface layer stores: see surface_word()
};

/// The particles of one body on one frame.
struct GrainCloud {
  std::vector<DrawGrain> grains;
  float reach = 0.f;       ///< radius of the largest grain [m]
  float mean_width = 0.f;  ///< geometric mean of the two smaller extents [m]
  double mean_volume = 0.; ///< of a grain's box [m^3]
};

/// Look row and payload as the surface layer keeps them: 8 bits look + 1, 24 bits payload. In a look view the payload
/// is a tint of the base colour; in the others 8 bits of wire and 16 bits of heat.
std::uint32_t surface_word(std::uint32_t look, std::uint32_t payload);
/// A colour in [0, 1] that multiplies the base colour, its square root in three times 8 bits.
std::uint32_t tint_payload(const Eigen::Vector3f& colour);
/// Heat in [0, 1], HEAT_ABSENT or HEAT_NOT_A_NUMBER.
std::uint32_t heat_payload(float value);
float heat_of_payload(std::uint32_t payload);

/// How bright the brightest grain of a look is against its base colour: the look table holds the base colour times
/// this, so that tints stay within [0, 1].
float brightest_variation(const Look& look);

/// Orients and sizes every particle of a body. `look_row`: its row in the look table. Errors: bad_input for channels of
/// the wrong shape, positions or orientations that are not finite, or a heat channel that does not fit.
Result<GrainCloud> make_grain_cloud(const SceneBody& body, const FrameBody& on_frame, int frame_number,
                                    const Vec3& origin, const View& view, const Look& look, std::uint32_t look_row);

} // namespace wry::render
