// What one frame draws: the half of DrawableScene that runs for every picture.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>

#include "render/burial.h"
#include "render/drawable_scene.h"
#include "render/grain_shapes.h"
#include "render/heat_values.h"
#include "render/outward.h"
#include "render/signs.h"

namespace wry::render {
namespace {

/// Row of the look table of whatever signs are drawn with.
constexpr std::uint32_t SIGN_ROW = 2;

bool wears_looks(const View& view) {
  return view.colouring == Colouring::look && view.signs == Signs::none;
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

} // namespace

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

} // namespace wry::render
