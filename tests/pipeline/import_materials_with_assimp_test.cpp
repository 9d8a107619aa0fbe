#include <algorithm>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/assets/materials.h"
#include "pipeline/assets/mesh_appearance.h"
#include "pipeline/assets/mesh_import.h"
#include "render/png.h"
#include "tests/pipeline/import_files_support.h"

namespace wry::pipeline {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

std::string png_bytes(int width, int height, std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
  render::Image image(width, height);
  for (std::size_t i = 0; i < image.pixels.size(); i += 4) {
    const std::uint8_t rgba[] = {red, green, blue, 255};
    std::copy_n(rgba, 4, image.pixels.begin() + static_cast<std::ptrdiff_t>(i));
  }
  const auto bytes = *render::encode_png(image, {});
  return {bytes.begin(), bytes.end()};
}

/// Two squares: one plain green, one with a picture; vertices of the shared edge have two texture coordinates.
const char* const OBJ = "mtllib two.mtl\n"
                        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n"
                        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                        "usemtl plain\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"
                        "usemtl pictured\nf 2/1 5/2 6/3\nf 2/1 6/3 3/4\n";
const char* const MTL = "newmtl plain\nKd 0 0.5 0\nNs 20\n"
                        "newmtl pictured\nKd 1 1 1\nmap_Kd paint.png\n";

TEST(Materials, OfAnObjFileComeWithTheirPictureAndCorners) {
  TemporaryFolder folder;
  folder.write("two.mtl", MTL);
  folder.write("paint.png", png_bytes(4, 2, 200, 100, 50));
  const Result<ImportedMesh> mesh = import_mesh(folder.write("two.obj", OBJ));
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  ASSERT_TRUE(mesh->appearance.has_value());
  const render::MeshAppearance& worn = *mesh->appearance;
  ASSERT_EQ(worn.material_of_triangle.size(), static_cast<std::size_t>(mesh->mesh.triangles.rows()));
  ASSERT_EQ(worn.textures.size(), 1U);
  EXPECT_EQ(worn.textures[0].width, 4);
  EXPECT_EQ(worn.textures[0].at(3, 1)[0], 200);
  ASSERT_EQ(worn.corner_uv.size(), 3 * worn.material_of_triangle.size());
  for (std::size_t t = 0; t < worn.material_of_triangle.size(); ++t) {
    const render::ArtistMaterial& material = worn.materials[static_cast<std::size_t>(worn.material_of_triangle[t])];
    const bool right_square = mesh->mesh.vertices(mesh->mesh.triangles(static_cast<Eigen::Index>(t), 0), 0) +
                                  mesh->mesh.vertices(mesh->mesh.triangles(static_cast<Eigen::Index>(t), 1), 0) +
                                  mesh->mesh.vertices(mesh->mesh.triangles(static_cast<Eigen::Index>(t), 2), 0) >
                              3.5;
    EXPECT_EQ(material.texture, right_square ? 0 : -1);
    if (!right_square) {
      EXPECT_NEAR(material.base_colour[1], 0.2140F, 1e-3F); // 0.5 sRGB
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const Eigen::Index vertex = mesh->mesh.triangles(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(c));
      const double left = right_square ? 1.0 : 0.0;
      EXPECT_NEAR(worn.corner_uv[3 * t + c][0], mesh->mesh.vertices(vertex, 0) - left, 1e-6);
      EXPECT_NEAR(worn.corner_uv[3 * t + c][1], 1.0 - mesh->mesh.vertices(vertex, 1), 1e-6);
    }
  }
}

TEST(Materials, KeepTheirColourWhenThePictureIsMissingOrDamaged) {
  TemporaryFolder folder;
  folder.write("two.mtl", MTL);
  const std::string path = folder.write("two.obj", OBJ);
  const Result<ImportedMesh> missing = import_mesh(path);
  ASSERT_TRUE(missing.ok()) << missing.error().message;
  EXPECT_THAT(missing->notes, Contains(HasSubstr("paint.png")));
  ASSERT_TRUE(missing->appearance.has_value());
  EXPECT_TRUE(missing->appearance->textures.empty());
  folder.write("paint.png", png_bytes(64, 64, 1, 2, 3).substr(0, 60));
  const Result<ImportedMesh> damaged = import_mesh(path);
  ASSERT_TRUE(damaged.ok()) << damaged.error().message;
  EXPECT_THAT(damaged->notes, Contains(HasSubstr("not a whole PNG")));
}

TEST(Materials, PaintedVerticesTintTheSurface) {
  TemporaryFolder folder;
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n"
      "0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n";
  const Result<ImportedMesh> mesh = import_mesh(folder.write("painted.ply", ply));
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  ASSERT_TRUE(mesh->appearance.has_value());
  ASSERT_EQ(mesh->appearance->corner_colour.size(), 3U);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& colour : mesh->appearance->corner_colour)
    sum += colour;
  EXPECT_NEAR((sum - Eigen::Vector3f::Ones()).norm(), 0.F, 1e-5F);
}

TEST(Materials, PicturesThatAreNoneAreRefused) {
  EXPECT_FALSE(decode_picture("GIF89a........").ok());
  EXPECT_FALSE(decode_picture(std::string("\xff\xd8\xff\xe0") + "short").ok());
  const Result<render::Image> whole = decode_picture(png_bytes(3, 5, 9, 8, 7));
  ASSERT_TRUE(whole.ok());
  EXPECT_EQ(whole->height, 5);
  std::string targa(18, '\0');
  targa[2] = 2;
  targa[12] = 2;
  targa[14] = 1;
  targa[16] = 24;
  targa += std::string("\x01\x02\x03\x04\x05\x06", 6);
  const Result<render::Image> two = decode_picture(targa);
  ASSERT_TRUE(two.ok()) << two.error().message;
  EXPECT_EQ(two->at(0, 0)[0], 3); // blue, green, red
  EXPECT_EQ(two->at(1, 0)[2], 4);
  EXPECT_FALSE(decode_picture(targa.substr(0, 22)).ok());
}

} // namespace
} // namespace wry::pipeline
