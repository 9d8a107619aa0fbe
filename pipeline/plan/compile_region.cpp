#include "pipeline/plan/compile_region.h"

namespace wry::pipeline {

namespace {

struct Translate {
  scene::Region operator()(const shots::BoxRegion& box) const { return scene::BoxRegion{*box.min, *box.max}; }
  scene::Region operator()(const shots::SphereRegion& sphere) const {
    return scene::SphereRegion{*sphere.centre, *sphere.radius};
  }
  scene::Region operator()(const shots::CylinderRegion& cylinder) const {
    return scene::CylinderRegion{*cylinder.from, *cylinder.to, *cylinder.radius};
  }
  scene::Region operator()(const shots::ExpressionRegion& region) const {
    return scene::ExpressionRegion{region.expression->text};
  }
  scene::Region operator()(const shots::AttributeRegion& region) const {
    return scene::AttributeRegion{*region.attribute};
  }
};

} // namespace

scene::Region compile_region(const shots::Region& region) {
  return std::visit(Translate{}, region);
}

} // namespace wry::pipeline
