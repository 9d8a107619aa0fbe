#include "render/drawable_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <tuple>

#include <Eigen/Geometry>

#include "render/grain_shapes.h"
#include "render/heat_values.h"
#include "render/outward.h"
#include "render/signs.h"

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

/// Row of the look table of whatever signs are drawn with.
constexpr std::uint32_t SIGN_ROW = 2;

Look sign_look() {
  Look look;
  look.base_colour = Eigen::Vector3f::Ones();
  look.roughness = 0.6f;
  look.specular = 0.3f;
  return look;
}

bool wears_looks(const View& view) {
  return view.colouring == Colouring::look && view.signs == Signs::none;
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

std::array<std::uint8_t, 4> tint_bytes(const Eigen::Vector3f& colour) {
  const std::uint32_t code = tint_payload(colour);
  return {static_cast<std::uint8_t>(code >> 16), static_cast<std::uint8_t>(code >> 8), static_cast<std::uint8_t>(code),
          255};
}

Result<std::vector<std::array<float, 3>>> velocities_of(const SceneBody& body, const FrameBody& on_frame) {
  const Channel* channel = find_channel(on_frame, "velocity");
  const auto count = static_cast<std::size_t>(body.rest_positions.rows());
  std::vector<std::array<float, 3>> rows(count, {0.f, 0.f, 0.f});
  if (channel == nullptr)
    return rows;
  if (channel->components != 3 || channel->values.size() != 3 * count)
    return make_error(ErrorCode::bad_input, "body {}: {} velocity values for {} vertices; expected {}", body.name,
                      channel->values.size(), count, 3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      rows[i][c] = std::isfinite(channel->values[3 * i + c]) ? static_cast<float>(channel->values[3 * i + c]) : 0.f;
  }
  return rows;
}

/// Where creases and normals are found: the mesh of a grain at the size of its grains.
Points drawn_rest(const SceneBody& body) {
  if (body.kind == BodyKind::particles)
    return body.rest_positions * body.grain.size.asDiagonal();
  return body.rest_positions;
}

} // namespace

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

Status DrawableScene::append_cloud(const Frame& frame, std::size_t index, const View& view, DrawList& list) const {
  const SceneBody& body = m_scene.bodies[index];
  const std::uint32_t row = wears_looks(view) ? m_bodies[index].grain_look : 0U;
  Result<GrainCloud> cloud = make_grain_cloud(body, frame.bodies[index], frame.number, m_origin, view,
                                              m_looks[m_bodies[index].grain_look], row);
  if (!cloud.ok())
    return cloud.error();
  if (body.grain.shape == GrainShape::mesh) {
    append_mesh_grains(*cloud, index, list);
    return {};
  }
  const Exposure exposure = exposed_grains(*cloud, m_floor);
  const int segments = round_segments(static_cast<float>(cloud->mean_width / m_pixel));
  const bool flat = body.grain.shape == GrainShape::brick || body.grain.shape == GrainShape::card;
  DrawCloud seen;
  seen.shape = body.grain.shape;
  seen.body = static_cast<std::uint32_t>(index) + 1u;
  seen.segments = flat ? 0 : seen.shape == GrainShape::sphere ? std::max(3, segments) : segments;
  if (!exposure.has_buried()) {
    seen.grains = std::move(cloud->grains);
    list.clouds.push_back(std::move(seen));
    return {};
  }
  const std::uint32_t payload = wears_looks(view)                   ? tint_payload(Eigen::Vector3f::Constant(0.04f))
                                : view.colouring == Colouring::heat ? heat_payload(HEAT_ABSENT)
                                                                    : 0U;
  const auto append = [&](DrawCloud::For seen_by, const std::vector<std::uint32_t>& which, const Darkness& beneath) {
    DrawCloud grains = seen;
    grains.seen_by = seen_by;
    grains.grains.reserve(which.size());
    for (const std::uint32_t i : which)
      grains.grains.push_back(cloud->grains[i]);
    list.clouds.push_back(std::move(grains));
    DrawCloud dark;
    dark.seen_by = seen_by;
    dark.body = seen.body;
    dark.grains.reserve(beneath.centres.size());
    const float half = 0.5f * beneath.cell;
    for (const std::array<float, 3>& centre : beneath.centres)
      dark.grains.push_back(
          {centre, {{{half, 0, 0}, {0, half, 0}, {0, 0, half}}}, {0, 0, 0}, surface_word(row, payload)});
    list.clouds.push_back(std::move(dark));
  };
  append(DrawCloud::For::eye, exposure.visible, exposure.beneath);
  append(DrawCloud::For::light, exposure.casting, exposure.beneath_casting);
  return {};
}

