#include "pipeline/assets/node_motion_with_assimp.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include <assimp/scene.h>
#include <fmt/ranges.h>

namespace wry::pipeline {

namespace {

constexpr std::size_t MAX_SAMPLES = 20'000;
constexpr double SAMPLE_SPACING = 1.0 / 120.0; // [s]
/// What assimp means when a file does not say how long a tick is.
constexpr double DEFAULT_TICKS_PER_SECOND = 25.0;
constexpr unsigned MAX_DEPTH = 10'000;

/// The keys on both sides of a time and how far it is between them.
template <class Key> struct Between {
  const Key* from = nullptr;
  const Key* to = nullptr;
  double share = 0.0;
};

template <class Key> Between<Key> keys_around(const Key* keys, unsigned count, double tick) {
  const Key* end = keys + count;
  const Key* after = std::upper_bound(keys, end, tick, [](double time, const Key& key) { return time < key.mTime; });
  if (after == keys)
    return {keys, keys, 0.0};
  if (after == end)
    return {end - 1, end - 1, 0.0};
  const Key* before = after - 1;
  const double length = after->mTime - before->mTime;
  return {before, after, length > 0.0 ? (tick - before->mTime) / length : 0.0};
}

aiVector3D vector_at(const aiVectorKey* keys, unsigned count, double tick, const aiVector3D& otherwise) {
  if (count == 0)
    return otherwise;
  const Between<aiVectorKey> around = keys_around(keys, count, tick);
  return around.from->mValue + (around.to->mValue - around.from->mValue) * static_cast<ai_real>(around.share);
}

aiQuaternion rotation_at(const aiNodeAnim& channel, double tick, const aiQuaternion& otherwise) {
  if (channel.mNumRotationKeys == 0)
    return otherwise;
  const Between<aiQuatKey> around = keys_around(channel.mRotationKeys, channel.mNumRotationKeys, tick);
  aiQuaternion between;
  aiQuaternion::Interpolate(between, around.from->mValue, around.to->mValue, static_cast<ai_real>(around.share));
  return between.Normalize();
}

/// A node, from the root down, with what animates it.
struct Link {
  const aiNode* node = nullptr;
  const aiNodeAnim* channel = nullptr;

