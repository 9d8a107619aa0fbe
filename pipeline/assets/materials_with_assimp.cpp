#include "pipeline/assets/materials.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <assimp/scene.h>

namespace wry::pipeline {

namespace {

constexpr unsigned TEXTURES_MAX = 256;

bool is_gltf(const MeshFile& file) {
  return file.extension == "gltf" || file.extension == "glb";
}

float linear(float srgb) {
  const float v = std::clamp(srgb, 0.f, 1.f);
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

std::string base_name(std::string path) {
  std::replace(path.begin(), path.end(), '\\', '/');
  const std::size_t slash = path.find_last_of('/');
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

/// A picture that is part of the scene file: compressed bytes, or plain pixels.
Result<render::Image> embedded(const aiTexture& texture) {
  if (texture.mHeight == 0)
    return decode_picture(std::string(reinterpret_cast<const char*>(texture.pcData), texture.mWidth));
  if (texture.mWidth == 0 || texture.mWidth > 8192 || texture.mHeight > 8192)
    return make_error(ErrorCode::bad_input, "{} x {} pixels", texture.mWidth, texture.mHeight);
  render::Image image(static_cast<int>(texture.mWidth), static_cast<int>(texture.mHeight));
  for (std::size_t i = 0; i < image.pixels.size() / 4; ++i) {
    const aiTexel& texel = texture.pcData[i];
    const std::uint8_t rgba[] = {texel.r, texel.g, texel.b, texel.a};
    std::copy_n(rgba, 4, image.pixels.begin() + static_cast<std::ptrdiff_t>(4 * i));
  }
  return image;
}

/// Finds pictures once each, by the name that materials have for them.
class Pictures {
public:
  Pictures(const aiScene& scene, const MeshFile& file, RawMesh& raw)
      : m_scene(scene)
      , m_file(file)
      , m_raw(raw) {}

  int find(const std::string& name) {
    const auto known = m_known.find(name);
    if (known != m_known.end())
      return known->second;
    int index = -1;
    Result<render::Image> image = load(name);
    if (!image) {
      m_raw.notes.push_back(
          fmt::format("picture {}: {}; its material keeps its plain colour", base_name(name), image.error().message));
    } else if (m_raw.textures.size() < TEXTURES_MAX) {
      index = static_cast<int>(m_raw.textures.size());
      m_raw.textures.push_back(std::move(*image));
    }
    m_known[name] = index;
    return index;
  }

private:
  Result<render::Image> load(const std::string& name) const {
    if (const aiTexture* texture = m_scene.GetEmbeddedTexture(name.c_str()))
      return embedded(*texture);
    const auto beside = m_file.files.find(base_name(name));
    if (beside == m_file.files.end())
      return make_error(ErrorCode::missing_input, "not found beside the mesh");
    return decode_picture(beside->second);
  }

  const aiScene& m_scene;
  const MeshFile& m_file;
  RawMesh& m_raw;
  std::map<std::string, int> m_known;
};

Eigen::Vector3f base_colour(const aiMaterial& material, bool gltf, bool textured) {
  aiColor4D colour(0.6f, 0.6f, 0.6f, 1.f);
  const bool has_base = material.Get(AI_MATKEY_BASE_COLOR, colour) == AI_SUCCESS;
  if (!has_base && material.Get(AI_MATKEY_COLOR_DIFFUSE, colour) != AI_SUCCESS && textured)
    colour = aiColor4D(1.f, 1.f, 1.f, 1.f);
  // Old exporters write black beside a picture, which then should count alone.
  if (textured && colour.r + colour.g + colour.b < 1e-4f)
    colour = aiColor4D(1.f, 1.f, 1.f, 1.f);
  if (gltf)
    return {std::clamp(colour.r, 0.f, 1.f), std::clamp(colour.g, 0.f, 1.f), std::clamp(colour.b, 0.f, 1.f)};
  return {linear(colour.r), linear(colour.g), linear(colour.b)};
}

float roughness(const aiMaterial& material) {
  float value = 0.f;
  if (material.Get(AI_MATKEY_ROUGHNESS_FACTOR, value) == AI_SUCCESS)
    return std::clamp(value, 0.08f, 1.f);
  // Phong's exponent as the roughness of the same highlight.
  if (material.Get(AI_MATKEY_SHININESS, value) == AI_SUCCESS && value > 0.f)
    return std::clamp(std::pow(2.f / (value + 2.f), 0.25f), 0.25f, 0.9f);
  return 0.6f;
}

} // namespace

void gather_materials(const aiScene& scene, const MeshFile& file, RawMesh& raw) {
  Pictures pictures(scene, file, raw);
  for (unsigned m = 0; m < scene.mNumMaterials; ++m) {
    const aiMaterial& material = *scene.mMaterials[m];
    render::ArtistMaterial made;
    aiString name;
    if (material.Get(AI_MATKEY_NAME, name) == AI_SUCCESS)
      made.name = name.C_Str();
    aiString picture;
    if (material.GetTexture(aiTextureType_BASE_COLOR, 0, &picture) == AI_SUCCESS ||
        material.GetTexture(aiTextureType_DIFFUSE, 0, &picture) == AI_SUCCESS)
      made.texture = pictures.find(picture.C_Str());
    made.base_colour = base_colour(material, is_gltf(file), made.texture >= 0);
    made.roughness = roughness(material);
    float metallic = 0.f;
    if (material.Get(AI_MATKEY_METALLIC_FACTOR, metallic) == AI_SUCCESS)
      made.metallic = std::clamp(metallic, 0.f, 1.f);
    raw.materials.push_back(std::move(made));
  }
}

} // namespace wry::pipeline
