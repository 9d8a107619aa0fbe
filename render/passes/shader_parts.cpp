#include "render/passes/shader_parts.h"

namespace wry::render {

const char* const CAMERA_PART = R"(
uniform vec3 eye;
uniform vec3 ray_centre; // view axis: a point at distance z is eye + z * ray
uniform vec3 ray_right;
uniform vec3 ray_up;
uniform vec3 ray_corner; // of the picture, at its lower left
uniform vec3 ray_x;      // from pixel to pixel
uniform vec3 ray_y;
uniform vec2 jitter;
uniform vec2 size;
uniform float near_distance;
uniform vec3 world_up;
uniform float scene_radius;
uniform int has_ground;
uniform float ground_height;

const float PI = 3.14159265;

// The ray through a place of the picture, in pixels of a target of `size`.
vec3 ray_through(vec2 place) { return ray_corner + ray_x * place.x + ray_y * place.y; }

// How far along a ray the ground is; not positive where there is none.
float distance_to_ground(vec3 ray) {
  float down = -dot(ray, world_up);
  return has_ground == 0 ? -1.0 : (dot(eye, world_up) - ground_height) / (abs(down) < 1e-6 ? 1e-6 : down);
}

vec3 from_octahedral(vec2 e) {
  vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
  float fold = max(-n.z, 0.0);
  n.xy += vec2(n.x >= 0.0 ? -fold : fold, n.y >= 0.0 ? -fold : fold);
  return normalize(n);
}

// Interleaved gradient noise (Jimenez 2014).
float gradient_noise(vec2 p) { return fract(52.9829189 * fract(dot(p, vec2(0.06711056, 0.00583715)))); }
)";

const char* const SHADOW_SPACE_PART = R"(
uniform mat4 light_from_world;
uniform mat4 clip_from_world_shadow;
uniform float shadow_extent;  // side of the map [m]
uniform float shadow_depth;   // reach of the map [m]
uniform float shadow_spread;  // tangent of the light's angular radius
uniform float shadow_texel;   // [m]

// Place in the map (xy in [0, 1]) and depth, lifted off the surface against self-shadowing.
vec3 shadow_place(vec3 position, vec3 normal) {
  float facing = dot(vec3(light_from_world[0][2], light_from_world[1][2], light_from_world[2][2]), normal);
  float grazing = sqrt(max(1.0 - facing * facing, 0.0));
  vec3 lifted = position + normal * (shadow_texel * (0.6 + 1.6 * grazing));
  vec3 place = (clip_from_world_shadow * vec4(lifted, 1.0)).xyz;
  // What lies behind everything that casts must still be nearer than an empty map.
  return vec3(place.xy * 0.5 + 0.5, min(place.z, 0.9999));
}

// Change of depth per unit of the map's xy along the plane of the receiver.
vec2 shadow_slope(vec3 normal) {
  vec3 n = mat3(light_from_world) * normal;
  return clamp(n.xy / max(n.z, 0.05), -4.0, 4.0) * (shadow_extent / shadow_depth);
}
)";

void set_camera_part(const Program& program, const SubFrame& sub_frame, const RenderPlan& plan, const ImageSize& size) {
  const Camera& camera = sub_frame.camera;
  const auto vector = [](const Vec3& v) { return Eigen::Vector3f(v.cast<float>()); };
  program.set("eye", vector(camera.eye));
  program.set("ray_centre", vector(-camera.axes.col(2)));
  const Vec3 right = camera.axes.col(0) * camera.tan_half_width;
  const Vec3 up = camera.axes.col(1) * camera.tan_half_height;
  program.set("ray_right", vector(right));
  program.set("ray_up", vector(up));
  program.set("ray_corner",
              vector(-camera.axes.col(2) - right * (1.0 + sub_frame.jitter.x()) - up * (1.0 + sub_frame.jitter.y())));
  program.set("ray_x", vector(right * (2.0 / size.width)));
  program.set("ray_y", vector(up * (2.0 / size.height)));
  program.set("jitter", sub_frame.jitter);
  program.set("size", Eigen::Vector2f(static_cast<float>(size.width), static_cast<float>(size.height)));
  program.set("near_distance", static_cast<float>(camera.near_distance));
  program.set("world_up", vector(plan.up));
  program.set("scene_radius", sub_frame.scene_radius);
  program.set("has_ground", plan.ground.kind != Ground::Kind::none ? 1 : 0);
  program.set("ground_height", sub_frame.ground_height);
}

void set_shadow_space_part(const Program& program, const LightState& lights) {
  program.set("light_from_world", lights.light_from_world);
  program.set("clip_from_world_shadow", lights.clip_from_world_shadow);
  program.set("shadow_extent", lights.shadow_extent);
  program.set("shadow_depth", lights.shadow_depth);
  program.set("shadow_spread", lights.shadow_spread);
  program.set("shadow_texel", lights.shadow_extent / static_cast<float>(SHADOW_MAP_SIZE));
}

} // namespace wry::render
