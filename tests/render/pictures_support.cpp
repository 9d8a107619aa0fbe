#include "tests/render/pictures_support.h"

namespace wry::render::testing {

RenderPlan small_plan(const MeshScene& scene) {
  RenderPlan plan;
  plan.size = {192, 108};
  plan.looks = built_in_looks();
  plan.bounds = scene.bounds;
  return plan;
}

} // namespace wry::render::testing
