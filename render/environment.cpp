#include "render/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace wry::render {
namespace {

using Vector = Eigen::Vector3f;
using Colour = Eigen::Vector3f;
constexpr float PI = std::numbers::pi_v<float>;

/// A light from each pixel of a small equirectangular picture.
struct Grid {
  int width = 0;
  int height = 0;
  std::vector<Colour> pixels;

  Colour& at(int x, int y) { return pixels[static_cast<std::size_t>(y * width + x)]; }
  const Colour& at(int x, int y) const { return pixels[static_cast<std::size_t>(y * width + x)]; }
  Vector direction(int x, int y) const {
    const float polar = PI * (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
    const float azimuth = 2.f * PI * ((static_cast<float>(x) + 0.5f) / static_cast<float>(width) - 0.5f);
    return {std::sin(polar) * std::sin(azimuth), std::cos(polar), std::sin(polar) * std::cos(azimuth)};
  }
  /// Solid angle of a pixel of this row.
  float angle(int y) const {
    const float polar = PI * (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
    return 2.f * PI * PI / static_cast<float>(width * height) * std::sin(polar);
  }
};

/// Mean of the picture over each cell of a grid. A picture smaller than the grid is repeated.
Grid reduced(const LinearImage& image, int width, int height) {
  Grid grid{width, height, std::vector<Colour>(static_cast<std::size_t>(width * height), Colour::Zero())};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int x0 = x * image.width / width;
      const int y0 = y * image.height / height;
      const int x1 = std::max((x + 1) * image.width / width, x0 + 1);
      const int y1 = std::max((y + 1) * image.height / height, y0 + 1);
      Colour sum = Colour::Zero();
      for (int v = y0; v < y1; ++v) {
        for (int u = x0; u < x1; ++u)
          sum += Colour(image.at(u, v)[0], image.at(u, v)[1], image.at(u, v)[2]);
      }
      grid.at(x, y) = sum / static_cast<float>((x1 - x0) * (y1 - y0));
    }
  }
  return grid;
}

LinearImage as_image(const Grid& grid) {
  LinearImage image{grid.width, grid.height, {}};
  for (const Colour& colour : grid.pixels)
    image.pixels.insert(image.pixels.end(), {colour[0], colour[1], colour[2], 1.f});
  return image;
}

std::array<float, 9> harmonics(const Vector& d) {
  return {0.282095f,
          0.488603f * d.y(),
          0.488603f * d.z(),
          0.488603f * d.x(),
          1.092548f * d.x() * d.y(),
          1.092548f * d.y() * d.z(),
          0.315392f * (3.f * d.z() * d.z() - 1.f),
          1.092548f * d.x() * d.z(),
          0.546274f * (d.x() * d.x() - d.y() * d.y())};
}

/// Mean of the surroundings over the lobe that GGX of this roughness mirrors, seen straight on.
Colour lobe_mean(const Grid& grid, const Vector& towards, float roughness) {
  const float alpha = std::max(roughness * roughness, 0.02f);
  const float a2 = alpha * alpha;
  Colour sum = Colour::Zero();
  float weights = 0.f;
  for (int y = 0; y < grid.height; ++y) {
    const float angle = grid.angle(y);
    for (int x = 0; x < grid.width; ++x) {
      const Vector d = grid.direction(x, y);
      const float cosine = d.dot(towards);
      if (cosine <= 0.f)
        continue;
      const float half_square = 0.5f * (1.f + cosine); // square of the cosine to the half vector
      const float denominator = half_square * (a2 - 1.f) + 1.f;
      const float weight = angle * cosine * a2 / (denominator * denominator);
      sum += weight * grid.at(x, y);
      weights += weight;
    }
  }
  return weights > 0.f ? Colour(sum / weights) : Colour(Colour::Zero());
}

Colour bilinear(const Grid& grid, float x, float y) {
  const float fx = x - 0.5f;
  const float fy = std::clamp(y - 0.5f, 0.f, static_cast<float>(grid.height - 1));
  const int x0 = static_cast<int>(std::floor(fx));
  const int y0 = static_cast<int>(fy);
  const int y1 = std::min(y0 + 1, grid.height - 1);
  const float u = fx - static_cast<float>(x0);
  const float v = fy - static_cast<float>(y0);
  const auto column = [&](int i) { return ((i % grid.width) + grid.width) % grid.width; };
  return (1.f - v) * ((1.f - u) * grid.at(column(x0), y0) + u * grid.at(column(x0 + 1), y0)) +
         v * ((1.f - u) * grid.at(column(x0), y1) + u * grid.at(column(x0 + 1), y1));
}

float luminance(const Colour& c) {
  return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
}

/// Takes the brightest spot out of the picture if it lights the scene like a sun.
std::optional<Light> take_sun(Grid& grid) {
  constexpr float WITHIN = 0.9925f; // cosine of 7 degrees
  float brightest = 0.f;
  float mean = 0.f;
  Vector peak = Vector::UnitY();
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const float l = luminance(grid.at(x, y));
      mean += l * grid.angle(y) / (4.f * PI);
      if (l > brightest) {
        brightest = l;
        peak = grid.direction(x, y);
      }
    }
  }
  Colour light = Colour::Zero();
  Vector centre = Vector::Zero();
  Grid without = grid;
  const float limit = 4.f * mean;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const float l = luminance(grid.at(x, y));
      if (grid.direction(x, y).dot(peak) < WITHIN || l <= limit)
        continue;
      const Colour taken = grid.at(x, y) * (1.f - limit / l);
      light += taken * grid.angle(y);
      centre += luminance(taken) * grid.angle(y) * grid.direction(x, y);
      without.at(x, y) -= taken;
    }
  }
  // Less than a sixth of the whole is no sun: it stays in the picture and casts no shadow.
  if (!(luminance(light) > 4.f * PI * mean / 6.f) || peak.y() < 0.05f)
    return std::nullopt;
  grid = without;
  const Vector towards = centre.normalized();
  Light sun;
  sun.azimuth_degrees = static_cast<double>(std::atan2(towards.x(), towards.z()) * 180.f / PI);
  sun.elevation_degrees = static_cast<double>(std::asin(std::clamp(towards.y(), -1.f, 1.f)) * 180.f / PI);
  sun.radiance = light / PI;
  sun.angular_radius_degrees = 1.5;
  sun.shadow = Light::Shadow::mapped;
  return sun;
}

