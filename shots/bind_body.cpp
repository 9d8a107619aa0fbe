#include <filesystem>

#include "shots/bind.h"

namespace wry::shots {
namespace {

bool ends_with_msh(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) {
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return extension == ".msh";
}

Shape bind_shape(const Reader& body, const std::string& directory) {
  if (body.has("region")) {
    return BoxShape{Located<Vec3>(Vec3::Zero())}; // nobody reads it
  }
  if (body.has("box")) {
    return BoxShape{body.child("box").vector("size")};
  }
  if (body.has("sphere")) {
    return SphereShape{body.child("sphere").number("radius")};
  }
  if (body.has("cylinder")) {
    const Reader shape = body.child("cylinder");
    return CylinderShape{shape.number("radius"), shape.number("height")};
  }
  if (body.has("rod")) {
    const Reader shape = body.child("rod");
    return RodShape{shape.number("length"), shape.number("width"), shape.number("height")};
  }
  if (body.has("sheet")) {
    const Reader shape = body.child("sheet");
    return SheetShape{shape.number("width"), shape.number("depth"), shape.number("thickness")};
  }
  if (body.has("torus")) {
    const Reader shape = body.child("torus");
    return TorusShape{shape.number("radius"), shape.number("tube_radius")};
  }
  const Located<std::string> path = bind_path(body, "mesh", directory);
  return MeshShape{path, ends_with_msh(*path)};
}

std::optional<Size> bind_size(const Reader& body) {
  const Reader size = body.child("size");
  using Named = std::pair<const char*, SizeMeasure>;
  for (const auto& [key, measure] : {Named{"height", SizeMeasure::height}, Named{"width", SizeMeasure::width},
                                     Named{"depth", SizeMeasure::depth}, Named{"max", SizeMeasure::max}}) {
    if (size.has(key)) {
      return Size{measure, size.number(key)};
    }
  }
  return std::nullopt;
}

Located<double> bind_units(const Reader& body) {
  return body.choice<double>("units",
                             {{"m", 1.0}, {"dm", 0.1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}});
}

} // namespace

void bind_placement(const Reader& reader, Placed& placed) {
  placed.size = bind_size(reader);
  placed.scale = reader.number("scale");
  placed.scale.value = reader.has("scale") ? *placed.scale : 1.0; // `size` takes its place
  placed.metres_per_unit = bind_units(reader);
  if (const auto up = reader.optional_text("up")) {
    placed.up = Located<Axis>(axis_of(**up), up->source);
  }
  for (const Reader& rotation : reader.children("rotate")) {
    placed.rotate.push_back(Rotation{rotation.vector("axis"), rotation.number("degrees")});
  }
  placed.translate = reader.vector("translate");
}

Located<std::string> bind_path(const Reader& reader, const std::string& key, const std::string& directory) {
  Located<std::string> path = reader.text(key);
  path.value = (std::filesystem::path(directory) / *path).lexically_normal().string();
  return path;
}

Axis axis_of(const std::string& word) {
  return word == "x" ? Axis::x : word == "z" ? Axis::z : Axis::y;
}

Body bind_body(const Reader& reader, const std::string& directory) {
  Body body;
  body.source = reader.source();
  body.name = reader.text("name");
  body.shape = bind_shape(reader, directory);
  bind_placement(reader, body);
  body.velocity = reader.vector("velocity");
  body.particles = bind_particles(reader, directory);
  body.rest_rotation = bind_components(reader.child("rest_rotation"));
  if (reader.has("shell")) {
    const Reader shell = reader.child("shell");
    body.shell = Shell{shell.number("thickness"), shell.integer("layers")};
  }
  body.resolution = reader.optional_number("resolution");
  if (reader.has("cells")) {
    body.cells = reader.integers<3>("cells");
  }
  body.split = reader.choice<CellSplit>("split", {{"symmetric", CellSplit::symmetric}, {"kuhn", CellSplit::kuhn}});
  body.element = reader.choice<Element>("element", {{"auto", Element::automatic},
                                                    {"tet4", Element::tet4},
                                                    {"tet10", Element::tet10},
                                                    {"tri3", Element::tri3},
                                                    {"tri6", Element::tri6}});
  body.quadrature =
      reader.choice<Quadrature>("quadrature", {{"full", Quadrature::full}, {"one-point", Quadrature::one_point}});
  body.material = reader.text("material");
  body.look = reader.optional_text("look");
  body.draw = reader.choice<DrawnAs>(
      "draw", {{"auto", DrawnAs::automatic}, {"shape", DrawnAs::shape}, {"elements", DrawnAs::elements}});
  return body;
}

} // namespace wry::shots
