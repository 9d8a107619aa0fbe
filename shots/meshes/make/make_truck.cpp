// Writes the dump truck: truck_bed.obj, truck_body.obj and truck_trim.obj (z up, metres, where the bed stands at rest)
// and truck.gltf (y up, as glTF wants it) whose node `bed` tips on its hinge. Usage: make_truck FOLDER

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "sim/base/types.h"

namespace {

using wry::Vec3;

/// Closed parts that do not touch each other.
struct Parts {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;

  int add(const Vec3& point) {
    points.push_back(point);
    return static_cast<int>(points.size()) - 1;
  }
  /// A convex polygon, counter-clockwise seen from outside.
  void face(const std::vector<int>& corners) {
    for (std::size_t i = 2; i < corners.size(); ++i)
      triangles.push_back({corners[0], corners[i - 1], corners[i]});
  }
};

/// A convex outline in (y, z), counter-clockwise seen from +x, pulled along x, its rims bevelled.
void prism(Parts& parts, const std::vector<std::array<double, 2>>& outline, double x0, double x1, double bevel) {
  const std::size_t n = outline.size();
  double cy = 0.0, cz = 0.0;
  for (const auto& p : outline) {
    cy += p[0] / static_cast<double>(n);
    cz += p[1] / static_cast<double>(n);
  }
  std::array<std::vector<int>, 4> rings;
  const std::array<double, 4> xs = {x0, x0 + bevel, x1 - bevel, x1};
  for (std::size_t ring = 0; ring < 4; ++ring) {
    for (const auto& p : outline) {
      const double away = std::hypot(p[0] - cy, p[1] - cz);
      const double shrink = ring == 0 || ring == 3 ? 1.0 - bevel / away : 1.0;
      rings[ring].push_back(parts.add({xs[ring], cy + shrink * (p[0] - cy), cz + shrink * (p[1] - cz)}));
    }
  }
  for (std::size_t ring = 0; ring < 3; ++ring) {
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t j = (i + 1) % n;
      parts.face({rings[ring][i], rings[ring][j], rings[ring + 1][j], rings[ring + 1][i]});
    }
  }
  parts.face(rings[3]);
  parts.face(std::vector<int>(rings[0].rbegin(), rings[0].rend()));
}

void box(Parts& parts, const Vec3& low, const Vec3& high, double bevel = 0.003) {
  prism(parts, {{low[1], low[2]}, {high[1], low[2]}, {high[1], high[2]}, {low[1], high[2]}}, low[0], high[0], bevel);
}

/// A round prism with its axis along x.
void wheel(Parts& parts, double x0, double x1, double y, double z, double radius, double bevel) {
  constexpr int SEGMENTS = 36;
  std::vector<std::array<double, 2>> outline;
  for (int i = 0; i < SEGMENTS; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / SEGMENTS;
    outline.push_back({y + radius * std::cos(angle), z + radius * std::sin(angle)});
  }
  prism(parts, outline, x0, x1, bevel);
}

constexpr double FLOOR = 0.1, RADIUS = 0.041; ///< of the wheels, which stay below the bed
const Vec3 HINGE(0.5, 0.65, 0.2);