  aiMatrix4x4 at(double tick) const {
    if (channel == nullptr)
      return node->mTransformation;
    aiVector3D scale, position;
    aiQuaternion rotation;
    node->mTransformation.Decompose(scale, rotation, position);
    return aiMatrix4x4(vector_at(channel->mScalingKeys, channel->mNumScalingKeys, tick, scale),
                       rotation_at(*channel, tick, rotation),
                       vector_at(channel->mPositionKeys, channel->mNumPositionKeys, tick, position));
  }
};

void collect_names(const aiNode& node, std::vector<std::string>& names) {
  constexpr std::size_t SHOWN = 12;
  if (names.size() < SHOWN && node.mName.length > 0)
    names.emplace_back(node.mName.C_Str());
  for (unsigned i = 0; i < node.mNumChildren && names.size() < SHOWN; ++i)
    collect_names(*node.mChildren[i], names);
}

std::vector<Link> chain_to(const aiNode* node, const aiAnimation* animation) {
  std::vector<Link> chain;
  for (; node != nullptr && chain.size() < MAX_DEPTH; node = node->mParent) {
    Link link{node, nullptr};
    for (unsigned c = 0; animation != nullptr && c < animation->mNumChannels; ++c) {
      if (animation->mChannels[c]->mNodeName == node->mName)
        link.channel = animation->mChannels[c];
    }
    chain.push_back(link);
  }
  std::reverse(chain.begin(), chain.end());
  return chain;
}

template <class Key> void add_times(const Key* keys, unsigned count, std::set<double>& ticks) {
  for (unsigned i = 0; i < count && ticks.size() < MAX_SAMPLES; ++i) {
    if (std::isfinite(keys[i].mTime))
      ticks.insert(keys[i].mTime);
  }
}

/// The times of all keys, and times between them where they are far apart.
std::vector<double> sample_ticks(const std::vector<Link>& chain, double ticks_per_second) {
  std::set<double> ticks;
  for (const Link& link : chain) {
    if (link.channel == nullptr)
      continue;
    add_times(link.channel->mPositionKeys, link.channel->mNumPositionKeys, ticks);
    add_times(link.channel->mRotationKeys, link.channel->mNumRotationKeys, ticks);
    add_times(link.channel->mScalingKeys, link.channel->mNumScalingKeys, ticks);
  }
  if (ticks.empty())
    return {};
  const double length = *ticks.rbegin() - *ticks.begin();
  const double spacing = std::max(SAMPLE_SPACING * ticks_per_second, length / (MAX_SAMPLES / 2.0));
  std::vector<double> samples;
  for (const double tick : ticks) {
    if (!samples.empty()) {
      const double before = samples.back();
      const int pieces = std::max(1, static_cast<int>(std::ceil((tick - before) / spacing - 1e-9)));
      for (int i = 1; i < pieces; ++i)
        samples.push_back(before + (tick - before) * i / pieces);
    }
    samples.push_back(tick);
  }
  return samples;
}

aiMatrix4x4 product_at(const std::vector<Link>& chain, double tick) {
  aiMatrix4x4 product;
  for (const Link& link : chain)
    product = product * link.at(tick);
  return product;
}

RawTransform flat(const aiMatrix4x4& m) {
  return {m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3, m.d4};
}

bool is_gltf(const std::string& extension) {
  return extension == "gltf" || extension == "glb";
}

/// From a frame that looks along -z with y up to the camera's own. Cameras of glTF are such frames; assimp 5.2 gives
/// their node's place a second time as the camera's own.
aiMatrix4x4 camera_frame(const aiCamera& camera, const std::string& extension) {
  if (is_gltf(extension))
    return {};
  aiVector3D backward = -camera.mLookAt;
  backward.NormalizeSafe();
  aiVector3D right = camera.mUp ^ backward;
  right.NormalizeSafe();
  const aiVector3D up = backward ^ right;
  const aiVector3D& at = camera.mPosition;
  return {right.x, up.x, backward.x, at.x, right.y, up.y, backward.y, at.y,
          right.z, up.z, backward.z, at.z, 0,       0,    0,          1};
}

/// Horizontal opening [rad]. Of glTF files assimp 5.2 gives the vertical one times the aspect.
double opening_of(const aiCamera& camera, const std::string& extension) {
  constexpr double USUAL_ASPECT = 16.0 / 9.0;
  double opening = camera.mHorizontalFOV;
  if (is_gltf(extension)) {
    const double aspect = camera.mAspect > 0.f ? camera.mAspect : USUAL_ASPECT;
    const double vertical = camera.mAspect > 0.f ? opening / aspect : opening;
    opening = 2.0 * std::atan(aspect * std::tan(0.5 * vertical));
  }
  return std::clamp(opening, 1e-3, std::numbers::pi - 1e-3);
}

const aiCamera* camera_of(const aiScene& scene, const aiString& name) {
  for (unsigned i = 0; i < scene.mNumCameras; ++i) {
    if (scene.mCameras[i]->mName == name)
      return scene.mCameras[i];
  }
  return nullptr;
}

} // namespace

Result<RawMotion> read_node_motion(const aiScene& scene, const std::string& wanted, const std::string& extension) {
  if (wanted.empty() && scene.mNumCameras == 0)
    return make_error(ErrorCode::bad_input, "it holds no camera; name the node whose motion is wanted");
  const aiString name = wanted.empty() ? scene.mCameras[0]->mName : aiString(wanted);
  const aiNode* node = scene.mRootNode->FindNode(name);
  if (node == nullptr) {
    std::vector<std::string> names;
    collect_names(*scene.mRootNode, names);
    return make_error(ErrorCode::bad_input, "there is no node '{}'; there are {}", name.C_Str(),
                      fmt::join(names, ", "));
  }
  const aiAnimation* animation = scene.mNumAnimations > 0 ? scene.mAnimations[0] : nullptr;
  const double ticks_per_second =
      animation != nullptr && animation->mTicksPerSecond > 0.0 ? animation->mTicksPerSecond : DEFAULT_TICKS_PER_SECOND;
  const aiCamera* camera = camera_of(scene, name);
  const aiMatrix4x4 local = camera != nullptr ? camera_frame(*camera, extension) : aiMatrix4x4();
  RawMotion motion;
  motion.camera_fov = camera != nullptr ? opening_of(*camera, extension) : 0.0;
  motion.rest = flat(product_at(chain_to(node, nullptr), 0.0) * local);
  const std::vector<Link> chain = chain_to(node, animation);
  for (const double tick : sample_ticks(chain, ticks_per_second)) {
    motion.times.push_back(tick / ticks_per_second);
    motion.transforms.push_back(flat(product_at(chain, tick) * local));
  }
  return motion;
}

} // namespace wry::pipeline
