#include <iterator>

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/export/exporter.h"

namespace wry::pipeline {

namespace {

std::string vectors(const Points& points) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    fmt::format_to(std::back_inserter(text), "{}({:.9g}, {:.9g}, {:.9g})", i > 0 ? ", " : "", points(i, 0),
                   points(i, 1), points(i, 2));
  return text + "]";
}

std::string quaternions(const Quaternions& turns) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < turns.rows(); ++i)
    fmt::format_to(std::back_inserter(text), "{}({:.5g}, {:.5g}, {:.5g}, {:.5g})", i > 0 ? ", " : "", turns(i, 0),
                   turns(i, 1), turns(i, 2), turns(i, 3));
  return text + "]";
}

std::string indices(const Triangles& triangles) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < triangles.size(); ++i)
    fmt::format_to(std::back_inserter(text), "{}{}", i > 0 ? ", " : "", triangles.data()[i]);
  return text + "]";
}

std::string repeated(const char* word, Eigen::Index count) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < count; ++i) {
    text += i > 0 ? ", " : "";
    text += word;
  }
  return text + "]";
}

std::string counted(Eigen::Index count) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < count; ++i)
    fmt::format_to(std::back_inserter(text), "{}{}", i > 0 ? ", " : "", i);
  return text + "]";
}

/// A property whose value is given at frames.
struct Samples {
  std::string declaration; ///< "point3f[] points"
  std::string values;      ///< "1: [...],\n"
  void add(int frame, const std::string& value) { values += fmt::format("            {}: {},\n", frame, value); }
  std::string text() const {
    return values.empty() ? std::string()
                          : fmt::format("        {}.timeSamples = {{\n{}        }}\n", declaration, values);
  }
};

/// One body as a prim of the stage.
class Prim {
public:
  explicit Prim(const SceneBody& body)
      : m_body(body) {}

  Status add(const Frame& frame, const FrameBody& state) {
    const Result<ExportPoints> points = export_points(m_body, state);
    if (!points)
      return points.error();
    m_count = points->positions.rows();
    if (!m_body.simulated && find_channel(state, "position") == nullptr) {
      add_transform(frame, state);
      return {};
    }
    m_points.add(frame.number, vectors(points->positions));
    add_extent(frame, points->positions);
    if (points->velocity.rows() > 0)
      m_velocities.add(frame.number, vectors(points->velocity));
    if (points->is_mesh)
      return {};
    if (points->orientation.rows() > 0)
      m_orientations.add(frame.number, quaternions(points->orientation));
    if (points->size.rows() > 0)
      m_scales.add(frame.number, vectors(points->size));
    m_has_size = m_has_size || points->size.rows() > 0;
    m_prototypes.add(frame.number, repeated("0", m_count));
    m_ids.add(frame.number, counted(m_count));
    return {};
  }

  std::string text() const {
    const std::string name = export_name(m_body.name);
    if (is_mesh(m_body))
      return mesh(name);
    Samples positions = m_points;
    positions.declaration = "point3f[] positions";
    std::string prim = fmt::format("    def PointInstancer \"{}\"\n    {{\n", name);
    prim += positions.text() + m_orientations.text() + m_scales.text() + m_velocities.text() + m_prototypes.text() +
            m_ids.text();
    prim += fmt::format("        rel prototypes = </scene/{}/grain>\n", name);
    prim += grain();
    return prim + "    }\n";
  }

private:
  /// What every point is drawn as: the body's own grain; with a size per point, a grain of one metre that it scales.
  std::string grain() const {
    const Vec3 size = m_has_size ? Vec3::Ones() : m_body.grain.size;
    const auto with_scale = [&](const char* type, const char* attribute) {
      return fmt::format(
          "        def {} \"grain\"\n        {{\n            {}\n            float3 xformOp:scale = ({:.9g}, "
          "{:.9g}, {:.9g})\n            uniform token[] xformOpOrder = [\"xformOp:scale\"]\n        }}\n",
          type, attribute, size[0], size[1], size[2]);
    };
    switch (m_body.grain.shape) {
    case GrainShape::sphere:
      return with_scale("Sphere", "double radius = 0.5");
    case GrainShape::rod:
    case GrainShape::straw:
    case GrainShape::coin:
      return with_scale("Cylinder",
                        "uniform token axis = \"Z\"\n            double height = 1\n            double radius = 0.5");
    case GrainShape::mesh:
      return with_scale("Mesh", mesh_attributes().c_str());
    default:
      return with_scale("Cube", "double size = 1");
    }
  }