/// Inside x .3-.7, y .05-.65, z .2-.4 m; open at the top and at the back; walls 15 mm.
Parts make_bed() {
  constexpr double WALL = 0.015;
  const Vec3 inner_low(0.3, 0.05, 0.2), high(0.7, 0.65, 0.4);
  const std::array<double, 2> xi = {inner_low[0], high[0]}, xo = {inner_low[0] - WALL, high[0] + WALL};
  const std::array<double, 2> yi = {inner_low[1], high[1]}, yo = {inner_low[1] - WALL, high[1]};
  const std::array<double, 2> zi = {inner_low[2], high[2]}, zo = {inner_low[2] - WALL, high[2]};
  Parts parts;
  const auto corner = [](int x, int y, int z) { return 4 * x + 2 * y + z; };
  for (int i = 0; i < 8; ++i)
    parts.add({xo[static_cast<std::size_t>(i / 4)], yo[static_cast<std::size_t>(i / 2 % 2)],
               zo[static_cast<std::size_t>(i % 2)]});
  for (int i = 0; i < 8; ++i)
    parts.add({xi[static_cast<std::size_t>(i / 4)], yi[static_cast<std::size_t>(i / 2 % 2)],
               zi[static_cast<std::size_t>(i % 2)]});
  const auto o = corner;
  const auto in = [&corner](int x, int y, int z) { return 8 + corner(x, y, z); };
  parts.face({o(0, 0, 0), o(0, 1, 0), o(1, 1, 0), o(1, 0, 0)});     // below
  parts.face({o(0, 0, 0), o(0, 0, 1), o(0, 1, 1), o(0, 1, 0)});     // left
  parts.face({o(1, 0, 0), o(1, 1, 0), o(1, 1, 1), o(1, 0, 1)});     // right
  parts.face({o(0, 0, 0), o(1, 0, 0), o(1, 0, 1), o(0, 0, 1)});     // front
  parts.face({in(0, 0, 0), in(1, 0, 0), in(1, 1, 0), in(0, 1, 0)}); // floor
  parts.face({in(0, 0, 0), in(0, 1, 0), in(0, 1, 1), in(0, 0, 1)});
  parts.face({in(1, 0, 0), in(1, 0, 1), in(1, 1, 1), in(1, 1, 0)});
  parts.face({in(0, 0, 0), in(0, 0, 1), in(1, 0, 1), in(1, 0, 0)});
  parts.face({o(0, 0, 1), in(0, 0, 1), in(0, 1, 1), o(0, 1, 1)}); // the rim above
  parts.face({o(1, 0, 1), o(1, 1, 1), in(1, 1, 1), in(1, 0, 1)});
  parts.face({o(0, 0, 1), o(1, 0, 1), in(1, 0, 1), in(0, 0, 1)});
  parts.face({o(0, 1, 0), o(0, 1, 1), in(0, 1, 1), in(0, 1, 0)}); // the rim behind
  parts.face({o(1, 1, 0), in(1, 1, 0), in(1, 1, 1), o(1, 1, 1)});
  parts.face({o(0, 1, 0), in(0, 1, 0), in(1, 1, 0), o(1, 1, 0)});
  constexpr double GAP = 5e-4, RIB = 0.012;
  for (const double y : {0.06, 0.2, 0.34, 0.48, 0.62}) { // ribs on the sides
    box(parts, {xo[0] - GAP - RIB, y - 0.01, 0.19}, {xo[0] - GAP, y + 0.01, 0.385});
    box(parts, {xo[1] + GAP, y - 0.01, 0.19}, {xo[1] + GAP + RIB, y + 0.01, 0.385});
  }
  for (const double x : {0.35, 0.5, 0.65})
    box(parts, {x - 0.01, yo[0] - GAP - RIB, 0.19}, {x + 0.01, yo[0] - GAP, 0.385});
  return parts;
}

/// Cab and chassis.
Parts make_body() {
  Parts parts;
  box(parts, {0.37, -0.30, 0.135}, {0.42, 0.61, 0.178}); // two beams
  box(parts, {0.58, -0.30, 0.135}, {0.63, 0.61, 0.178});
  for (const double y : {-0.02, 0.25, 0.56})
    box(parts, {0.4205, y - 0.015, 0.14}, {0.5795, y + 0.015, 0.17});
  prism(parts, {{-0.225, 0.185}, {-0.03, 0.185}, {-0.03, 0.43}, {-0.165, 0.43}, {-0.225, 0.315}}, 0.33, 0.67, 0.012);
  prism(parts, {{-0.34, 0.185}, {-0.226, 0.185}, {-0.226, 0.305}, {-0.33, 0.292}}, 0.34, 0.66, 0.012); // bonnet
  box(parts, {0.31, -0.375, 0.135}, {0.69, -0.3455, 0.185}, 0.006);                                    // bumper
  box(parts, {0.34, -0.0285, 0.185}, {0.355, -0.0135, 0.5}, 0.003);                                    // exhausts
  box(parts, {0.645, -0.0285, 0.185}, {0.66, -0.0135, 0.5}, 0.003);
  for (const double y : {-0.24, 0.36, 0.51}) { // hubs
    wheel(parts, 0.2965, 0.3045, y, FLOOR + RADIUS, 0.5 * RADIUS, 0.003);
    wheel(parts, 0.6955, 0.7035, y, FLOOR + RADIUS, 0.5 * RADIUS, 0.003);
  }
  return parts;
}

