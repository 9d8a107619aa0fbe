#include "render/passes/light_shader.h"

#include <fmt/format.h>

#include "render/passes/shader_parts.h"

namespace wry::render {
namespace {

const char* const DECLARATIONS = R"(
uniform usampler2D surface_map;
uniform sampler2D depth_map;
uniform sampler2D brdf_map;
uniform sampler2DShadow shadow_map;
uniform sampler2D occlusion_map;
layout(location = 0) out vec4 light_out;

uniform float weight;
uniform float noise_turn;
uniform vec4 key_taps[4];

uniform vec3 ground_colour;
uniform int catch_shadow;
uniform int show_around;

uniform vec4 look_base[64];    // base colour, roughness
uniform vec4 look_layers[64];  // metallic, specular, clearcoat, clearcoat roughness
uniform vec4 look_scatter[64]; // scatter colour, wrap
uniform vec4 look_clear[64];   // transparency

uniform vec4 light_directions[4];
uniform vec4 light_radiances[4];
uniform vec3 floor_key;    // of the shadowed light, on a level white floor
uniform vec3 floor_others; // of the lights without shadows
uniform vec3 sky;
uniform vec3 bounce;
uniform vec3 backdrop;

#ifdef ENVIRONMENT
uniform vec4 matt_harmonics[9];
uniform sampler2D mirrored_map;
uniform vec3 around_x; // axes of the picture of the surroundings
uniform vec3 around_y;
uniform vec3 around_z;
uniform float backdrop_level; // of the mirrored map
#endif

uniform float shadow_share;
uniform float occlusion_share; // 0: everything is open

uniform vec4 heat_map[10];
)";

const char* const SHADOW = R"(
// Share of the key light that arrives: taps on a spiral, turned per pixel, over the part of the light's disc that this
// sub-frame stands for, seen from as far as the blockers are; sub-frames of one map share them out. Each tap's depth
// follows the receiver's plane, so a wide filter needs no wide bias.
float key_visibility(vec3 position, vec3 normal, vec2 blockers) {
  vec3 place = shadow_place(position, normal);
  vec2 slope = shadow_slope(normal);
  float width = shadow_spread * shadow_share * blockers.x * shadow_depth;
  float radius = max(width, 1.2 * shadow_texel) / shadow_extent;
  float turn = 6.2831853 * (gradient_noise(gl_FragCoord.xy) + noise_turn);
  mat2 rotation = mat2(cos(turn), sin(turn), -sin(turn), cos(turn)) * radius;
  float sum = 0.0;
  for (int i = 0; i < KEY_TAPS; ++i) {
    vec2 offset = rotation * key_taps[i].xy;
    float bias = dot(slope, offset) - 0.35 * shadow_texel / shadow_depth;
    sum += textureLod(shadow_map, vec3(place.xy + offset, min(place.z + bias, 0.9999)), 0.0);
  }
  return sum / float(KEY_TAPS);
}
)";

const char* const AROUND = R"(
#ifdef ENVIRONMENT
// What a white matt surface sends back of the sky and of the light from below.
vec3 matt_around(vec3 n) {
  vec3 d = vec3(dot(n, around_x), dot(n, around_y), dot(n, around_z));
  vec3 sum = matt_harmonics[0].rgb * 0.282095 +
             0.488603 * (matt_harmonics[1].rgb * d.y + matt_harmonics[2].rgb * d.z + matt_harmonics[3].rgb * d.x) +
             1.092548 * (matt_harmonics[4].rgb * (d.x * d.y) + matt_harmonics[5].rgb * (d.y * d.z) +
                         matt_harmonics[7].rgb * (d.x * d.z)) +
             matt_harmonics[6].rgb * (0.315392 * (3.0 * d.z * d.z - 1.0)) +
             matt_harmonics[8].rgb * (0.546274 * (d.x * d.x - d.y * d.y));
  return max(sum, 0.0);
}

vec3 mirrored_at(vec2 place, float level) {
  const float HEIGHT = 64.0;
  float row = clamp(place.y * HEIGHT, 0.5, HEIGHT - 0.5) + level * HEIGHT;
  return textureLod(mirrored_map, vec2(place.x, row / (6.0 * HEIGHT)), 0.0).rgb;
}

// The surroundings, blurred as far as the surface is rough.
vec3 surroundings(vec3 direction, float roughness) {
  vec3 d = vec3(dot(direction, around_x), dot(direction, around_y), dot(direction, around_z));
  vec2 place = vec2(atan(d.x, d.z) / (2.0 * PI) + 0.5, acos(clamp(d.y, -1.0, 1.0)) / PI);
  float level = clamp(roughness, 0.0, 1.0) * 5.0;
  return mix(mirrored_at(place, floor(level)), mirrored_at(place, ceil(level)), fract(level));
}
#else
vec3 matt_around(vec3 n) { return mix(bounce, sky, 0.5 + 0.5 * dot(n, world_up)); }