void DrawableScene::append_mesh_grains(const GrainCloud& cloud, std::size_t index, DrawList& list) const {
  const SceneBody& body = m_scene.bodies[index];
  const SplitSurface& surface = m_bodies[index].surface;
  const Points normals = smooth_normals(surface, drawn_rest(body)) * body.grain.size.asDiagonal();
  const bool in_threes = list.in_threes;
  const std::uint32_t body_bits = (static_cast<std::uint32_t>(index) + 1u) << 8;
  for (const DrawGrain& grain : cloud.grains) {
    Eigen::Matrix3f axes;
    for (int a = 0; a < 3; ++a)
      axes.col(a) = 2.f * Eigen::Map<const Eigen::Vector3f>(grain.axes[static_cast<std::size_t>(a)].data());
    const Eigen::Matrix3f for_normals = axes.inverse().transpose();
    const Eigen::Vector3f centre = Eigen::Map<const Eigen::Vector3f>(grain.centre.data());
    const auto vertex = [&](std::int32_t split) {
      const Eigen::Index original = surface.original[static_cast<std::size_t>(split)];
      const Eigen::Vector3f x = centre + axes * body.rest_positions.row(original).transpose().cast<float>();
      const Eigen::Vector3f n = (for_normals * normals.row(split).transpose().cast<float>()).normalized();
      DrawVertex made{{x.x(), x.y(), x.z()}, {n.x(), n.y(), n.z()}, ((grain.word >> 24) - 1u) | body_bits, HEAT_ABSENT};
      made.tint = {static_cast<std::uint8_t>(grain.word >> 16), static_cast<std::uint8_t>(grain.word >> 8),
                   static_cast<std::uint8_t>(grain.word), 255};
      if (list.heat)
        made.value = heat_of_payload(grain.word & 65535u);
      return made;
    };
    const auto base = static_cast<std::uint32_t>(list.vertices.size());
    if (!in_threes) {
      for (std::size_t split = 0; split < surface.original.size(); ++split)
        list.vertices.push_back(vertex(static_cast<std::int32_t>(split)));
    }
    for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
      for (int c = 0; c < 3; ++c) {
        if (in_threes)
          list.vertices.push_back(vertex(surface.triangles(t, c)));
        else
          list.indices.push_back(base + static_cast<std::uint32_t>(surface.triangles(t, c)));
      }
    }
    if (m_blurred)
      list.velocities.resize(list.vertices.size(), grain.velocity);
  }
}

/// What is textured is drawn picture by picture, with both sides.
bool DrawableScene::is_outward(const Frame& frame, std::size_t index, const View& view) const {
  const SceneBody& body = m_scene.bodies[index];
  const Body& own = m_bodies[index];
  if (!own.closed_outward || (own.appearance && wears_looks(view)))
    return false;
  const Result<Points> positions = world_positions(body, frame.bodies[index], frame.number);
  return positions.ok() && is_right_way_out(body, frame.bodies[index], *positions);
}

Status DrawableScene::append_surface(const Frame& frame, std::size_t index, const View& view, DrawList& list) const {
  const SceneBody& body = m_scene.bodies[index];
  const Body& own = m_bodies[index];
  const SplitSurface& surface = own.surface;
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
  std::vector<std::array<float, 3>> velocities;
  if (m_blurred) {
    Result<std::vector<std::array<float, 3>>> found = velocities_of(body, frame.bodies[index]);
    if (!found.ok())
      return found.error();
    velocities = std::move(*found);
  }
  const Points normals = smooth_normals(surface, *positions);
  const std::uint32_t look = wears_looks(view) ? own.look : 0U;
  const std::uint32_t body_bits = (static_cast<std::uint32_t>(index) + 1u) << 8;
  const auto add_vertex = [&](std::int32_t split) {
    const std::int32_t original = surface.original[static_cast<std::size_t>(split)];
    const Eigen::Vector3f x = (positions->row(original).transpose() - m_origin).cast<float>();
    const Eigen::Vector3f n = normals.row(split).transpose().cast<float>();
    list.vertices.push_back({{x.x(), x.y(), x.z()}, {n.x(), n.y(), n.z()}, look | body_bits, HEAT_ABSENT});
    if (heat.on == ChannelOn::vertex && !heat.rows.empty())
      list.vertices.back().value = heat.rows[static_cast<std::size_t>(original)];
    if (m_blurred)
      list.velocities.push_back(velocities[static_cast<std::size_t>(original)]);
  };
  if (list.in_threes) {
    for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
      const std::int32_t tet = own.tet_of_triangle.empty() ? -1 : own.tet_of_triangle[static_cast<std::size_t>(t)];
      for (int c = 0; c < 3; ++c) {
        add_vertex(surface.triangles(t, c));
        if (heat.on == ChannelOn::tet && !heat.rows.empty() && tet >= 0)
          list.vertices.back().value = heat.rows[static_cast<std::size_t>(tet)];
      }
    }
    return {};
  }
  const auto base = static_cast<std::uint32_t>(list.vertices.size());
  if (own.appearance && wears_looks(view)) {
    for (const std::int32_t t : triangles_by_texture(own)) {
      for (int c = 0; c < 3; ++c) {
        list.indices.push_back(static_cast<std::uint32_t>(list.vertices.size()));
        add_vertex(surface.triangles(t, c));
        dress_corner(own, t, c, list);
      }
    }
    return {};
  }
  for (std::size_t split = 0; split < surface.original.size(); ++split)
    add_vertex(static_cast<std::int32_t>(split));
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c)
      list.indices.push_back(base + static_cast<std::uint32_t>(surface.triangles(t, c)));
  }
  return {};
}

