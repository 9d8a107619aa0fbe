#include "pipeline/plan/compile_fields.h"

#include <array>
#include <limits>

#include "pipeline/plan/compile_fem.h"

namespace wry::pipeline {

namespace {

const Threads& one_thread() {
  static const Threads threads(1);
  return threads;
}

/// The nine formulas of Gamma0, row by row, and what the body's vertices carry for them.
struct CurvatureFormulas {
  std::array<std::optional<scene::Expression>, 9> entries; ///< absent: zero
  std::shared_ptr<const geometry::TetMesh> mesh;
  std::size_t attribute_count = 0;
};

Mat3 evaluate(const CurvatureFormulas& formulas, const fem::RestPlace& place, double time) {
  const geometry::TetMesh& mesh = *formulas.mesh;
  const std::array<std::int32_t, 4>& vertices = place.vertices;
  scene::ExpressionPoint point;
  point.time = time;
  point.position = place.position;
  if (mesh.body_coordinates.rows() > 0) {
    for (int k = 0; k < 4; ++k) {
      point.u += place.weights[k] * mesh.body_coordinates(vertices[k], 0);
      point.v += place.weights[k] * mesh.body_coordinates(vertices[k], 1);
    }
  }
  std::vector<double> attributes;
  if (formulas.attribute_count > 0) {
    for (const geometry::VertexAttribute& attribute : mesh.attributes) {
      for (int i = 0; i < attribute.components; ++i) {
        double value = 0.0;
        for (int k = 0; k < 4; ++k)
          value +=
              place.weights[k] * attribute.values[static_cast<std::size_t>(vertices[k]) * attribute.components + i];
        attributes.push_back(value);
      }
    }
  }
  point.attributes = attributes;
  Mat3 value = Mat3::Zero();
  for (int i = 0; i < 9; ++i) {
    if (!formulas.entries[i])
      continue;
    const Result<double> number = formulas.entries[i]->evaluate(point);
    // Not a number on purpose: the solver refuses a strain that is not finite, with time and element.
    value(i / 3, i % 3) = number ? *number : std::numeric_limits<double>::quiet_NaN();
  }
  return value;
}

} // namespace

Result<scene::Expression> compile_formula(const shots::Located<shots::Expression>& asked,
                                          const geometry::TetMesh& mesh) {
  const std::vector<std::string> names = scene::component_names(mesh.attributes);
  Result<scene::Expression> compiled = scene::Expression::compile(asked->text, names);
  if (!compiled)
    return at_source(asked.source, compiled.error());
  return compiled;
}

scene::RestPoints tet_centres(const geometry::TetMesh& mesh) {
  scene::RestPoints centres;
  const auto mean = [&](const auto& rows) {
    typename std::decay_t<decltype(rows)> out(mesh.tets.rows(), rows.cols());
    for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet)
      out.row(tet) = 0.25 * (rows.row(mesh.tets(tet, 0)) + rows.row(mesh.tets(tet, 1)) + rows.row(mesh.tets(tet, 2)) +
                             rows.row(mesh.tets(tet, 3)));
    return out;
  };
  centres.positions = mean(mesh.vertices);
  if (mesh.body_coordinates.rows() > 0)
    centres.body_coordinates = mean(mesh.body_coordinates);
  for (const geometry::VertexAttribute& attribute : mesh.attributes) {
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const Rows means =
        mean(Rows(Eigen::Map<const Rows>(attribute.values.data(), mesh.vertices.rows(), attribute.components)));
    centres.attributes.push_back(
        {attribute.name, attribute.components, std::vector<double>(means.data(), means.data() + means.size())});
  }
  return centres;
}

bool rest_curvature_moves(const shots::Material& material) {
  for (const auto& row : material.rest_curvature) {
    for (const std::optional<shots::Located<shots::Expression>>& entry : row) {
      // A formula that does not compile is refused elsewhere.
      if (!entry || (*entry)->constant)
        continue;
      const Result<scene::Expression> compiled = scene::Expression::compile((*entry)->text);
      if (!compiled || compiled->uses("t"))
        return true;
    }
  }
  return false;
}

Result<fem::RestCurvature> compile_rest_curvature(const shots::Material& material,
                                                  const std::shared_ptr<const geometry::TetMesh>& mesh, double end) {
  if (!material.has_rest_curvature())
    return fem::RestCurvature();
  auto formulas = std::make_shared<CurvatureFormulas>();
  formulas->mesh = mesh;
  formulas->attribute_count = scene::component_names(mesh->attributes).size();
  const scene::RestPoints centres = tet_centres(*mesh);
  for (int i = 0; i < 9; ++i) {
    const std::optional<shots::Located<shots::Expression>>& asked = material.rest_curvature[i / 3][i % 3];
    if (!asked)
      continue;
    Result<scene::Expression> compiled = compile_formula(*asked, *mesh);
    if (!compiled)
      return compiled.error();
    for (const double time : {0.0, end}) {
      if (const Result<std::vector<double>> values = compiled->evaluate_all(centres, time, one_thread()); !values)
        return at_source(asked->source, values.error());
    }
    formulas->entries[i] = std::move(*compiled);
  }
  return fem::RestCurvature(
      [formulas](const fem::RestPlace& place, double time) { return evaluate(*formulas, place, time); });
}

Result<fem::MaterialFactors> compile_factors(const shots::Material& material, const geometry::TetMesh& mesh) {
  fem::MaterialFactors factors;
  scene::RestPoints centres;
  struct Entry {
    const std::optional<shots::Located<shots::Expression>>& asked;
    std::vector<double>& values;
  };
  for (const Entry& entry :
       {Entry{material.vary.density, factors.density}, Entry{material.vary.youngs_modulus, factors.youngs_modulus},
        Entry{material.vary.couple_modulus_ratio, factors.couple_modulus_ratio},
        Entry{material.vary.length_scale, factors.length_scale}}) {
    if (!entry.asked)
      continue;
    const shots::Located<shots::Expression>& asked = *entry.asked;
    if (centres.positions.rows() == 0)
      centres = tet_centres(mesh);
    const Result<scene::Expression> compiled = compile_formula(asked, mesh);
    if (!compiled)
      return compiled.error();
    if (compiled->uses("t"))
      return at_source(asked.source, make_error(ErrorCode::bad_input,
                                                "'{}' depends on the time t; material is the same at all times, only "
                                                "rest_curvature moves",
                                                asked->text));
    Result<std::vector<double>> values = compiled->evaluate_all(centres, 0.0, one_thread());
    if (!values)
      return at_source(asked.source, values.error());
    for (std::size_t tet = 0; tet < values->size(); ++tet) {
      if ((*values)[tet] > 0.0)
        continue;
      const Vec3 at = centres.positions.row(static_cast<Eigen::Index>(tet));
      return at_source(asked.source, make_error(ErrorCode::bad_input,
                                                "'{}' is {:.6g} at ({:.4g}, {:.4g}, {:.4g}); expected a factor "
                                                "above 0 everywhere in the body",
                                                asked->text, (*values)[tet], at[0], at[1], at[2]));
    }
    entry.values = std::move(*values);
  }
  return factors;
}

} // namespace wry::pipeline
