#include "tests/render/pictures_support.h"

namespace wry::render::testing {

RenderPlan small_plan(const MeshScene& scene) {
  RenderPlan plan;
  plan.size = {192, 108};
  plan.looks = built_in_looks();
  plan.bounds = scene.bounds;
  return plan;
}

RenderPlan white_furnace(const MeshScene& ball, const Look& look) {
  RenderPlan plan = small_plan(ball);
  plan.samples = 1;
  plan.ground.kind = Ground::Kind::none;
  plan.default_look = look;
  plan.rig = Rig();
  plan.rig.occlusion = Rig::Occlusion::none;
  plan.rig.sky = Eigen::Vector3f::Ones();
  plan.rig.bounce = Rig::Bounce::given;
  plan.rig.given_bounce = Eigen::Vector3f::Ones();
  plan.rig.given_backdrop = Eigen::Vector3f::Ones();
  return plan;
}

Look white(float roughness, float metallic) {
  Look look;
  look.base_colour = Eigen::Vector3f::Ones();
  look.roughness = roughness;
  look.metallic = metallic;
  return look;
}

} // namespace wry::render::testing