// The sky and the light from below, blurred as far as the surface is rough.
vec3 surroundings(vec3 direction, float roughness) {
  float width = 0.15 + 0.85 * roughness;
  return mix(bounce, sky, smoothstep(-width, width, dot(direction, world_up)));
}
#endif
)";

const char* const MATERIAL = R"(
struct Surface {
  vec3 base;
  float roughness;
  float metallic;
  float specular;
  vec3 wrap;
  float coat;
  float coat_roughness;
};

vec2 split_sum(float cosine, float roughness) {
  const float SIDE = 32.0;
  return texture(brdf_map, (vec2(cosine, roughness) * (SIDE - 1.0) + 0.5) / SIDE).xy;
}

// Light of the far lights that a GGX layer mirrors to the eye, over Fresnel (Walter et al. 2007, Heitz 2014).
float ggx(float alpha, float nl, float nv, float nh) {
  float a2 = alpha * alpha;
  float d = nh * nh * (a2 - 1.0) + 1.0;
  float smith = nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2);
  return 0.5 * a2 / max(d * d * smith, 1e-7); // the 1/pi of D is the pi of radiance per white matt surface
}

vec3 shade(Surface s, vec3 n, vec3 v, float key, float ambient) {
  float nv = max(dot(n, v), 1e-3);
  vec3 f0 = mix(vec3(0.08 * s.specular), s.base, s.metallic);
  vec2 split = split_sum(nv, s.roughness);
  // Light that bounces more than once between the facets (Turquin 2019).
  vec3 again = 1.0 + f0 * (1.0 / max(split.x + split.y, 0.05) - 1.0);
  vec3 mirrored = (f0 * split.x + split.y) * again;
#ifdef COATED
  vec2 coat_split = split_sum(nv, s.coat_roughness);
  float coat_mirrored = s.coat * (0.04 * coat_split.x + coat_split.y) *
                        (1.0 + 0.04 * (1.0 / max(coat_split.x + coat_split.y, 0.05) - 1.0));
  float coat_alpha = s.coat_roughness * s.coat_roughness;
#endif
  vec3 matt = s.base * (1.0 - s.metallic) * (1.0 - mirrored);
  float alpha = s.roughness * s.roughness;
  vec3 per_wrap = 1.0 / ((1.0 + s.wrap) * (1.0 + s.wrap));

  // Hollows of bright surfaces are lit by themselves (Jimenez et al. 2016).
  vec3 own = s.base * (1.0 - s.metallic);
  vec3 open = max(vec3(ambient), ((ambient * (2.0404 * own - 0.3324) - 4.7951 * own + 0.6417) * ambient +
                                  2.7552 * own + 0.6903) * ambient);
  vec3 from_around = matt * matt_around(n) * open;
  vec3 r = reflect(-v, n);
  float mirror_open = clamp((nv + ambient) * (nv + ambient) - 1.0 + ambient, 0.0, 1.0);
  from_around += mirrored * surroundings(r, s.roughness) * mirror_open;
#ifdef COATED
  from_around = from_around * (1.0 - coat_mirrored) + coat_mirrored * surroundings(r, s.coat_roughness) * mirror_open;
#endif

  vec3 sum = from_around;
  for (int i = 0; i < LIGHT_COUNT; ++i) {
    vec3 l = light_directions[i].xyz;
    float spread = light_directions[i].w;
    float arrives = i == SHADOWED ? key : mix(0.35, 1.0, ambient);
    float cosine = dot(n, l);
    vec3 wrapped = max(vec3(cosine) + s.wrap, 0.0) * per_wrap;
    float nl = max(cosine, 0.0);
    // The half vector is (l + v) / |l + v|, and |l + v|^2 = 2 + 2 l.v.
    float lv = dot(l, v);
    float per_half = inversesqrt(max(2.0 + 2.0 * lv, 1e-6));
    float nh = clamp((cosine + dot(n, v)) * per_half, 0.0, 1.0);
    float away = 1.0 - min((1.0 + lv) * per_half, 1.0);
    float fresnel = away * away * away * away * away;
    vec3 glint = (f0 + (1.0 - f0) * fresnel) * again * (ggx(min(alpha + 0.5 * spread, 1.0), nl, nv, nh) * nl);
    vec3 sent = matt * wrapped + glint;
#ifdef COATED
    sent = sent * (1.0 - coat_mirrored) +
           s.coat * (0.04 + 0.96 * fresnel) * ggx(min(coat_alpha + 0.5 * spread, 1.0), nl, nv, nh) * nl;
#endif
    sum += light_radiances[i].rgb * arrives * sent;
  }
  return sum;
}
)";

