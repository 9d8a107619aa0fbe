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

Look varying(Look made, float colour, float size) {
  made.colour_variation = colour;
  made.size_variation = size;
  return made;
}

std::map<std::string, Look> make_built_in_looks() {
  std::map<std::string, Look> looks;
  looks["clay"] = look({.42f, .40f, .38f}, .62f);
  looks["rubber"] = scattering(look({.52f, .16f, .10f}, .42f), .35f, {1.f, .30f, .15f});
  looks["skin"] = scattering(look({.66f, .41f, .32f}, .46f), .45f, {1.f, .32f, .18f});
  looks["straw"] = varying(scattering(look({.62f, .43f, .15f}, .5f), .2f, {1.f, .8f, .4f}), .32f, .2f);
  looks["wood"] = varying(look({.36f, .20f, .10f}, .5f), .25f, .05f);
  looks["card"] = varying(scattering(look({.70f, .66f, .58f}, .8f), .1f, {1.f, .9f, .7f}), .12f, 0.f);
  looks["metal"] = look({.60f, .58f, .56f}, .3f);
  looks["metal"].metallic = 1.f;
  looks["ceramic"] = coated(look({.68f, .68f, .66f}, .45f), 1.f, .1f);
  looks["paint"] = coated(look({.42f, .05f, .04f}, .5f), 1.f, .12f);
  looks["glass"] = look({.93f, .97f, .96f}, .06f);
  looks["glass"].transparency = 1.f;
  looks["sand"] = varying(look({.56f, .42f, .26f}, .85f), .25f, .25f);
  looks["snow"] = varying(scattering(look({.84f, .87f, .90f}, .75f), .4f, {.8f, .9f, 1.f}), .04f, .2f);
  looks["brick"] = varying(look({.42f, .15f, .09f}, .8f), .22f, .04f);
  return looks;
}

} // namespace

const std::map<std::string, Look>& built_in_looks() {
  static const std::map<std::string, Look> looks = make_built_in_looks();
  return looks;
}

} // namespace wry::render
