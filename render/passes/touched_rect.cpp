#include "render/passes/touched_rect.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace wry::render {
namespace {

/// Grows a box in ndc by points; remembers when one lies behind the eye, where no box holds.
class PictureBox {
public:
  explicit PictureBox(const Camera& camera)
      : m_camera(camera) {}

  void include(const Vec3& point) {
    const Vec3 p = m_camera.axes.transpose() * (point - m_camera.eye);
    if (-p.z() < m_camera.near_distance) {
      m_everywhere = true;
      return;
    }
    const Eigen::Vector2d ndc(p.x() / (-p.z() * m_camera.tan_half_width), p.y() / (-p.z() * m_camera.tan_half_height));
    m_low = m_low.cwiseMin(ndc);
    m_high = m_high.cwiseMax(ndc);
  }

  PixelRect pixels(const ImageSize& size) const {
    if (m_everywhere)
      return {0, 0, size.width, size.height};
    constexpr int MARGIN = 4;
    const auto pixel = [](double ndc, int side) {
      return static_cast<int>(std::floor(std::clamp(0.5 * ndc + 0.5, 0.0, 1.0) * side));
    };
    const int x0 = std::max(pixel(m_low.x(), size.width) - MARGIN, 0);
    const int y0 = std::max(pixel(m_low.y(), size.height) - MARGIN, 0);
    const int x1 = std::min(pixel(m_high.x(), size.width) + MARGIN, size.width);
    const int y1 = std::min(pixel(m_high.y(), size.height) + MARGIN, size.height);
    return {x0, y0, std::max(x1 - x0, 0), std::max(y1 - y0, 0)};
  }

private:
  const Camera& m_camera;
  Eigen::Vector2d m_low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d m_high = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity());
  bool m_everywhere = false;
};

} // namespace

PixelRect touched_rect(const RenderPlan& plan, const Camera& camera, const LightState& lights, double ground_height,
                       double reach) {
  PictureBox box(camera);
  const Mat3 world = world_frame(plan.up);
  Vec3 to_light = plan.up;
  if (lights.shadowed >= 0)
    to_light = lights.directions.col(lights.shadowed).head<3>().cast<double>();
  const double climb = to_light.dot(plan.up);
  const auto include_with_floor = [&](const Vec3& point) {
    box.include(point);
    if (plan.ground.kind == Ground::Kind::none)
      return;
    const double height = plan.up.dot(point) - ground_height;
    for (const Vec3& side : {Vec3(world.col(0)), Vec3(-world.col(0)), Vec3(world.col(2)), Vec3(-world.col(2))}) {
      box.include(point - height * plan.up + reach * side);
      // A wider penumbra the farther the shadow falls; a light on the horizon casts beyond any box.
      const double spread = lights.shadow_spread * std::abs(height) / std::max(climb, 0.05);
      box.include(point - std::max(height, 0.0) / std::max(climb, 0.02) * to_light + (spread + 0.1 * reach) * side);
    }
  };
  for (Eigen::Index i = 0; i < plan.bounds.outline().rows(); ++i)
    include_with_floor(plan.bounds.outline().row(i).transpose() - plan.bounds.centre());
  for (int corner = 0; corner < 8; ++corner)
    box.include(plan.bounds.box().corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)) - plan.bounds.centre());
  return box.pixels(plan.size);
}

} // namespace wry::render