const char* const SUBJECT_MAIN = R"(
vec3 heat_colour(float t) {
  float place = t * 9.0;
  int low = min(int(place), 8);
  return mix(heat_map[low].rgb, heat_map[low + 1].rgb, place - float(low));
}

vec3 to_linear(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

// Map colours stay readable: light only models the form.
vec3 heat_shade(uint code, vec3 n, vec3 v, float key, float ambient) {
  vec3 colour = code == 65535u ? vec3(1.0, 0.0, 1.0)
                : code == 65534u ? vec3(0.32) : to_linear(heat_colour(float(code) / 65533.0));
  float toward_key = SHADOWED >= 0 ? max(dot(n, light_directions[max(SHADOWED, 0)].xyz), 0.0) * key : 1.0;
  float form = 0.62 + 0.20 * toward_key + 0.18 * max(dot(n, v), 0.0);
  return colour * form * mix(0.6, 1.0, ambient);
}

Surface surface_of(uint word) {
  uint look = (word >> 24) - 1u;
  vec3 payload = vec3((word >> 16) & 255u, (word >> 8) & 255u, word & 255u) / 255.0;
  vec4 base = look_base[look];
  vec4 layers = look_layers[look];
  vec4 scatter = look_scatter[look];
#ifdef TINTED
  base.rgb *= payload * payload;
  float line = 0.0;
#else
  float line = payload.x;
#endif
  return Surface(mix(base.rgb, vec3(0.02), 0.85 * line), base.a, layers.x, layers.y * (1.0 - line),
                 scatter.rgb * scatter.a, layers.z * (1.0 - line), layers.w);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec3 ray = ray_through(gl_FragCoord.xy);
  uvec2 surface = texelFetch(surface_map, pixel, 0).xy;
  vec3 position = eye + ray * (near_distance / texelFetch(depth_map, pixel, 0).x);
  vec3 v = -normalize(ray);
  vec3 n = from_octahedral(unpackSnorm2x16(surface.y));
  float facing = dot(n, v);
  n = facing < 0.02 ? normalize(n + v * (0.02 - facing)) : n;
  vec3 occlusion = texelFetch(occlusion_map, pixel, 0).xyz;
#ifdef SHADED
  float key = SHADOWED >= 0 ? key_visibility(position, n, occlusion.yz) : 1.0;
#else
  float key = 1.0;
#endif
  float ambient = mix(1.0, occlusion.x, occlusion_share);
#ifdef HEAT
  vec3 lit = heat_shade(surface.x & 65535u, n, v, key, ambient);
#else
  vec3 lit = shade(surface_of(surface.x), n, v, key, ambient);
#endif
  light_out = vec4(min(lit, vec3(64.0)), 1.0) * weight;
})";

const char* const SURROUND_MAIN = R"(
// The studio's light pools about the subject and fades evenly, so that the floor ends nowhere.
const float POOL_EDGE = 0.42;
float pool(vec3 position) {
  vec3 flat_place = position - world_up * dot(position, world_up);
  float distance = length(flat_place) / scene_radius;
  return mix(POOL_EDGE, 1.0, 1.0 / (1.0 + 0.035 * distance * distance));
}

// No early return: llvmpipe would carry a mask through all that follows.
void main() {
  vec3 ray = ray_through(gl_FragCoord.xy);
  float to_ground = distance_to_ground(ray);
  bool floor_seen = to_ground > 0.0;
  vec3 position = eye + ray * to_ground;
  vec3 occlusion = texelFetch(occlusion_map, ivec2(gl_FragCoord.xy), 0).xyz;
  float ambient = mix(1.0, occlusion.x, occlusion_share);
#ifdef SHADED
  float key = SHADOWED >= 0 ? key_visibility(position, world_up, occlusion.yz) : 1.0;
#else
  float key = 1.0;
#endif
  vec3 light = sky * ambient + floor_key * key + floor_others * mix(0.35, 1.0, ambient);
#ifdef CLEAR
  // Nothing but the share of light that the subject keeps from the floor, if that is asked for.
  vec3 open = sky + floor_key + floor_others;
  float kept = dot(light, vec3(0.2126, 0.7152, 0.0722)) / max(dot(open, vec3(0.2126, 0.7152, 0.0722)), 1e-6);
  light_out = vec4(vec3(0.0), floor_seen && catch_shadow != 0 ? clamp(1.0 - kept, 0.0, 1.0) : 0.0) * weight;
#else
  float rise = dot(ray, world_up) * inversesqrt(dot(ray, ray));
#ifdef ENVIRONMENT
  vec3 direction = normalize(ray);
  vec3 level = normalize(direction - world_up * (rise - 0.01));
  vec3 behind = show_around != 0 ? surroundings(direction, backdrop_level) : backdrop;
  vec3 far = show_around != 0 ? surroundings(floor_seen ? level : direction, 0.4) : backdrop;
  vec3 flat_place = position - world_up * dot(position, world_up);
  float away = smoothstep(5.0, 45.0, length(flat_place) / scene_radius);
  vec3 lit = floor_seen ? mix(ground_colour * light, far, away) : mix(far, behind, smoothstep(0.0, 0.12, rise));
  light_out = vec4(lit, 0.0) * weight;
#else
  float high = has_ground != 0 ? mix(POOL_EDGE, 0.30, smoothstep(0.0, 0.7, rise)) : 1.0;
  light_out = vec4(floor_seen ? ground_colour * light * pool(position) : backdrop * high, 0.0) * weight;
#endif
#endif
})";

