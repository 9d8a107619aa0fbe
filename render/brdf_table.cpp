#include "render/brdf_table.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace wry::render {
namespace {

constexpr int SAMPLES = 384;

/// Bits of i mirrored about the point: with i / n a Hammersley set.
double mirrored(std::uint32_t i) {
  std::uint32_t bits = 0;
  for (int b = 0; b < 32; ++b)
    bits |= ((i >> b) & 1U) << (31 - b);
  return bits * (1.0 / 4294967296.0);
}

/// Smith's shadowing term of one direction for GGX (Heitz 2014), as lambda.
double smith_lambda(double cosine, double alpha) {
  const double square = cosine * cosine;
  return 0.5 * (std::sqrt(1.0 + alpha * alpha * (1.0 - square) / square) - 1.0);
}

/// Mean over half vectors drawn from the visible normals (Heitz 2018): the weight is Fresnel times G2 / G1.
std::array<float, 2> entry(double cosine_view, double roughness) {
  const double alpha = std::max(roughness * roughness, 1e-4);
  const double sine_view = std::sqrt(1.0 - cosine_view * cosine_view);
  const double lambda_view = smith_lambda(cosine_view, alpha);
  double scale = 0.0;
  double bias = 0.0;
  for (std::uint32_t i = 0; i < SAMPLES; ++i) {
    const double u1 = (i + 0.5) / SAMPLES;
    const double u2 = mirrored(i);
    // The view direction lies in the xz plane; stretch it, sample the projected disc, project back, unstretch.
    const double length = std::hypot(alpha * sine_view, cosine_view);
    const double vx = alpha * sine_view / length;
    const double vz = cosine_view / length;
    const double radius = std::sqrt(u1);
    const double angle = 2.0 * std::numbers::pi * u2;
    const double t1 = radius * std::cos(angle);
    const double blend = 0.5 * (1.0 + vz);
    const double t2 = (1.0 - blend) * std::sqrt(1.0 - t1 * t1) + blend * radius * std::sin(angle);
    const double t3 = std::sqrt(std::max(0.0, 1.0 - t1 * t1 - t2 * t2));
    // Frame about the stretched view: first axis y, second (-vz, 0, vx), third the view itself.
    const double nx = -t2 * vz + t3 * vx;
    const double nz = t2 * vx + t3 * vz;
    const double ny = t1;
    const double scale_back = 1.0 / std::sqrt(alpha * alpha * (nx * nx + ny * ny) + nz * nz);
    const double hx = alpha * nx * scale_back;
    const double hz = std::max(nz, 0.0) * scale_back;
    const double view_half = std::max(sine_view * hx + cosine_view * hz, 0.0);
    const double cosine_light = 2.0 * view_half * hz - cosine_view;
    if (cosine_light <= 0.0)
      continue;
    const double lambda_light = smith_lambda(cosine_light, alpha);
    const double weight = (1.0 + lambda_view) / (1.0 + lambda_view + lambda_light);
    const double fresnel = std::pow(1.0 - view_half, 5.0);
    scale += weight * (1.0 - fresnel);
    bias += weight * fresnel;
  }
  return {static_cast<float>(scale / SAMPLES), static_cast<float>(bias / SAMPLES)};
}

} // namespace

std::vector<std::array<float, 2>> make_brdf_table() {
  std::vector<std::array<float, 2>> table;
  table.reserve(static_cast<std::size_t>(BRDF_TABLE_SIZE) * BRDF_TABLE_SIZE);
  for (int row = 0; row < BRDF_TABLE_SIZE; ++row) {
    for (int column = 0; column < BRDF_TABLE_SIZE; ++column) {
      const double cosine = std::clamp(static_cast<double>(column) / (BRDF_TABLE_SIZE - 1), 1e-3, 1.0);
      table.push_back(entry(cosine, static_cast<double>(row) / (BRDF_TABLE_SIZE - 1)));
    }
  }
  return table;
}

} // namespace wry::render
