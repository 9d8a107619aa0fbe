#include "render/drawable_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include <Eigen/Geometry>

#include "render/outward.h"

namespace wry::render {
namespace {

constexpr double CREASE_DEGREES = 50.0;

struct TetFace {
  std::array<std::int32_t, 3> key; ///< sorted
  std::int32_t tet;
  bool operator<(const TetFace& other) const { return std::tie(key, tet) < std::tie(other.key, other.tet); }
};

std::array<std::int32_t, 3> sorted_key(std::int32_t a, std::int32_t b, std::int32_t c) {
  std::array<std::int32_t, 3> key = {a, b, c};
  std::sort(key.begin(), key.end());
  return key;
}

/// Per drawn triangle, the tet it is a face of, or -1.
std::vector<std::int32_t> tets_of_triangles(const SceneBody& body, const SplitSurface& surface) {
  if (body.tets.rows() == 0)
    return {};
  std::vector<TetFace> faces;
  faces.reserve(static_cast<std::size_t>(body.tets.rows()) * 4);
  for (std::int32_t t = 0; t < body.tets.rows(); ++t) {
    for (int skip = 0; skip < 4; ++skip)
      faces.push_back(
          {sorted_key(body.tets(t, (skip + 1) % 4), body.tets(t, (skip + 2) % 4), body.tets(t, (skip + 3) % 4)), t});
  }
  std::sort(faces.begin(), faces.end());
  std::vector<std::int32_t> tets(static_cast<std::size_t>(surface.triangles.rows()), -1);
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const auto original = [&](int c) { return surface.original[static_cast<std::size_t>(surface.triangles(t, c))]; };
    const TetFace wanted = {sorted_key(original(0), original(1), original(2)), -1};
    const auto found = std::lower_bound(faces.begin(), faces.end(), wanted);
    if (found != faces.end() && found->key == wanted.key)
      tets[static_cast<std::size_t>(t)] = found->tet;
  }
  return tets;
}

Status check_triangles(const SceneBody& body) {
  const Eigen::Index count = body.rest_positions.rows();
  for (Eigen::Index t = 0; t < body.triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c) {
      if (body.triangles(t, c) < 0 || body.triangles(t, c) >= count)
        return make_error(ErrorCode::bad_input, "body {}: triangle {} names vertex {}, but there are {}", body.name, t,
                          body.triangles(t, c), count);
    }
  }
  return {};
}

/// Winding number of a closed surface about a point: 1 inside, 0 outside (van Oosterom and Strackee 1983).
double winding_number(const Points& x, const Triangles& triangles, const Vec3& point) {
  double solid_angle = 0.0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const Vec3 a = x.row(triangles(t, 0)).transpose() - point;
    const Vec3 b = x.row(triangles(t, 1)).transpose() - point;
    const Vec3 c = x.row(triangles(t, 2)).transpose() - point;
    const double la = a.norm();
    const double lb = b.norm();
    const double lc = c.norm();
    solid_angle += 2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return solid_angle / (4.0 * std::numbers::pi);
}

Look sign_look() {
  Look look;
  look.base_colour = Eigen::Vector3f::Ones();
  look.roughness = 0.6f;
  look.specular = 0.3f;
  return look;
}

/// Facets a few pixels wide glitter as they turn; as rough as this they do not.
float calm_roughness(float roughness, double pixels) {
  constexpr float CALM = 0.62f;
  const float part = static_cast<float>(std::clamp(pixels / 8.0, 0.0, 1.0));
  return std::max(roughness, CALM + part * (roughness - CALM));
}

/// Rows of the look table for the materials of an artist's file: they differ in gloss only, colours travel as tints.
std::vector<std::uint32_t> rows_of_materials(const MeshAppearance& appearance, std::vector<Look>& looks) {
  constexpr std::size_t ROWS_MAX = 63;
  std::map<std::pair<int, int>, std::uint32_t> made;
  std::vector<std::uint32_t> rows;
  for (const ArtistMaterial& material : appearance.materials) {
    const std::pair key(static_cast<int>(std::lround(material.roughness * 10.f)),
                        static_cast<int>(std::lround(material.metallic * 4.f)));
    auto found = made.find(key);
    if (found == made.end() && looks.size() < ROWS_MAX) {
      Look look;
      look.base_colour = Eigen::Vector3f::Ones();
      look.roughness = std::clamp(static_cast<float>(key.first) / 10.f, 0.08f, 1.f);
      look.metallic = std::clamp(static_cast<float>(key.second) / 4.f, 0.f, 1.f);
      found = made.emplace(key, static_cast<std::uint32_t>(looks.size())).first;
      looks.push_back(look);
    }
    rows.push_back(found != made.end() ? found->second : static_cast<std::uint32_t>(looks.size() - 1));
  }
  return rows;
}

} // namespace

Points DrawableScene::drawn_rest(const SceneBody& body) {
  if (body.kind == BodyKind::particles)
    return body.rest_positions * body.grain.size.asDiagonal();
  return body.rest_positions;
}

