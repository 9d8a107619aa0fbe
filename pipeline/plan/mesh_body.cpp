#include "pipeline/plan/mesh_body.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "pipeline/assets/mesh_import.h"
#include "pipeline/cache/sha256.h"
#include "pipeline/plan/compile_fem.h"
#include "sim/geometry/isosurface_stuffing.h"
#include "sim/geometry/mesh_checks.h"
#include "sim/geometry/msh_import.h"
#include "sim/geometry/remesh.h"
#include "sim/geometry/sheet_triangles.h"
#include "sim/geometry/shell_extrusion.h"
#include "sim/geometry/structured_tets.h"
#include "sim/geometry/tet_quality.h"
#include "sim/scene/transform.h"

namespace wry::pipeline {

namespace {

/// What a shape is before it is filled: a surface, a block that is meshed by its lattice, or tets that are there
/// already.
struct Source {
  std::string description;
  std::optional<geometry::SurfaceMesh> surface;
  std::optional<geometry::Block> block;
  std::optional<geometry::TetMesh> tets;
  std::vector<Asset> assets;
  std::vector<std::string> notes;
  std::optional<render::MeshAppearance> appearance;
};

geometry::Axis axis_of(shots::Axis axis) {
  return static_cast<geometry::Axis>(axis);
}

Vec3 extent_of(const Points& points) {
  return (points.colwise().maxCoeff() - points.colwise().minCoeff()).transpose();
}

/// The edge asked for, or a twelfth of the smallest extent so that a look at a new mesh needs no number.
double target_edge(const shots::Body& body) {
  return body.resolution ? **body.resolution : 0.0;
}

class BodyMesher {
public:
  BodyMesher(const shots::Body& body, shots::Axis up)
      : m_body(body)
      , m_up(up) {}

  Result<MeshedBody> mesh();
  Result<MeshedBody> mesh_plate();
  Result<PlacedSurface> surface(double edge);

private:
  Result<Source> source() const;
  Result<Source> import_source(const shots::MeshShape& shape) const;
  Result<geometry::TetMesh> fill(Source& source);
  Result<geometry::TetMesh> fill_block(const Source& source);
  Result<geometry::TetMesh> fill_surface(Source& source);
  Result<geometry::SurfaceMesh> plate_surface(Source& source) const;
  MeshedBody finish(geometry::TetMesh mesh, Source source) const;
  Error located(const shots::Source& where, Error error) const { return at_source(where, std::move(error)); }

  const shots::Body& m_body;
  shots::Axis m_up;
};

Result<Source> BodyMesher::import_source(const shots::MeshShape& shape) const {
  Source source;
  source.description = "mesh " + *shape.path;
  const Result<std::string> hash = sha256_of_file(*shape.path);
  if (!hash)
    return located(shape.path.source, hash.error());
  source.assets.push_back({*shape.path, *hash});
  if (shape.is_tet_mesh) {
    Result<geometry::TetMesh> tets = geometry::import_tets(*shape.path);
    if (!tets)
      return located(shape.path.source, tets.error());
    tets->vertices *= *m_body.metres_per_unit;
    source.tets = std::move(*tets);
    return source;
  }
  MeshImportOptions options;
  options.metres_per_unit = *m_body.metres_per_unit;
  options.up = axis_of(m_body.up ? **m_body.up : m_up);
  options.scene_up = axis_of(m_up);
  Result<ImportedMesh> imported = import_mesh(*shape.path, options);
  if (!imported)
    return located(shape.path.source, imported.error());
  source.notes.insert(source.notes.end(), imported->notes.begin(), imported->notes.end());
  source.surface = std::move(imported->mesh);
  source.appearance = std::move(imported->appearance);
  return source;
}

struct ShapeSource {
  double edge;
  geometry::Block block(const shots::BoxShape& box) const { return geometry::box_block(*box.size); }

