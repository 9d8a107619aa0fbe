#include "render/passes/pass.h"

#include <array>
#include <tuple>

#include "render/passes/picture_tiles.h"
#include "render/passes/shader_parts.h"

namespace wry::render {
namespace {

/// Distance along the view axis of every second pixel, floor included.
const char* const DISTANCE_MAIN = R"(
uniform sampler2D depth_map;
layout(location = 0) out float distance_out;
void main() {
  ivec2 pixel = min(ivec2(gl_FragCoord.xy) * 2, textureSize(depth_map, 0) - 1);
  float depth = texelFetch(depth_map, pixel, 0).x;
  float ground = distance_to_ground(ray_through(vec2(pixel) + 0.5));
  distance_out = depth > 0.0 ? near_distance / depth : (ground > 0.0 ? ground : 1e9);
})";

/// Ambient visibility from the horizons of two slices (Jimenez et al. 2016), and the mean distance of what stands
/// between the surface and the key light (Fernando 2005). The 4 x 4 pattern of directions is averaged by the next pass.
const char* const SEARCH_MAIN = R"(
uniform sampler2D distance_map;
uniform usampler2D surface_map;
uniform sampler2D shadow_depth_map;
uniform int shadowed;
layout(location = 0) out vec4 found; // visibility, blocker distance * share, share, distance

const int SLICES = 2;
const int STEPS = 3;
const float ORDER[16] = float[](0.0, 8.0, 2.0, 10.0, 12.0, 4.0, 14.0, 6.0, 3.0, 11.0, 1.0, 9.0, 15.0, 7.0, 13.0, 5.0);

float fast_acos(float x) {
  float a = abs(x);
  float angle = sqrt(1.0 - a) * (1.5707963 + a * (-0.2121144 + 0.0742610 * a));
  return x >= 0.0 ? angle : PI - angle;
}

float visibility(vec2 half_place, vec3 ray, float z, vec3 n, float turn, float phase) {
  // In the camera's own axes: right, up, and distance along the view axis.
  vec2 tangent = vec2(length(ray_right), length(ray_up));
  vec3 right = ray_right / tangent.x;
  vec3 up = ray_up / tangent.y;
  vec3 slope = vec3(dot(ray, right), dot(ray, up), 1.0);
  vec3 p = slope * z;
  vec3 v = -normalize(slope);
  vec3 normal = vec3(dot(n, right), dot(n, up), dot(n, ray_centre));
  float reach = 0.30 * scene_radius;
  float pixels = min(reach * 0.25 * size.x / (tangent.x * z), 0.125 * size.x);
  vec2 per_texel = 1.0 / vec2(textureSize(distance_map, 0));
  vec2 per_place = 4.0 * tangent / size; // of half pixels
  vec2 first = (vec2(1.0) / size - 1.0 - jitter) * tangent - 0.5 * per_place;
  float per_reach = 1.0 / (reach * reach);
  float sum = 0.0;
  for (int slice = 0; slice < SLICES; ++slice) {
    float angle = (float(slice) + turn) * (PI / float(SLICES));
    vec2 direction = vec2(cos(angle), sin(angle));
    vec3 along = vec3(direction, 0.0);
    vec3 ortho = along - v * dot(along, v);
    vec3 axis = normalize(cross(ortho, v));
    vec3 in_slice = normal - axis * dot(normal, axis);
    float in_length = length(in_slice) + 1e-6;
    float cosine_n = clamp(dot(in_slice, v) / in_length, 0.0, 1.0);
    float sign_n = dot(in_slice, ortho) >= 0.0 ? 1.0 : -1.0;
    float angle_n = sign_n * fast_acos(cosine_n);
    float sine_n = sign_n * sqrt(1.0 - cosine_n * cosine_n);
    vec2 lowest = vec2(-sine_n, sine_n); // cosines of the horizons where nothing stands
    vec2 highest = lowest;
    for (int k = 0; k < STEPS; ++k) {
      float s = (float(k) + phase) / float(STEPS);
      vec2 offset = direction * max(s * s * pixels, 1.0 + float(k));
      for (int side = 0; side < 2; ++side) {
        vec2 place = floor(half_place + (side == 0 ? offset : -offset)) + 0.5;
        vec2 at = place * per_texel;
        float distance = textureLod(distance_map, at, 0.0).x;
        vec3 there = vec3((first + place * per_place) * distance, distance) - p;
        float square = dot(there, there);
        float fade = clamp(1.0 - square * per_reach, 0.0, 1.0);
        fade = max(abs(at.x - 0.5), abs(at.y - 0.5)) < 0.5 ? fade : 0.0; // nothing is known beyond the picture
        float cosine = mix(lowest[side], dot(there, v) * inversesqrt(square + 1e-20), fade);
        highest[side] = max(highest[side], cosine);
      }
    }
    float h0 = fast_acos(clamp(highest[0], -1.0, 1.0));
    float h1 = -fast_acos(clamp(highest[1], -1.0, 1.0));
    h0 = angle_n + min(h0 - angle_n, 0.5 * PI);
    h1 = angle_n + max(h1 - angle_n, -0.5 * PI);
    sum += in_length * 0.25 * (2.0 * cosine_n + 2.0 * (h0 + h1) * sine_n - cos(2.0 * h0 - angle_n) -
                               cos(2.0 * h1 - angle_n));
  }
  return 1.06 * sum / float(SLICES); // an open floor is open, whatever the taps were rounded to; may exceed 1 until the mean
}

vec2 blockers(vec3 position, vec3 normal, float turn) {
  vec3 place = shadow_place(position, normal);
  vec2 slope = shadow_slope(normal);
  float radius = min(1.4 * shadow_spread * shadow_depth, 0.12 * shadow_extent) / shadow_extent;
  vec2 sum = vec2(0.0);
  float angle = 2.3999632 * 16.0 * turn;
  vec2 direction = radius * vec2(cos(angle), sin(angle));
  const mat2 ON = mat2(-0.7373688, 0.6754903, -0.6754903, -0.7373688); // by the golden angle
  for (int i = 0; i < 8; ++i) {
    vec2 offset = direction * sqrt((float(i) + 0.5) / 8.0);
    direction = ON * direction;
    float depth = textureLod(shadow_depth_map, place.xy + offset, 0.0).x;
    float gap = (min(place.z + dot(slope, offset), 0.9999) - depth) * shadow_depth - 0.5 * shadow_texel;
    sum += gap > 0.0 ? vec2(gap, 1.0) : vec2(0.0);
  }
  return sum / 8.0;
}

void main() {
  ivec2 half_pixel = ivec2(gl_FragCoord.xy);
  ivec2 pixel = min(half_pixel * 2, textureSize(surface_map, 0) - 1);
  float z = texelFetch(distance_map, half_pixel, 0).x;
  vec3 ray = ray_through(vec2(pixel) + 0.5);
  uvec2 surface = texelFetch(surface_map, pixel, 0).xy;
  vec3 n = surface.x != 0u ? from_octahedral(unpackSnorm2x16(surface.y)) : world_up;
  float order = ORDER[(half_pixel.x & 3) + 4 * (half_pixel.y & 3)];
  float turn = (order + 0.5) / 16.0;
  float phase = fract(turn * 7.0 + 0.25);
  float seen = visibility(gl_FragCoord.xy, ray, z, n, turn, phase);
  vec2 blocked = shadowed >= 0 ? blockers(eye + ray * z, n, turn) : vec2(0.0);
  found = z >= 1e8 ? vec4(1.0, 0.0, 0.0, 6e4) : vec4(seen, blocked, z / scene_radius);
})";

