#include "pipeline/plan/drawn_surfaces.h"

#include <algorithm>
#include <variant>

#include <fmt/format.h>

#include "pipeline/plan/compile_appearance.h"
#include "pipeline/plan/compile_fem.h"
#include "pipeline/plan/mesh_body.h"

namespace wry::pipeline {

namespace {

/// Edges of a ball or a ring over those of its elements: fine enough that no corner shows.
constexpr double FINENESS = 0.25;

/// Whether a body has a shape that its elements only come near to; blocks are as their lattice makes them.
bool has_own_shape(const shots::Body& body) {
  if (const auto* mesh = std::get_if<shots::MeshShape>(&body.shape))
    return !mesh->is_tet_mesh;
  return std::holds_alternative<shots::SphereShape>(body.shape) ||
         std::holds_alternative<shots::TorusShape>(body.shape);
}

bool is_transparent(const shots::Shot& shot, const shots::Body& body) {
  const shots::Look* look = body.look ? shot.find_look(**body.look) : nullptr;
  return look != nullptr ? *look->transparency > 0.0 : body.look && **body.look == "glass";
}

Points rows_of(const Channel& channel) {
  return Eigen::Map<const Points>(channel.values.data(), static_cast<Eigen::Index>(channel.values.size() / 3), 3);
}

} // namespace

Status DrawnSurfaces::add(const shots::Shot& shot, const shots::Body& body, std::size_t index) {
  SceneBody& drawn = m_scene.bodies[index];
  const shots::Look* dressed = look_with_own_materials(shot, body.look);
  const bool insists = *body.draw == shots::DrawnAs::shape || dressed != nullptr;
  const shots::Source& why = dressed != nullptr ? dressed->own_materials.source : body.draw.source;
  if (*body.draw == shots::DrawnAs::elements) {
    if (dressed == nullptr)
      return {};
    return make_error(ErrorCode::bad_input,
                      "{}: body {} is drawn as its elements, which have no materials of the mesh file; give it a look "
                      "with a colour, or draw = \"shape\"",
                      why.text(), *body.name);
  }
  if (drawn.tets.rows() == 0 || !has_own_shape(body)) {
    if (!insists)
      return {};
    return make_error(ErrorCode::bad_input,
                      "{}: body {} has no shape beside its elements; that have bodies made from a surface mesh, a "
                      "sphere or a torus and filled with tets",
                      why.text(), *body.name);
  }
  if (!insists && body.shell && is_transparent(shot, body)) {
    m_notes.push_back(fmt::format("body {} is hollow and transparent: its elements are drawn, which have an inside; "
                                  "draw = \"shape\" draws the mesh",
                                  *body.name));
    return {};
  }
  const double edge = body.resolution ? FINENESS * **body.resolution : 0.0;
  Result<PlacedSurface> placed = body_surface(body, *shot.shot.up, edge);
  if (!placed)
    return placed.error();
  if (dressed != nullptr && !placed->appearance)
    return make_error(ErrorCode::bad_input, "{}: {} has no materials", why.text(), placed->description);
  geometry::SurfaceEmbedding embedding =
      geometry::SurfaceEmbedding::make({drawn.rest_positions, drawn.tets, {}, {}}, placed->surface.vertices);
  const geometry::SurfaceEmbedding::Farthest far = embedding.farthest();
  constexpr double NEAR = 0.5; // edges
  if (far.distance > NEAR * far.edge) {
    const std::string what =
        fmt::format("body {}: part of its shape, near ({:.3g}, {:.3g}, {:.3g}), lies {:.3g} m away from its elements, "
                    "whose edges are {:.3g} m there",
                    *body.name, far.point.x(), far.point.y(), far.point.z(), far.distance, far.edge);
    if (insists)
      return make_error(ErrorCode::bad_input, "{}: {}; make body.resolution finer", why.text(), what);
    m_notes.push_back(what + "; its elements are drawn");
    return {};
  }
  drawn.rest_positions = std::move(placed->surface.vertices);
  drawn.triangles = std::move(placed->surface.triangles);
  drawn.tets.resize(0, 4);
  if (dressed != nullptr)
    m_appearances[*body.name] = std::make_shared<render::MeshAppearance>(std::move(*placed->appearance));
  m_carried.push_back({index, std::move(embedding)});
  return {};
}

Result<DrawnSurfaces> DrawnSurfaces::create(const shots::Shot& shot, const SceneStatic& simulated) {
  DrawnSurfaces drawn;
  drawn.m_scene = simulated;
  for (const shots::Body& body : shot.bodies) {
    const auto found = std::find_if(simulated.bodies.begin(), simulated.bodies.end(), [&](const SceneBody& candidate) {
      return candidate.simulated && candidate.kind == BodyKind::surface && candidate.name == *body.name;
    });
    if (found == simulated.bodies.end())
      continue;
    if (Status status = drawn.add(shot, body, static_cast<std::size_t>(found - simulated.bodies.begin())); !status)
      return status.error();
  }
  return drawn;
}

Frame DrawnSurfaces::carry(const Frame& simulated) const {
  const Threads threads(1);
  Frame frame = simulated;
  for (const Carried& carried : m_carried) {
    if (carried.body >= frame.bodies.size())
      continue; // a frame of another scene: the renderer says so
    FrameBody& body = frame.bodies[carried.body];
    const FrameBody& source = simulated.bodies[carried.body];
    body.channels.clear();
    for (const Channel& channel : source.channels) {
      // Rotations have no mean between corners that is worth its name, and what elements have, points do not.
      if (channel.on != ChannelOn::vertex || (channel.components != 1 && channel.components != 3))
        continue;
      Channel made = channel;
      if (channel.name == "position") {
        const Points points = carried.embedding.deform(rows_of(channel), threads);
        made.values.assign(points.data(), points.data() + points.size());
      } else {
        made.values = carried.embedding.interpolate(channel.values, channel.components);
      }
      body.channels.push_back(std::move(made));
    }
  }
  return frame;
}

} // namespace wry::pipeline
