#include <cmath>

#include <gtest/gtest.h>

#include "tests/render/pictures_support.h"
#include "tests/render/shapes_support.h"

namespace wry::render {
namespace {

TEST(Material, WhiteBallVanishesInAWhiteFurnace) {
  const MeshScene ball = make_mesh_scene(testing::sphere(Vec3(0, 0, 0), 1, 64, 128), "ball", "");
  for (const float metallic : {0.F, 1.F}) {
    for (const float roughness : {0.1F, 0.4F, 0.7F, 1.F}) {
      Look look = testing::white(roughness, metallic);
      look.clearcoat = roughness < 0.5F ? 1.F : 0.F;
      Result<Renderer> renderer = Renderer::create(testing::white_furnace(ball, look), ball.scene);
      ASSERT_TRUE(renderer.ok()) << renderer.error().message;
      const Result<LinearImage> image = renderer->draw_linear(ball.frame, {});
      ASSERT_TRUE(image.ok());
      double worst = 0.0;
      for (std::size_t i = 0; i < image->pixels.size(); i += 4)
        worst = std::max(worst, std::abs(1.0 - static_cast<double>(image->pixels[i])));
      EXPECT_LT(worst, 0.012) << "roughness " << roughness << ", metallic " << metallic;
    }
  }
}

} // namespace
} // namespace wry::render
