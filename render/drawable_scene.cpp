#include "render/drawable_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include <Eigen/Geometry>

#include "render/heat_values.h"

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

} // namespace

Result<DrawableScene> DrawableScene::create(const RenderPlan& plan, const SceneStatic& scene) {
  DrawableScene drawable;
  drawable.m_scene = scene;
  drawable.m_origin = plan.bounds.empty() ? Vec3(Vec3::Zero()) : plan.bounds.centre();
  drawable.m_looks.push_back(built_in_looks().at("clay"));
  drawable.m_looks.push_back(plan.default_look);
  std::map<std::string, std::uint32_t> row_of;
  for (const auto& [name, look] : plan.looks) {
    row_of[name] = static_cast<std::uint32_t>(drawable.m_looks.size());
    drawable.m_looks.push_back(look);
  }
  for (const SceneBody& body : scene.bodies) {
    if (const Status good = check_triangles(body); !good.ok())
      return good.error();
    Body made;
    made.surface = split_at_creases(body.rest_positions, body.triangles, CREASE_DEGREES);
    made.tet_of_triangle = tets_of_triangles(body, made.surface);
    const auto found = row_of.find(body.look);
    made.look = found != row_of.end() ? found->second : 1U;
    drawable.m_triangle_count += made.surface.triangles.rows();
    drawable.m_bodies.push_back(std::move(made));
  }
  if (drawable.m_triangle_count == 0)
    return make_error(ErrorCode::bad_input, "there is nothing to draw: none of the {} bodies has a triangle",
                      scene.bodies.size());
  return drawable;
}

Status DrawableScene::append_body(const Frame& frame, std::size_t index, const View& view, DrawList& list) const {
  const SceneBody& body = m_scene.bodies[index];
  const SplitSurface& surface = m_bodies[index].surface;
  if (surface.triangles.rows() == 0)
    return {};
  const Result<Points> positions = world_positions(body, frame.bodies[index], frame.number);
  if (!positions.ok())
    return positions.error();
  HeatValues heat;
  if (view.colouring == Colouring::heat) {
    Result<HeatValues> values = heat_values(*view.heat, body, frame.bodies[index]);
    if (!values.ok())
      return values.error();
    heat = std::move(*values);
  }
  const Points normals = smooth_normals(surface, *positions);
  const std::uint32_t look = view.colouring == Colouring::look ? m_bodies[index].look : 0U;
  const auto vertex = [&](std::int32_t split) {
    const std::int32_t original = surface.original[static_cast<std::size_t>(split)];
    const Eigen::Vector3f x = (positions->row(original).transpose() - m_origin).cast<float>();
    const Eigen::Vector3f n = normals.row(split).transpose().cast<float>();
    DrawVertex made{{x.x(), x.y(), x.z()}, {n.x(), n.y(), n.z()}, look, HEAT_ABSENT};
    if (heat.on == ChannelOn::vertex && !heat.rows.empty())
      made.value = heat.rows[static_cast<std::size_t>(original)];
    return made;
  };
  if (list.indices.empty() && (view.wire == Wire::overlay || view.colouring == Colouring::heat)) {
    for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
      const std::int32_t tet =
          m_bodies[index].tet_of_triangle.empty() ? -1 : m_bodies[index].tet_of_triangle[static_cast<std::size_t>(t)];
      for (int c = 0; c < 3; ++c) {
        list.vertices.push_back(vertex(surface.triangles(t, c)));
        if (heat.on == ChannelOn::tet && !heat.rows.empty() && tet >= 0)
          list.vertices.back().value = heat.rows[static_cast<std::size_t>(tet)];
      }
    }
    return {};
  }
  const std::uint32_t base = static_cast<std::uint32_t>(list.vertices.size());
  for (std::size_t split = 0; split < surface.original.size(); ++split)
    list.vertices.push_back(vertex(static_cast<std::int32_t>(split)));
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c)
      list.indices.push_back(base + static_cast<std::uint32_t>(surface.triangles(t, c)));
  }
  return {};
}

Result<DrawList> DrawableScene::list(const Frame& frame, const View& view) const {
  if (const Status good = check_frame(frame); !good.ok())
    return good.error();
  if (view.colouring == Colouring::heat) {
    const auto has = [&](const FrameBody& body) { return find_channel(body, view.heat->channel) != nullptr; };
    if (std::none_of(frame.bodies.begin(), frame.bodies.end(), has))
      return make_error(ErrorCode::bad_input, "view {}: no body of frame {} has a channel {}", view.name, frame.number,
                        view.heat->channel);
  }
  DrawList made;
  for (std::size_t b = 0; b < m_bodies.size(); ++b) {
    if (const Status good = append_body(frame, b, view, made); !good.ok())
      return good.error();
  }
  return made;
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
    if (body.triangles.rows() == 0)
      continue;
    const Result<Points> positions = world_positions(body, frame.bodies[b], frame.number);
    if (!positions.ok())
      return positions.error();
    SubjectBounds around;
    around.include(*positions);
    if (around.box().contains(point) && winding_number(*positions, body.triangles, point) > 0.5)
      return make_error(
          ErrorCode::bad_input,
          "frame {}: the camera at ({:.4g}, {:.4g}, {:.4g}) m is inside body {}; move it out or let it be "
          "framed by itself",
          frame.number, point.x(), point.y(), point.z(), body.name);
  }
  return {};
}

} // namespace wry::render