/// What is dark: tyres, windows, lamps and grille.
Parts make_trim() {
  Parts parts;
  for (const double y : {-0.24, 0.36, 0.51}) {
    wheel(parts, 0.305, 0.3595, y, FLOOR + RADIUS, RADIUS, 0.008);
    wheel(parts, 0.6405, 0.695, y, FLOOR + RADIUS, RADIUS, 0.008);
  }
  box(parts, {0.36, -0.3455, 0.2}, {0.42, -0.3415, 0.24}, 0.001);
  box(parts, {0.58, -0.3455, 0.2}, {0.64, -0.3415, 0.24}, 0.001);
  box(parts, {0.435, -0.3455, 0.2}, {0.565, -0.3415, 0.27}, 0.001);
  // Windscreen, parallel to the slope of the cab, and side windows.
  prism(parts, {{-0.2215, 0.336}, {-0.1765, 0.4225}, {-0.1795, 0.4235}, {-0.2245, 0.337}}, 0.36, 0.64, 0.001);
  for (const double x : {0.3255, 0.6705})
    prism(parts, {{-0.195, 0.325}, {-0.06, 0.325}, {-0.06, 0.41}, {-0.158, 0.41}}, x, x + 0.004, 0.001);
  return parts;
}

bool write_obj(const Parts& parts, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  file << "# A dump truck of our own: shots/meshes/make/make_truck.cpp. Apache-2.0. Metres, z up.\n";
  for (const Vec3& p : parts.points)
    file << fmt::format("v {:.5f} {:.5f} {:.5f}\n", p[0], p[1], p[2]);
  for (const auto& t : parts.triangles)
    file << fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  file.close();
  return !file.fail();
}

/// z up -> y up.
Vec3 to_gltf(const Vec3& p) {
  return {p[0], p[2], -p[1]};
}

/// A glTF file with its buffer inside.
class Gltf {
public:
  template <class T>
  int add(const std::vector<T>& values, int count, const char* type, int component, std::string more) {
    const std::size_t bytes = values.size() * sizeof(T), start = m_buffer.size();
    m_buffer.resize(start + bytes);
    std::memcpy(m_buffer.data() + start, values.data(), bytes);
    const std::size_t n = m_accessors.size();
    m_views.push_back(fmt::format(R"({{"buffer":0,"byteOffset":{},"byteLength":{}}})", start, bytes));
    m_accessors.push_back(fmt::format(R"({{"bufferView":{},"componentType":{},"count":{},"type":"{}"{}}})", n,
                                      component, count, type, more));
    return static_cast<int>(n);
  }
  std::string mesh(const Parts& parts, const Vec3& origin, const char* name) {
    std::vector<float> positions;
    Vec3 low = Vec3::Constant(1e9), high = -low;
    for (const Vec3& p : parts.points) {
      const Vec3 q = to_gltf(p - origin);
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
      for (int k = 0; k < 3; ++k)
        positions.push_back(static_cast<float>(q[k]));
    }
    std::vector<std::uint32_t> indices;
    for (const auto& t : parts.triangles)
      indices.insert(indices.end(), {static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]),
                                     static_cast<std::uint32_t>(t[2])});
    const std::string bounds =
        fmt::format(R"(,"min":[{},{},{}],"max":[{},{},{}])", static_cast<float>(low[0]), static_cast<float>(low[1]),
                    static_cast<float>(low[2]), static_cast<float>(high[0]), static_cast<float>(high[1]),
                    static_cast<float>(high[2]));
    constexpr int FLOAT = 5126, UNSIGNED = 5125;
    const int position = add(positions, static_cast<int>(parts.points.size()), "VEC3", FLOAT, bounds);
    const int index = add(indices, static_cast<int>(indices.size()), "SCALAR", UNSIGNED, "");
    return fmt::format(R"({{"name":"{}","primitives":[{{"attributes":{{"POSITION":{}}},"indices":{}}}]}})", name,
                       position, index);
  }
  std::string buffer_json() const {
    constexpr const char* DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < m_buffer.size(); i += 3) {
      const auto byte = [this, i](std::size_t k) { return i + k < m_buffer.size() ? m_buffer[i + k] : 0u; };
      const unsigned word = byte(0) << 16 | byte(1) << 8 | byte(2);
      for (unsigned k = 0; k < 4; ++k)
        text += i + k <= m_buffer.size() ? DIGITS[word >> (18 - 6 * k) & 63u] : '=';
    }
    return fmt::format(R"([{{"byteLength":{},"uri":"data:application/octet-stream;base64,{}"}}])", m_buffer.size(),
                       text);
  }
  std::string views_json() const { return "[" + joined(m_views) + "]"; }
  std::string accessors_json() const { return "[" + joined(m_accessors) + "]"; }