Status DrawableScene::add_body(const RenderPlan& plan, const SceneBody& body, std::uint32_t look) {
  if (const Status good = check_triangles(body); !good.ok())
    return good.error();
  Body made;
  made.look = look;
  if (body.kind == BodyKind::particles) {
    if (!(body.grain.size.minCoeff() > 0.0) || !body.grain.size.allFinite())
      return make_error(ErrorCode::bad_input, "body {}: grains of {} x {} x {} m: each side must be above 0", body.name,
                        body.grain.size.x(), body.grain.size.y(), body.grain.size.z());
    if (m_looks.size() >= LOOKS_MAX)
      return make_error(ErrorCode::bad_input, "body {}: there are too many looks; at most {}", body.name, LOOKS_MAX);
    Look own = m_looks[look];
    own.base_colour *= brightest_variation(own);
    own.roughness = calm_roughness(own.roughness, body.grain.size.minCoeff() / m_pixel);
    own.clearcoat_roughness = calm_roughness(own.clearcoat_roughness, body.grain.size.minCoeff() / m_pixel);
    made.grain_look = static_cast<std::uint32_t>(m_looks.size());
    m_looks.push_back(own);
    m_has_clouds = true;
  }
  if (body.triangles.rows() > 0)
    made.surface = split_at_creases(drawn_rest(body), body.triangles, CREASE_DEGREES);
  if (body.kind == BodyKind::surface) {
    made.tet_of_triangle = tets_of_triangles(body, made.surface);
    made.closed_outward = is_closed_outward(body);
    m_triangle_count += made.surface.triangles.rows();
  }
  if (const auto found = plan.appearances.find(body.name); found != plan.appearances.end()) {
    // Every triangle has corners of its own, and the split dropped those without an area: they are found by order.
    const MeshAppearance& appearance = *found->second;
    if (appearance.material_of_triangle.size() != static_cast<std::size_t>(body.triangles.rows()))
      return make_error(ErrorCode::bad_input, "body {}: materials for {} triangles, but it has {}", body.name,
                        appearance.material_of_triangle.size(), body.triangles.rows());
    made.appearance = found->second;
    made.material_rows = rows_of_materials(appearance, m_looks);
    made.first_texture = m_textures.size();
    m_textures.insert(m_textures.end(), appearance.textures.begin(), appearance.textures.end());
  }
  m_bodies.push_back(std::move(made));
  return {};
}

Result<DrawableScene> DrawableScene::create(const RenderPlan& plan, const SceneStatic& scene) {
  DrawableScene drawable;
  drawable.m_scene = scene;
  drawable.m_origin = plan.bounds.empty() ? Vec3(Vec3::Zero()) : plan.bounds.centre();
  if (plan.ground.kind != Ground::Kind::none && !plan.bounds.empty()) {
    double lowest = std::numeric_limits<double>::infinity();
    for (int corner = 0; corner < 8; ++corner)
      lowest =
          std::min(lowest, plan.up.dot(plan.bounds.box().corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner))));
    drawable.m_floor = Floor{plan.up.cast<float>(),
                             static_cast<float>(plan.ground.height.value_or(lowest) - plan.up.dot(drawable.m_origin))};
  }
  drawable.m_radius = plan.bounds.empty() ? 1.0 : plan.bounds.radius();
  drawable.m_blurred = (plan.shutter > 0.0 && plan.samples > 1) || plan.data == DataWanted::yes;
  if (const Result<Camera> camera = frame_camera(plan.camera, plan.up, plan.bounds, plan.size, plan.framing, 0.0);
      camera.ok())
    drawable.m_pixel = std::max(1e-12, -camera->axes.col(2).dot(drawable.m_origin - camera->eye)) * 2.0 *
                       camera->tan_half_width / plan.size.width;
  drawable.m_looks.push_back(built_in_looks().at("clay"));
  drawable.m_looks.push_back(plan.default_look);
  drawable.m_looks.push_back(sign_look());
  std::map<std::string, std::uint32_t> row_of;
  for (const SceneBody& body : scene.bodies) {
    // Only the looks that are used: the table is short.
    const auto found = plan.looks.find(body.look);
    if (found == plan.looks.end() || row_of.count(body.look) != 0)
      continue;
    row_of[body.look] = static_cast<std::uint32_t>(drawable.m_looks.size());
    drawable.m_looks.push_back(found->second);
    if (drawable.m_looks.size() > LOOKS_MAX)
      return make_error(ErrorCode::bad_input, "the bodies use more than {} looks", LOOKS_MAX);
  }
  for (const SceneBody& body : scene.bodies) {
    const auto found = row_of.find(body.look);
    if (const Status added = drawable.add_body(plan, body, found != row_of.end() ? found->second : 1U); !added.ok())
      return added.error();
  }
  if (drawable.m_triangle_count == 0 && !drawable.m_has_clouds)
    return make_error(ErrorCode::bad_input, "there is nothing to draw: none of the {} bodies has a triangle",
                      scene.bodies.size());
  return drawable;
}

Status DrawableScene::check_frame(const Frame& frame) const {
  if (frame.bodies.size() == m_scene.bodies.size())
    return {};
  return make_error(ErrorCode::bad_input, "frame {} has {} bodies, the scene {}: they are not of the same run",
                    frame.number, frame.bodies.size(), m_scene.bodies.size());
}

Status DrawableScene::check_outside(const Frame& frame, const Vec3& point) const {
  if (const Status good = check_frame(frame); !good.ok())
    return good;
  for (std::size_t b = 0; b < m_bodies.size(); ++b) {
    const SceneBody& body = m_scene.bodies[b];
    if (body.triangles.rows() == 0 || body.kind == BodyKind::particles)
      continue;
    const Result<Points> positions = world_positions(body, frame.bodies[b], frame.number);
    if (!positions.ok())
      return positions.error();
    const Eigen::AlignedBox3d around(positions->colwise().minCoeff().transpose(),
                                     positions->colwise().maxCoeff().transpose());
    if (around.contains(point) && winding_number(*positions, body.triangles, point) > 0.5)
      return make_error(
          ErrorCode::bad_input,
          "frame {}: the camera at ({:.4g}, {:.4g}, {:.4g}) m is inside body {}; move it out or let it be "
          "framed by itself",
          frame.number, point.x(), point.y(), point.z(), body.name);
  }
  return {};
}

} // namespace wry::render