/// Mean of 4 x 4 neighbours at about the same distance: along x at half size, then along y while enlarging.
const char* const MEAN_X_MAIN = R"(
uniform sampler2D found_map;
layout(location = 0) out vec4 mean;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  int last = textureSize(found_map, 0).x - 1;
  vec4 centre = texelFetch(found_map, pixel, 0);
  vec4 sum = vec4(centre.xyz, 1.0);
  for (int i = -2; i <= 1; ++i) {
    vec4 tap = texelFetch(found_map, ivec2(clamp(pixel.x + (i < 0 ? i : i + 1), 0, last), pixel.y), 0);
    float weight = max(0.0, 1.0 - abs(tap.w - centre.w) / (0.02 * centre.w));
    sum += vec4(tap.xyz, 1.0) * weight * (i == -2 || i == 1 ? 0.5 : 1.0);
  }
  mean = vec4(sum.xyz / sum.w, centre.w);
})";

const char* const ENLARGE_MAIN = R"(
uniform sampler2D found_map;
uniform sampler2D depth_map;
layout(location = 0) out vec4 occlusion; // visibility, blocker distance / reach of the light, share, 1
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float depth = texelFetch(depth_map, pixel, 0).x;
  float ground = distance_to_ground(ray_through(gl_FragCoord.xy));
  float z = (depth > 0.0 ? near_distance / depth : (ground > 0.0 ? ground : 6e4 * scene_radius)) / scene_radius;
  vec2 per_texel = 1.0 / vec2(textureSize(found_map, 0));
  ivec2 half_pixel = pixel / 2;
  int beside = half_pixel.x + (pixel.x & 1);
  vec4 sum = vec4(0.0);
  for (int i = -2; i <= 2; ++i) {
    int row = half_pixel.y + i;
    // Four rows' worth about the pixel: it lies on a row, or between two.
    float share = (pixel.y & 1) == 0 ? (i == -2 || i == 2 ? 0.5 : 1.0) : (i == -2 ? 0.0 : 1.0);
    vec4 tap = textureLod(found_map, (vec2((i & 1) == 0 ? half_pixel.x : beside, row) + 0.5) * per_texel, 0.0);
    float near_by = 0.012 * z / (0.012 * z + abs(tap.w - z));
    float weight = near_by * near_by * share;
    sum += vec4(tap.xyz, 1.0) * weight;
  }
  vec3 mean = sum.xyz * (1.0 / sum.w);
  occlusion = vec4(mean.x, mean.y / (max(mean.z, 1e-4) * shadow_depth), mean.z, 1.0);
})";