  /// Faces and rest points of a mesh, without the braces.
  std::string mesh_attributes() const {
    return fmt::format("int[] faceVertexCounts = {}\n            int[] faceVertexIndices = {}\n            "
                       "uniform token subdivisionScheme = \"none\"\n            point3f[] points = {}",
                       repeated("3", m_body.triangles.rows()), indices(m_body.triangles),
                       vectors(m_body.rest_positions));
  }

  void add_transform(const Frame& frame, const FrameBody& state) {
    const auto& m = state.transform; // columns there, rows in USD
    std::string value = "(";
    for (int c = 0; c < 4; ++c)
      value +=
          fmt::format("{}({:.17g}, {:.17g}, {:.17g}, {:.17g})", c > 0 ? ", " : " ", m(0, c), m(1, c), m(2, c), m(3, c));
    m_transforms.add(frame.number, value + " )");
  }

  void add_extent(const Frame& frame, const Points& points) {
    if (points.rows() == 0)
      return;
    Points corners(2, 3);
    corners.row(0) = points.colwise().minCoeff();
    corners.row(1) = points.colwise().maxCoeff();
    m_extents.add(frame.number, vectors(corners));
  }

  std::string mesh(const std::string& name) const {
    std::string prim = fmt::format("    def Mesh \"{}\"\n    {{\n", name);
    prim += fmt::format("        int[] faceVertexCounts = {}\n        int[] faceVertexIndices = {}\n",
                        repeated("3", m_body.triangles.rows()), indices(m_body.triangles));
    prim += "        uniform token subdivisionScheme = \"none\"\n        uniform token orientation = \"rightHanded\"\n";
    if (m_body.simulated || !m_points.values.empty())
      return prim + m_points.text() + m_velocities.text() + m_extents.text() + "    }\n";
    prim += "        point3f[] points = " + vectors(m_body.rest_positions) + "\n";
    prim += m_transforms.text() + "        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n";
    return prim + "    }\n";
  }

  const SceneBody& m_body;
  Eigen::Index m_count = 0;
  bool m_has_size = false;
  Samples m_points{"point3f[] points", {}}, m_velocities{"vector3f[] velocities", {}}, m_extents{"float3[] extent", {}},
      m_orientations{"quath[] orientations", {}}, m_scales{"float3[] scales", {}},
      m_prototypes{"int[] protoIndices", {}}, m_ids{"int64[] ids", {}}, m_transforms{"matrix4d xformOp:transform", {}};
};

} // namespace

Status export_usda(const ExportJob& job) {
  std::vector<Prim> prims;
  for (const SceneBody& body : job.scene.bodies)
    prims.emplace_back(body);
  const Status gathered = for_each_frame(job, [&](const Frame& frame) -> Status {
    for (std::size_t b = 0; b < prims.size(); ++b) {
      if (Status status = prims[b].add(frame, frame.bodies[b]); !status)
        return status;
    }
    return {};
  });
  if (!gathered)
    return gathered;
  if (job.up == 'x')
    return make_error(ErrorCode::bad_input, "USD stages have y or z up, this shot has x; rotate it, or --to ply");
  std::string text = fmt::format("#usda 1.0\n(\n    defaultPrim = \"scene\"\n    doc = \"wry: {}\"\n"
                                 "    endTimeCode = {}\n    framesPerSecond = {}\n    metersPerUnit = 1\n"
                                 "    startTimeCode = {}\n    timeCodesPerSecond = {}\n    upAxis = \"{}\"\n)\n\n"
                                 "def Xform \"scene\"\n{{\n",
                                 export_name(job.name), job.frames.back(), job.fps, job.frames.front(), job.fps,
                                 job.up == 'z' ? "Z" : "Y");
  for (const Prim& prim : prims)
    text += prim.text();
  return write_file_atomically(job.folder / (export_name(job.name) + ".usda"), text + "}\n");
}

} // namespace wry::pipeline