Rig rig_of(const Grid& sky, std::vector<Light> lights) {
  Rig rig;
  rig.turning = Rig::Turning::with_world;
  rig.lights = std::move(lights);
  auto image = std::make_shared<LinearImage>(as_image(sky));
  const EnvironmentMaps maps = make_environment_maps(*image, Colour::Zero());
  rig.sky = matt_light(maps, Vector::UnitY());
  rig.surroundings = std::move(image);
  return rig;
}

} // namespace

EnvironmentMaps make_environment_maps(const LinearImage& surroundings, const std::optional<Eigen::Vector3f>& below) {
  Grid sharp = reduced(surroundings, MIRROR_WIDTH, MIRROR_HEIGHT);
  if (below) {
    for (int y = MIRROR_HEIGHT / 2; y < MIRROR_HEIGHT; ++y)
      std::fill_n(sharp.pixels.begin() + y * MIRROR_WIDTH, MIRROR_WIDTH, *below);
  }
  EnvironmentMaps maps;
  maps.matt.fill(Colour::Zero());
  for (int y = 0; y < sharp.height; ++y) {
    for (int x = 0; x < sharp.width; ++x) {
      const std::array<float, 9> basis = harmonics(sharp.direction(x, y));
      for (std::size_t i = 0; i < 9; ++i)
        maps.matt[i] += basis[i] * sharp.angle(y) * sharp.at(x, y);
    }
  }
  for (std::size_t i = 0; i < 9; ++i)
    maps.matt[i] *= i == 0 ? 1.f : i < 4 ? 2.f / 3.f : 0.25f; // the clamped cosine, over pi
  const Grid coarse = reduced(as_image(sharp), MIRROR_WIDTH / 2, MIRROR_HEIGHT / 2);
  for (int level = 0; level < MIRROR_LEVELS; ++level) {
    Grid blurred = coarse;
    for (int y = 0; level > 0 && y < coarse.height; ++y) {
      for (int x = 0; x < coarse.width; ++x)
        blurred.at(x, y) = lobe_mean(coarse, coarse.direction(x, y), static_cast<float>(level) / (MIRROR_LEVELS - 1));
    }
    for (int y = 0; y < MIRROR_HEIGHT; ++y) {
      for (int x = 0; x < MIRROR_WIDTH; ++x) {
        const Colour c =
            level == 0 ? sharp.at(x, y)
                       : bilinear(blurred, (static_cast<float>(x) + 0.5f) / 2.f, (static_cast<float>(y) + 0.5f) / 2.f);
        maps.mirrored.push_back({c[0], c[1], c[2], 1.f});
      }
    }
  }
  return maps;
}