  Result<Source> from_block(const char* name, const geometry::Block& block) const {
    Source source;
    source.description = name;
    source.block = block;
    return source;
  }
  Result<Source> from_surface(const char* name, Result<geometry::SurfaceMesh> surface) const {
    if (!surface)
      return surface.error();
    Source source;
    source.description = name;
    source.surface = std::move(*surface);
    return source;
  }
  Result<Source> operator()(const shots::MeshShape&) const { return Source(); }
  Result<Source> operator()(const shots::BoxShape& box) const {
    return from_block("box", geometry::box_block(*box.size));
  }
  Result<Source> operator()(const shots::RodShape& rod) const {
    return from_block(
        "rod", geometry::rod_block(*rod.length, *rod.width, *rod.height, geometry::Section::box, geometry::Axis::x));
  }
  Result<Source> operator()(const shots::SheetShape& sheet) const {
    geometry::Block block = geometry::box_block(Vec3(*sheet.width, *sheet.thickness, *sheet.depth));
    block.axis = geometry::Axis::y;
    block.u_axis = geometry::Axis::x;
    block.v_axis = geometry::Axis::z;
    return from_block("sheet", block);
  }
  Result<Source> operator()(const shots::CylinderShape& cylinder) const {
    return from_block("cylinder", geometry::cylinder_block(*cylinder.radius, *cylinder.height));
  }
  Result<Source> operator()(const shots::SphereShape& sphere) const {
    return from_surface("sphere", geometry::make_sphere(*sphere.radius, 0.5 * edge));
  }
  Result<Source> operator()(const shots::TorusShape& torus) const {
    return from_surface("torus",
                        geometry::make_torus(*torus.radius, *torus.tube_radius, geometry::Axis::y, 0.5 * edge));
  }
};

Result<Source> BodyMesher::source() const {
  if (const auto* mesh = std::get_if<shots::MeshShape>(&m_body.shape))
    return import_source(*mesh);
  Result<Source> made = std::visit(ShapeSource{target_edge(m_body)}, m_body.shape);
  if (!made)
    return located(m_body.source, made.error());
  return made;
}

Result<geometry::TetMesh> BodyMesher::fill_block(const Source& source) {
  if (!m_body.cells)
    return geometry::make_block_tets(*source.block, target_edge(m_body));
  geometry::BlockCells cells;
  for (int i = 0; i < 3; ++i)
    cells.cells[i] = static_cast<int>((**m_body.cells)[i]);
  cells.split = *m_body.split == shots::CellSplit::kuhn ? geometry::CellSplit::kuhn
                                                        : geometry::default_split(source.block->section);
  return geometry::make_block_tets(*source.block, cells);
}

Result<geometry::TetMesh> BodyMesher::fill_surface(Source& source) {
  const geometry::MeshReport report = geometry::inspect_mesh(*source.surface);
  const std::string name = "body " + *m_body.name;
  for (const Status& status :
       {geometry::check_valid(*source.surface, report, name), geometry::check_closed(report, name),
        geometry::check_manifold(*source.surface, report, name)}) {
    if (!status)
      return status.error();
  }
  const Result<geometry::OrientReport> oriented = geometry::orient_outward(*source.surface);
  if (!oriented)
    return oriented.error();
  if (oriented->flipped > 0)
    source.notes.push_back(fmt::format("{} triangles were turned to face outward", oriented->flipped));
  if (m_body.shell) {
    geometry::ShellSettings settings;
    settings.thickness = *m_body.shell->thickness;
    settings.layers = static_cast<int>(*m_body.shell->layers);
    settings.edge = target_edge(m_body);
    Result<geometry::ShellMesh> shell = geometry::extrude_shell(*source.surface, settings);
    if (!shell)
      return shell.error();
    source.notes.push_back(fmt::format("shell {}: walls {:.4g} to {:.4g} m, volume error {:.2g} %",
                                       geometry::shell_method_name(shell->method), shell->min_wall, shell->max_wall,
                                       100.0 * shell->volume_error));
    for (const geometry::ThinPlace& place : shell->thin_places)
      source.notes.push_back(fmt::format("thinner wall of {:.4g} m near ({:.3g}, {:.3g}, {:.3g}): the body is only "
                                         "{:.4g} m deep there",
                                         place.thickness, place.point[0], place.point[1], place.point[2], place.depth));
    return std::move(shell->mesh);
  }
  geometry::StuffingSettings settings;
  settings.edge = target_edge(m_body);
  Result<geometry::SolidMesh> solid = geometry::stuff_solid(*source.surface, settings);
  if (!solid)
    return solid.error();
  source.notes.push_back(
      fmt::format("isosurface stuffing: volume error {:.2g} %",
                  100.0 * std::abs(geometry::volume_error(solid->quality, solid->reference_volume))));
  return std::move(solid->mesh);
}

Result<geometry::TetMesh> BodyMesher::fill(Source& source) {
  if (source.tets)
    return std::move(*source.tets);
  if (source.block && !m_body.shell)
    return fill_block(source);
  if (source.block) {
    Result<geometry::SurfaceMesh> surface = geometry::make_block_surface(*source.block, target_edge(m_body));
    if (!surface)
      return surface.error();
    source.surface = std::move(*surface);
  }
  return fill_surface(source);
}

MeshedBody BodyMesher::finish(geometry::TetMesh mesh, Source source) const {
  const geometry::TetQuality quality = geometry::measure(mesh);
  MeshedBody meshed;
  BodyReport& report = meshed.report;
  report.name = *m_body.name;
  report.source = source.description;
  report.size = extent_of(mesh.vertices);
  report.tets = static_cast<std::size_t>(quality.tets);
  report.nodes = static_cast<std::size_t>(quality.vertices);
  report.surface_triangles = static_cast<std::size_t>(geometry::boundary_triangles(mesh).rows());
  report.volume = quality.volume;
  report.min_dihedral_deg = quality.min_dihedral;
  report.max_dihedral_deg = quality.max_dihedral;
  report.min_edge = quality.min_edge;
  report.mean_edge = quality.mean_edge;
  report.notes = std::move(source.notes);
  meshed.assets = std::move(source.assets);
  meshed.mesh = std::make_shared<const geometry::TetMesh>(std::move(mesh));
  return meshed;
}

Result<MeshedBody> BodyMesher::mesh() {
  Result<Source> made = source();
  if (!made)
    return made.error();
  Points* points = made->surface ? &made->surface->vertices : made->tets ? &made->tets->vertices : nullptr;
  const Vec3 extent = points != nullptr ? extent_of(*points) : made->block->size;
  const Result<scene::Similarity> placed = scene::placement_similarity(compile_placement(m_body, m_up), extent);
  if (!placed)
    return located(m_body.source, placed.error());
  // Surfaces are placed before they are filled, so that resolution and thickness are metres of the shot.
  if (points != nullptr)
    scene::apply(*placed, *points);
  else
    made->block->size *= placed->scale;
  Result<geometry::TetMesh> filled = fill(*made);
  if (!filled)
    return located(m_body.source, filled.error());
  if (points == nullptr) {
    const scene::Similarity moved{1.0, placed->rotation, placed->translation};
    scene::apply(moved, filled->vertices);
  }
  return finish(std::move(*filled), std::move(*made));
}

Result<geometry::SheetTriangles> sheet_of(const shots::Body& body, const shots::SheetShape& shape, double scale) {
  const double width = *shape.width * scale, depth = *shape.depth * scale;
  std::array<int, 2> cells = {1, 1};
  if (body.cells) {
    cells = {static_cast<int>((**body.cells)[0]), static_cast<int>((**body.cells)[2])};
  } else {
    const double edge = target_edge(body);
    cells = {static_cast<int>(std::ceil(width / edge - 1e-9)), static_cast<int>(std::ceil(depth / edge - 1e-9))};
  }
  return geometry::make_sheet_triangles(width, depth, cells[0], cells[1],
                                        *body.split == shots::CellSplit::kuhn ? geometry::SheetSplit::parallel
                                                                              : geometry::SheetSplit::alternating);
}

/// The surface of a plate that is no sheet: divided anew where it is closed, as it is where it is open.
Result<geometry::SurfaceMesh> BodyMesher::plate_surface(Source& source) const {
  if (source.block) {
    Result<geometry::SurfaceMesh> surface = geometry::make_block_surface(*source.block, target_edge(m_body));
    return surface;
  }
  const geometry::MeshReport report = geometry::inspect_mesh(*source.surface);
  const std::string name = "body " + *m_body.name;
  if (Status status = geometry::check_valid(*source.surface, report, name); !status)
    return status.error();
  if (Status status = geometry::check_manifold(*source.surface, report, name); !status)
    return status.error();
  const bool imported = std::holds_alternative<shots::MeshShape>(m_body.shape);
  if (imported && geometry::check_closed(report, name) && m_body.resolution)
    return geometry::remesh(*source.surface, target_edge(m_body));
  if (imported)
    source.notes.push_back("an open surface: its triangles are the plate's elements, resolution is not used");
  return std::move(*source.surface);
}

Result<MeshedBody> BodyMesher::mesh_plate() {
  Result<Source> made = source();
  if (!made)
    return made.error();
  Points* points = made->surface ? &made->surface->vertices : nullptr;
  const Vec3 extent = points != nullptr ? extent_of(*points) : made->block->size;
  const Result<scene::Similarity> placed = scene::placement_similarity(compile_placement(m_body, m_up), extent);
  if (!placed)
    return located(m_body.source, placed.error());
  geometry::TetMesh mesh;
  Triangles triangles;
  MeshedBody meshed;
  const scene::Similarity moved{1.0, placed->rotation, placed->translation};
  if (const auto* sheet = std::get_if<shots::SheetShape>(&m_body.shape)) {
    Result<geometry::SheetTriangles> flat = sheet_of(m_body, *sheet, placed->scale);
    if (!flat)
      return located(m_body.source, flat.error());
    mesh = std::move(flat->mesh);
    triangles = std::move(flat->triangles);
    meshed.sheet_thickness = *sheet->thickness * placed->scale;
    scene::apply(moved, mesh.vertices);
  } else {
    if (points != nullptr)
      scene::apply(*placed, *points);
    else
      made->block->size *= placed->scale;
    Result<geometry::SurfaceMesh> surface = plate_surface(*made);
    if (!surface)
      return located(m_body.source, surface.error());
    mesh.vertices = std::move(surface->vertices);
    mesh.attributes = std::move(surface->attributes);
    triangles = std::move(surface->triangles);
    if (points == nullptr)
      scene::apply(moved, mesh.vertices);
  }
  BodyReport& report = meshed.report;
  report.name = *m_body.name;
  report.source = made->description + ", as a plate";
  report.size = extent_of(mesh.vertices);
  report.nodes = static_cast<std::size_t>(mesh.vertices.rows());
  report.surface_triangles = static_cast<std::size_t>(triangles.rows());
  report.notes = std::move(made->notes);
  meshed.assets = std::move(made->assets);
  meshed.triangles = std::move(triangles);
  meshed.mesh = std::make_shared<const geometry::TetMesh>(std::move(mesh));
  return meshed;
}

Result<PlacedSurface> BodyMesher::surface(double edge) {
  Result<Source> made = std::holds_alternative<shots::MeshShape>(m_body.shape)
                            ? source()
                            : std::visit(ShapeSource{2.0 * edge}, m_body.shape);
  if (!made)
    return located(m_body.source, made.error());
  if (made->tets)
    return located(m_body.source, make_error(ErrorCode::bad_input, "particles fill a closed surface, not a tet mesh; "
                                                                   "give an obj, ply, stl, gltf, ..."));
  if (made->block) {
    Result<geometry::SurfaceMesh> surface = geometry::make_block_surface(*made->block, edge);
    if (!surface)
      return located(m_body.source, surface.error());
    made->surface = std::move(*surface);
  }
  const Vec3 extent = extent_of(made->surface->vertices);
  const Result<scene::Similarity> placed = scene::placement_similarity(compile_placement(m_body, m_up), extent);
  if (!placed)
    return located(m_body.source, placed.error());
  scene::apply(*placed, made->surface->vertices);
  const geometry::MeshReport report = geometry::inspect_mesh(*made->surface);
  const std::string name = "body " + *m_body.name;
  for (const Status& status :
       {geometry::check_valid(*made->surface, report, name), geometry::check_closed(report, name)}) {
    if (!status)
      return located(m_body.source, status.error());
  }
  return PlacedSurface{std::move(*made->surface), made->description, std::move(made->assets), std::move(made->notes),
                       std::move(made->appearance)};
}

} // namespace

Result<PlacedSurface> body_surface(const shots::Body& body, shots::Axis up, double edge) {
  return BodyMesher(body, up).surface(edge);
}

scene::Placement compile_placement(const shots::Placed& placed, shots::Axis up) {
  scene::Placement placement;
  placement.up = axis_of(up);
  if (placed.size)
    placement.size = scene::SizeRule{static_cast<scene::SizeMeasure>(placed.size->measure), *placed.size->length};
  placement.scale = *placed.scale;
  for (const shots::Rotation& turn : placed.rotate)
    placement.rotate.push_back({*turn.axis, *turn.degrees});
  placement.translate = *placed.translate;
  return placement;
}

Result<MeshedBody> mesh_body(const shots::Body& body, shots::Axis up, Filling filling) {
  BodyMesher mesher(body, up);
  return filling == Filling::nothing ? mesher.mesh_plate() : mesher.mesh();
}

} // namespace wry::pipeline