struct OcclusionPrograms {
  Program distance;
  Program search;
  Program mean_x;
  Program enlarge;
};

struct OcclusionTargets {
  GlObject distance;
  GlObject found;
  GlObject mean;
  GlObject distance_frame;
  GlObject found_frame;
  GlObject mean_frame;
  GlObject occlusion_frame;
  GlObject plain_sampler; ///< reads the shadow map's depths instead of comparing with them
};

/// How much of the surroundings each point sees, and how wide the key light's penumbra is there. Once per picture.
class OcclusionPass final : public Pass {
public:
  OcclusionPass(const PassResources& resources, OcclusionPrograms programs, OcclusionTargets targets)
      : m_resources(resources)
      , m_programs(std::move(programs))
      , m_targets(std::move(targets))
      , m_tiles(resources.targets.size) {}

  void draw(const SubFrame& sub_frame) override {
    const GlFunctions& gl = m_resources.gl;
    const Targets& shared = m_resources.targets;
    const std::array<float, 4> open = {1.f, 0.f, 0.f, 1.f};
    gl.Disable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    gl.ClearNamedFramebufferfv(m_targets.mean_frame.name(), GL_COLOR, 0, open.data()); // beyond what is touched
    const PixelRect half = halved(sub_frame.touched);
    step(m_programs.distance, m_targets.distance_frame, shared.half_size,
         {{0, 0, shared.half_size.width, shared.half_size.height}}, sub_frame, {{{"depth_map", shared.depth.name()}}});
    gl.BindSampler(2, m_targets.plain_sampler.name());
    step(m_programs.search, m_targets.found_frame, shared.half_size, {half}, sub_frame,
         {{{"distance_map", m_targets.distance.name()},
           {"surface_map", shared.surface.name()},
           {"shadow_depth_map", shared.shadow.name()}}});
    gl.BindSampler(2, 0);
    step(m_programs.mean_x, m_targets.mean_frame, shared.half_size, {half}, sub_frame,
         {{{"found_map", m_targets.found.name()}}});
    gl.ClearNamedFramebufferfv(m_targets.occlusion_frame.name(), GL_COLOR, 0, open.data());
    step(m_programs.enlarge, m_targets.occlusion_frame, shared.size, enclosed(), sub_frame,
         {{{"found_map", m_targets.mean.name()}, {"depth_map", shared.depth.name()}}});
  }

private:
  using Inputs = std::vector<std::pair<const char*, GLuint>>;

  static PixelRect halved(const PixelRect& full) {
    constexpr int REACH = 3; // what the next steps read beside it
    return {std::max(full.x / 2 - REACH, 0), std::max(full.y / 2 - REACH, 0), (full.width + 3) / 2 + 2 * REACH,
            (full.height + 3) / 2 + 2 * REACH};
  }