Eigen::Vector3f matt_light(const EnvironmentMaps& maps, const Eigen::Vector3f& direction) {
  const std::array<float, 9> basis = harmonics(direction);
  Colour sum = Colour::Zero();
  for (std::size_t i = 0; i < 9; ++i)
    sum += basis[i] * maps.matt[i];
  return sum;
}

Rig day_rig() {
  constexpr double SUN_AZIMUTH = -48;
  constexpr double SUN_ELEVATION = 42;
  Grid sky{MIRROR_WIDTH, MIRROR_HEIGHT, std::vector<Colour>(MIRROR_WIDTH * MIRROR_HEIGHT)};
  const float degree = PI / 180.f;
  const float azimuth = static_cast<float>(SUN_AZIMUTH) * degree;
  const float elevation = static_cast<float>(SUN_ELEVATION) * degree;
  const Vector sun(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                   std::cos(elevation) * std::cos(azimuth));
  for (int y = 0; y < sky.height; ++y) {
    for (int x = 0; x < sky.width; ++x) {
      const Vector d = sky.direction(x, y);
      const float height = std::max(d.y(), 0.f);
      const Colour zenith(.13f, .24f, .50f);
      const Colour horizon(.62f, .70f, .80f);
      const float haze = std::exp(-5.f * height);
      const float near_sun = std::max(d.dot(sun), 0.f);
      const float glow = 0.9f * std::pow(near_sun, 60.f) + 0.25f * std::pow(near_sun, 8.f);
      sky.at(x, y) = zenith + haze * (horizon - zenith) + glow * Colour(1.f, .93f, .80f);
    }
  }
  Light light;
  light.azimuth_degrees = SUN_AZIMUTH;
  light.elevation_degrees = SUN_ELEVATION;
  light.radiance = {1.75f, 1.62f, 1.40f};
  light.angular_radius_degrees = 0.8;
  light.shadow = Light::Shadow::mapped;
  Rig rig = rig_of(sky, {light});
  rig.turning = Rig::Turning::with_camera;
  rig.backdrop = Rig::Backdrop::surroundings;
  return rig;
}

Result<Rig> image_rig(const LinearImage& surroundings) {
  if (surroundings.width < 8 || std::abs(surroundings.width - 2 * surroundings.height) > 2)
    return make_error(ErrorCode::bad_input,
                      "a picture of {} x {} pixels; an equirectangular one is twice as wide as high",
                      surroundings.width, surroundings.height);
  for (std::size_t i = 0; i < surroundings.pixels.size(); ++i) {
    if (i % 4 != 3 && !(surroundings.pixels[i] >= 0.f && surroundings.pixels[i] <= 1e9f))
      return make_error(ErrorCode::bad_input, "pixel {} of the surroundings is {}; light must be 0 or more", i / 4,
                        surroundings.pixels[i]);
  }
  Grid sky = reduced(surroundings, std::min(surroundings.width, 512), std::min(surroundings.height, 256));
  std::vector<Light> lights;
  if (const std::optional<Light> sun = take_sun(sky))
    lights.push_back(*sun);
  Rig rig = rig_of(sky, std::move(lights));
  if (!(rig.sky.maxCoeff() > 0.f) && rig.lights.empty())
    return make_error(ErrorCode::bad_input, "the surroundings are black above the horizon");
  return rig;
}

} // namespace wry::render
