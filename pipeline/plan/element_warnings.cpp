#include "pipeline/plan/element_warnings.h"

#include <algorithm>

#include <fmt/format.h>

namespace wry::pipeline {

namespace {

// Where the experiments of docs/elements.md begin to show what is warned of.
constexpr double LARGE_COUPLE_RATIO = 3.0;
constexpr double LARGE_POISSON_RATIO = 0.44;
/// Bending stiffness that linear tets add per (mu_c / mu) / n^2, n cells across (spec section 11).
constexpr double COUPLE_STIFFENING = 1.5;

} // namespace

std::vector<std::string> element_warnings(const fem::FemBody& body, const BodyReport& report) {
  const fem::FemMaterial& material = body.material;
  std::vector<std::string> warnings;
  const double across = report.mean_edge > 0.0 ? std::max(1.0, report.size.minCoeff() / report.mean_edge) : 1.0;
  if (body.element == fem::ElementKind::tet4 && fem::is_micropolar(material.model) &&
      material.couple_modulus_ratio > LARGE_COUPLE_RATIO)
    warnings.push_back(fmt::format(
        "body {}: couple_modulus_ratio = {:.4g} makes linear tets bend too stiffly: about {:.2g} times their own "
        "stiffness more at {:.2g} cells across; take element = \"tet10\", a ratio near 1, or finer cells",
        body.name, material.couple_modulus_ratio, COUPLE_STIFFENING * material.couple_modulus_ratio / (across * across),
        across));
  if (material.model == fem::ElasticModel::micropolar_det && material.poisson_ratio > LARGE_POISSON_RATIO)
    warnings.push_back(
        fmt::format("body {}: linear tets with the volume term of det F are too stiff at poisson_ratio = "
                    "{:.3g} (measured on a coarse bar: 12 % at .45, 20 to 24 % at .49, where it grows "
                    "with the stretch); take finer cells, or a ratio up to {:.2g}",
                    body.name, material.poisson_ratio, LARGE_POISSON_RATIO));
  if (material.model == fem::ElasticModel::micropolar_neo_hookean)
    warnings.push_back(fmt::format("body {}: microrotations of micropolar-neo-hookean let go of the matter where a "
                                   "twist would invert linear elements (measured: 1.3 turns over "
                                   "two widths)",
                                   body.name));
  if (body.element == fem::ElementKind::plate3)
    warnings.push_back(fmt::format("body {}: linear triangles bend too stiffly where the plate is thinner than their "
                                   "edges ({:.3g} m thick); take element = \"tri6\"",
                                   body.name, body.thickness));
  if (body.element == fem::ElementKind::tet4_one_point)
    warnings.push_back(fmt::format("body {}: one quadrature point leaves microrotations that cost nothing and drift "
                                   "(hourglass modes); quadrature = \"full\" has none",
                                   body.name));
  return warnings;
}

} // namespace wry::pipeline