const char* const CLEAR_VERTEX = R"(#version 450 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint look;
layout(location = 5) in vec3 velocity;
uniform mat4 clip_from_world;
uniform float seconds;
out vec3 place;
out vec3 corner_normal;
flat out uint look_row;
void main() {
  place = position + velocity * seconds;
  gl_Position = clip_from_world * vec4(place, 1.0);
  corner_normal = normal;
  look_row = look & 255u;
})";

const char* const CLEAR_MAIN = R"(
in vec3 place;
in vec3 corner_normal;
flat in uint look_row;
void main() {
  vec4 base = look_base[look_row];
  float clear = look_clear[look_row].x;
  vec3 v = normalize(eye - place);
  vec3 n = normalize(corner_normal);
  n = dot(n, v) < 0.0 ? -n : n;
  float nv = max(dot(n, v), 0.02);
  float away = 1.0 - nv;
  float away2 = away * away;
  float fresnel = 0.04 + 0.96 * away2 * away2 * away;
  vec3 added = fresnel * surroundings(reflect(-v, n), base.a);
  float alpha = max(base.a * base.a, 0.003);
  for (int i = 0; i < LIGHT_COUNT; ++i) {
    vec3 l = light_directions[i].xyz;
    float nl = max(dot(n, l), 0.0);
    vec3 h = normalize(l + v);
    float back = 1.0 - max(dot(v, h), 0.0);
    float f = 0.04 + 0.96 * back * back * back * back * back;
    added += light_radiances[i].rgb * f * ggx(min(alpha + 0.5 * light_directions[i].w, 1.0), nl, nv, max(dot(n, h), 0.0)) * nl;
  }
  // The longer way through a wall seen along it takes more of the light.
  float taken = mix(0.05, 0.45, away2 * away) * (2.0 - dot(base.rgb, vec3(1.0 / 3.0)));
  float opacity = clamp(max(fresnel, taken) + (1.0 - clear), 0.0, 1.0);
  vec3 body = base.rgb * matt_around(n) * (opacity - fresnel > 0.0 ? opacity - fresnel : 0.0);
  light_out = vec4(min(added + 0.5 * body, vec3(64.0)) * weight, opacity);
})";

const char* const SHADED = "#define SHADED\n";

/// Counts are constants of the program: llvmpipe runs a loop of unknown length several times slower.
std::string beginning(const RenderPlan& plan, const LightState& lights, const std::string& variant) {
  return fmt::format("#version 450 core\n#define LIGHT_COUNT {}\n#define SHADOWED {}\n#define KEY_TAPS {}\n{}{}{}",
                     lights.count, lights.shadowed, lights.key_taps, variant,
                     plan.rig.surroundings ? "#define ENVIRONMENT\n" : "",
                     plan.background == Background::clear ? "#define CLEAR\n" : "") +
         CAMERA_PART + SHADOW_SPACE_PART + DECLARATIONS + SHADOW + AROUND;
}

} // namespace

std::string subject_fragment_shader(const RenderPlan& plan, const LightState& lights, Colouring colouring, Coats coats,
                                    KeyLight key) {
  const char* variant = colouring == Colouring::heat   ? "#define HEAT\n"
                        : colouring != Colouring::look ? ""
                        : coats == Coats::some         ? "#define TINTED\n#define COATED\n"
                                                       : "#define TINTED\n";
  return beginning(plan, lights, variant + std::string(key == KeyLight::shaded ? SHADED : "")) + MATERIAL +
         SUBJECT_MAIN;
}

std::string clear_vertex_shader() {
  return CLEAR_VERTEX;
}

std::string clear_fragment_shader(const RenderPlan& plan, const LightState& lights) {
  return beginning(plan, lights, "") + MATERIAL + CLEAR_MAIN;
}

std::string surround_fragment_shader(const RenderPlan& plan, const LightState& lights, KeyLight key) {
  return beginning(plan, lights, key == KeyLight::shaded ? SHADED : "") + SURROUND_MAIN;
}

} // namespace wry::render