private:
  static std::string joined(const std::vector<std::string>& list) {
    std::string text;
    for (const std::string& item : list)
      text += (text.empty() ? "" : ",") + item;
    return text;
  }
  std::vector<unsigned char> m_buffer;
  std::vector<std::string> m_views, m_accessors;
};

/// Still until .2 s, tipped by 43 degrees at .7 s, eased in and out.
bool write_gltf(const Parts& bed, const Parts& body, const Parts& trim, const std::string& path) {
  Gltf gltf;
  const std::string body_mesh = gltf.mesh(body, Vec3::Zero(), "body");
  const std::string bed_mesh = gltf.mesh(bed, HINGE, "bed");
  const std::string trim_mesh = gltf.mesh(trim, Vec3::Zero(), "trim");
  std::vector<float> times, rotations;
  constexpr int KEYS = 21;
  for (int i = 0; i < KEYS; ++i) {
    const double s = static_cast<double>(i) / (KEYS - 1), eased = s * s * (3.0 - 2.0 * s);
    const double half = -0.5 * eased * 43.0 * std::numbers::pi / 180.0;
    times.push_back(static_cast<float>(0.2 + 0.5 * s));
    rotations.insert(rotations.end(),
                     {static_cast<float>(std::sin(half)), 0.0F, 0.0F, static_cast<float>(std::cos(half))});
  }
  constexpr int FLOAT = 5126;
  const int time = gltf.add(times, KEYS, "SCALAR", FLOAT, R"(,"min":[0.2],"max":[0.7])");
  const int rotation = gltf.add(rotations, KEYS, "VEC4", FLOAT, "");
  const Vec3 hinge = to_gltf(HINGE);
  std::ofstream file(path, std::ios::binary);
  file
      << R"({"asset":{"version":"2.0","generator":"shots/meshes/make/make_truck.cpp","copyright":"Apache-2.0"},)"
      << R"("scene":0,"scenes":[{"nodes":[0,1,2]}],)"
      << fmt::format(
             R"("nodes":[{{"name":"body","mesh":0}},{{"name":"bed","mesh":1,"translation":[{},{},{}]}},{{"name":"trim","mesh":2}}],)",
             hinge[0], hinge[1], hinge[2])
      << fmt::format(R"("meshes":[{},{},{}],)", body_mesh, bed_mesh, trim_mesh)
      << fmt::format(R"("animations":[{{"name":"tip","samplers":[{{"input":{},"output":{},"interpolation":"LINEAR"}}],)"
                     R"("channels":[{{"sampler":0,"target":{{"node":1,"path":"rotation"}}}}]}}],)",
                     time, rotation)
      << "\"bufferViews\":" << gltf.views_json() << ",\"accessors\":" << gltf.accessors_json()
      << ",\"buffers\":" << gltf.buffer_json() << "}\n";
  file.close();
  return !file.fail();
}

} // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: make_truck FOLDER\n");
    return 2;
  }
  const std::string folder = arguments[1];
  const Parts bed = make_bed(), body = make_body(), trim = make_trim();
  if (!write_obj(trim, folder + "/truck_trim.obj") || !write_obj(bed, folder + "/truck_bed.obj") ||
      !write_obj(body, folder + "/truck_body.obj") || !write_gltf(bed, body, trim, folder + "/truck.gltf")) {
    std::fprintf(stderr, "cannot write to %s\n", folder.c_str());
    return 73;
  }
  fmt::print("bed {} triangles, body {} triangles\n", bed.triangles.size(), body.triangles.size());
  return 0;
}
