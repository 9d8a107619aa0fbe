#include "render/signs.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

namespace wry::render {
namespace {

using Colour = Eigen::Vector3f;

const std::array<Colour, 3> AXIS_COLOURS = {Colour(.80f, .05f, .04f), Colour(.06f, .55f, .08f),
                                            Colour(.05f, .16f, .85f)};
const Colour FIBRE_COLOUR(.85f, .45f, .05f);
const Colour CONTACT_COLOUR(.90f, .06f, .30f);
constexpr double SLENDERNESS = 0.11;

/// A rod of `length` that begins at `from` and runs along `along`.
DrawGrain rod(const Vec3& from, const Vec3& along, double length, const Colour& colour, std::uint32_t look_row) {
  const Vec3 z = along.normalized();
  const Vec3 x = z.unitOrthogonal();
  const Vec3 y = z.cross(x);
  const Vec3 centre = from + 0.5 * length * z;
  const auto floats = [](const Vec3& v) {
    return std::array<float, 3>{static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
  };
  const double half_width = 0.5 * SLENDERNESS * length;
  return {floats(centre),
          {floats(half_width * x), floats(half_width * y), floats(0.5 * length * z)},
          {0, 0, 0},
          surface_word(look_row, tint_payload(colour))};
}

/// Rows that carry marks: those of vertices that are drawn, thinned evenly.
std::vector<std::size_t> marked_rows(const SceneBody& body, std::size_t count) {
  std::vector<std::size_t> rows;
  if (body.kind == BodyKind::surface && body.triangles.rows() > 0) {
    std::vector<bool> used(count, false);
    for (Eigen::Index i = 0; i < body.triangles.size(); ++i)
      used[static_cast<std::size_t>(body.triangles.data()[i])] = true;
    for (std::size_t i = 0; i < count; ++i) {
      if (used[i])
        rows.push_back(i);
    }
  } else {
    for (std::size_t i = 0; i < count; ++i)
      rows.push_back(i);
  }
  const std::size_t stride = (rows.size() + MARKS_MAX - 1) / MARKS_MAX;
  std::vector<std::size_t> thinned;
  for (std::size_t i = 0; i < rows.size(); i += std::max<std::size_t>(stride, 1))
    thinned.push_back(rows[i]);
  return thinned;
}

} // namespace

const Channel* sign_channel(const FrameBody& on_frame, Signs signs) {
  switch (signs) {
  case Signs::directors: {
    const Channel* rotation = find_channel(on_frame, "microrotation");
    return rotation != nullptr ? rotation : find_channel(on_frame, "orientation");
  }
  case Signs::fibres:
    return find_channel(on_frame, "fibre");
  case Signs::contacts:
    return find_channel(on_frame, "contact_force");
  default:
    return nullptr;
  }
}

Status append_signs(const SceneBody& body, const FrameBody& on_frame, const Points& positions, Signs signs, double size,
                    const Vec3& origin, std::uint32_t look_row, DrawCloud& marks) {
  const Channel* channel = sign_channel(on_frame, signs);
  if (channel == nullptr)
    return {};
  const int components = signs == Signs::directors ? 4 : 3;
  const auto count = static_cast<std::size_t>(positions.rows());
  if (channel->components != components || channel->values.size() != count * static_cast<std::size_t>(components))
    return make_error(ErrorCode::bad_input, "body {}: channel {} has {} values; {} rows of {} were expected", body.name,
                      channel->name, channel->values.size(), count, components);
  for (const std::size_t row : marked_rows(body, count)) {
    const double* value = channel->values.data() + row * static_cast<std::size_t>(components);
    const Vec3 from = positions.row(static_cast<Eigen::Index>(row)).transpose() - origin;
    if (signs == Signs::directors) {
      const Eigen::Quaterniond q(value[0], value[1], value[2], value[3]);
      if (!(q.norm() > 0.0) || !q.coeffs().allFinite())
        continue;
      const Mat3 axes = q.normalized().toRotationMatrix();
      for (int a = 0; a < 3; ++a)
        marks.grains.push_back(rod(from, axes.col(a), size, AXIS_COLOURS[static_cast<std::size_t>(a)], look_row));
      continue;
    }
    const Vec3 along(value[0], value[1], value[2]);
    if (!(along.norm() > 0.0) || !along.allFinite())
      continue;
    const bool centred = signs == Signs::fibres;
    marks.grains.push_back(rod(centred ? Vec3(from - 0.5 * size * along.normalized()) : from, along, size,
                               centred ? FIBRE_COLOUR : CONTACT_COLOUR, look_row));
  }
  return {};
}

} // namespace wry::render