std::vector<std::int32_t> DrawableScene::triangles_by_texture(const Body& body) {
  std::vector<std::int32_t> order(static_cast<std::size_t>(body.surface.triangles.rows()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int32_t a, std::int32_t b) { return texture_of(body, a) < texture_of(body, b); });
  return order;
}

int DrawableScene::texture_of(const Body& body, std::int32_t triangle) {
  const MeshAppearance& appearance = *body.appearance;
  const std::int32_t original = body.surface.kept[static_cast<std::size_t>(triangle)];
  const std::int32_t material = appearance.material_of_triangle[static_cast<std::size_t>(original)];
  return appearance.corner_uv.empty() ? -1 : appearance.materials[static_cast<std::size_t>(material)].texture;
}

void DrawableScene::dress_corner(const Body& body, std::int32_t triangle, int corner, DrawList& list) const {
  const MeshAppearance& appearance = *body.appearance;
  const auto original = static_cast<std::size_t>(body.surface.kept[static_cast<std::size_t>(triangle)]);
  const auto material = static_cast<std::size_t>(appearance.material_of_triangle[original]);
  const std::size_t row = 3 * original + static_cast<std::size_t>(corner);
  DrawVertex& vertex = list.vertices.back();
  Eigen::Vector3f colour = appearance.materials[material].base_colour;
  if (!appearance.corner_colour.empty())
    colour = colour.cwiseProduct(appearance.corner_colour[row]);
  vertex.look = (vertex.look & ~255u) | body.material_rows[material];
  vertex.tint = tint_bytes(colour);
  const int texture = texture_of(body, triangle);
  if (texture < 0)
    return;
  list.uvs.resize(list.vertices.size(), {0.f, 0.f});
  list.uvs.back() = appearance.corner_uv[row];
  const std::size_t global = body.first_texture + static_cast<std::size_t>(texture);
  const auto end = static_cast<std::uint32_t>(list.indices.size());
  if (list.textured.empty() || list.textured.back().texture != global || list.textured.back().end + 1 != end)
    list.textured.push_back({end - 1, end, global});
  list.textured.back().end = end;
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
  made.heat = view.colouring == Colouring::heat;
  made.in_threes = made.heat || view.wire == Wire::overlay;
  const bool sees_through = wears_looks(view) && !made.in_threes;
  const auto is_clear = [&](std::size_t b) {
    return sees_through && m_scene.bodies[b].kind == BodyKind::surface && m_looks[m_bodies[b].look].transparency > 0.f;
  };
  enum class Group { outward, open, clear };
  std::vector<Group> groups;
  for (std::size_t b = 0; b < m_bodies.size(); ++b)
    groups.push_back(is_clear(b) ? Group::clear : is_outward(frame, b, view) ? Group::outward : Group::open);
  for (const Group group : {Group::outward, Group::open, Group::clear}) {
    if (group == Group::clear)
      made.clear_begin = made.indices.size();
    for (std::size_t b = 0; b < m_bodies.size(); ++b) {
      if (groups[b] != group)
        continue;
      const bool is_cloud = m_scene.bodies[b].kind == BodyKind::particles;
      const Status good = is_cloud ? append_cloud(frame, b, view, made) : append_surface(frame, b, view, made);
      if (!good.ok())
        return good.error();
    }
    if (group == Group::outward)
      made.outward_end = made.in_threes ? made.vertices.size() : made.indices.size();
  }
  if (made.in_threes)
    made.clear_begin = made.vertices.size();
  if (view.signs != Signs::none) {
    if (const Status good = append_marks(frame, view, made); !good.ok())
      return good.error();
  }
  if (!made.uvs.empty())
    made.uvs.resize(made.vertices.size(), {0.f, 0.f});
  return made;
}

Status DrawableScene::append_marks(const Frame& frame, const View& view, DrawList& list) const {
  constexpr double SIZE = 0.045; // of the radius of the bounds
  DrawCloud marks;
  bool any = false;
  for (std::size_t b = 0; b < m_bodies.size(); ++b) {
    const SceneBody& body = m_scene.bodies[b];
    const FrameBody& on_frame = frame.bodies[b];
    any = any || sign_channel(on_frame, view.signs) != nullptr;
    Points positions;
    if (body.kind == BodyKind::particles) {
      const std::vector<double>& values = find_channel(on_frame, "position")->values; // make_grain_cloud() has seen it
      positions = Eigen::Map<const Points>(values.data(), static_cast<Eigen::Index>(values.size() / 3), 3);
    } else {
      Result<Points> found = world_positions(body, on_frame, frame.number);
      if (!found.ok())
        return found.error();
      positions = std::move(*found);
    }
    if (const Status good =
            append_signs(body, on_frame, positions, view.signs, SIZE * m_radius, m_origin, SIGN_ROW, marks);
        !good.ok())
      return good;
  }
  if (!any)
    return make_error(ErrorCode::bad_input, "view {}: no body of frame {} has the channel that it shows", view.name,
                      frame.number);
  list.clouds.push_back(std::move(marks));
  return {};
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