  void step(const Program& program, const GlObject& frame, const ImageSize& size, const std::vector<PixelRect>& rects,
            const SubFrame& sub_frame, const Inputs& inputs) {
    const GlFunctions& gl = m_resources.gl;
    gl.BindFramebuffer(GL_FRAMEBUFFER, frame.name());
    gl.Viewport(0, 0, size.width, size.height);
    program.use();
    set_camera_part(program, sub_frame, m_resources.plan, m_resources.targets.size);
    set_shadow_space_part(program, sub_frame.lights);
    program.set("shadowed", sub_frame.lights.shadowed);
    for (std::size_t unit = 0; unit < inputs.size(); ++unit) {
      gl.BindTextureUnit(static_cast<GLuint>(unit), inputs[unit].second);
      program.set(inputs[unit].first, static_cast<int>(unit));
    }
    for (const PixelRect& rect : rects)
      draw_in_rect(gl, rect);
  }

  /// Where anything stands before the sky or the key light, and beside it: the rest is open already.
  std::vector<PixelRect> enclosed() {
    const ImageSize& half = m_resources.targets.half_size;
    m_mean.resize(static_cast<std::size_t>(half.width) * static_cast<std::size_t>(half.height));
    m_resources.gl.GetTextureImage(m_targets.mean.name(), 0, GL_RGBA, GL_HALF_FLOAT,
                                   static_cast<GLsizei>(m_mean.size() * sizeof(m_mean.front())), m_mean.data());
    m_tiles.clear();
    m_tiles.take_enclosed(m_mean, half);
    return m_tiles.enclosed();
  }

  PassResources m_resources;
  OcclusionPrograms m_programs;
  OcclusionTargets m_targets;
  PictureTiles m_tiles;
  std::vector<std::array<std::uint16_t, 4>> m_mean; ///< as the tiles read it
};

Result<OcclusionTargets> make_occlusion_targets(const PassResources& resources) {
  const GlFunctions& gl = resources.gl;
  const ImageSize& half = resources.targets.half_size;
  OcclusionTargets targets;
  targets.distance = make_texture(gl, GL_R32F, half.width, half.height, TextureFilter::nearest);
  targets.found = make_texture(gl, GL_RGBA16F, half.width, half.height, TextureFilter::nearest);
  targets.mean = make_texture(gl, GL_RGBA16F, half.width, half.height, TextureFilter::nearest);
  for (const auto& [frame, texture] :
       {std::pair(&targets.distance_frame, targets.distance.name()),
        std::pair(&targets.found_frame, targets.found.name()), std::pair(&targets.mean_frame, targets.mean.name()),
        std::pair(&targets.occlusion_frame, resources.targets.occlusion.name())}) {
    Result<GlObject> made = make_framebuffer(gl, texture, 0);
    if (!made.ok())
      return made.error();
    *frame = std::move(*made);
  }
  GLuint sampler = 0;
  gl.CreateSamplers(1, &sampler);
  targets.plain_sampler = GlObject(gl, sampler, [](const GlFunctions& f, GLuint n) { f.DeleteSamplers(1, &n); });
  for (const auto& [what, value] :
       {std::pair(GL_TEXTURE_COMPARE_MODE, GL_NONE), std::pair(GL_TEXTURE_MIN_FILTER, GL_NEAREST),
        std::pair(GL_TEXTURE_MAG_FILTER, GL_NEAREST), std::pair(GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE),
        std::pair(GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE)})
    gl.SamplerParameteri(sampler, static_cast<GLenum>(what), value);
  return targets;
}

} // namespace

Result<std::unique_ptr<Pass>> create_occlusion_pass(const PassResources& resources) {
  OcclusionPrograms programs;
  for (const auto& [program, what, main] :
       {std::tuple(&programs.distance, "distance", DISTANCE_MAIN), std::tuple(&programs.search, "search", SEARCH_MAIN),
        std::tuple(&programs.mean_x, "mean", MEAN_X_MAIN), std::tuple(&programs.enlarge, "enlarge", ENLARGE_MAIN)}) {
    Result<Program> made = Program::create(resources.gl, what, FULL_SCREEN_VERTEX_SHADER,
                                           std::string("#version 450 core\n") + CAMERA_PART + SHADOW_SPACE_PART + main);
    if (!made.ok())
      return made.error();
    *program = std::move(*made);
  }
  Result<OcclusionTargets> targets = make_occlusion_targets(resources);
  if (!targets.ok())
    return targets.error();
  return std::unique_ptr<Pass>(std::make_unique<OcclusionPass>(resources, std::move(programs), std::move(*targets)));
}

} // namespace wry::render
