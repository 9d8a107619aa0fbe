#include "render/look.h"

namespace wry::render {
namespace {

Look look(Eigen::Vector3f base_colour, float roughness) {
  Look made;
  made.base_colour = base_colour;
  made.roughness = roughness;
  return made;
}

Look scattering(Look made, float wrap, Eigen::Vector3f scatter) {
  made.wrap = wrap;
  made.scatter = scatter;
  return made;
}

Look coated(Look made, float clearcoat, float clearcoat_roughness) {
  made.clearcoat = clearcoat;
  made.clearcoat_roughness = clearcoat_roughness;
  return made;
}

std::map<std::string, Look> make_built_in_looks() {
  std::map<std::string, Look> looks;
  looks["clay"] = look({.42f, .40f, .38f}, .62f);
  looks["rubber"] = scattering(look({.52f, .16f, .10f}, .42f), .35f, {1.f, .30f, .15f});
  looks["skin"] = scattering(look({.66f, .41f, .32f}, .46f), .45f, {1.f, .32f, .18f});
  looks["straw"] = scattering(look({.60f, .44f, .18f}, .55f), .15f, {1.f, .8f, .4f});
  looks["wood"] = look({.36f, .20f, .10f}, .5f);
  looks["card"] = scattering(look({.70f, .66f, .58f}, .8f), .1f, {1.f, .9f, .7f});
  looks["metal"] = look({.60f, .58f, .56f}, .3f);
  looks["metal"].metallic = 1.f;
  looks["ceramic"] = coated(look({.68f, .68f, .66f}, .45f), 1.f, .1f);
  looks["paint"] = coated(look({.42f, .05f, .04f}, .5f), 1.f, .12f);
  return looks;
}

} // namespace

const std::map<std::string, Look>& built_in_looks() {
  static const std::map<std::string, Look> looks = make_built_in_looks();
  return looks;
}

} // namespace wry::render
