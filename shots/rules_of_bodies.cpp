#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "shots/rules.h"

namespace wry::shots {

void Rules::check_particles(const Body& body) {
  const auto refuse_solid = [&](const auto& key) {
    if (key) {
      refuse(key->source, ": only solids are cut into tets; particles_per_cell says how finely this body is sampled");
    }
  };
  refuse_solid(body.resolution);
  refuse_solid(body.cells);
  const ParticleBody& particles = body.particles;
  if (particles.region) {
    if (const auto* box = std::get_if<BoxSpace>(&particles.region->space)) {
      for (Eigen::Index i = 0; i < 3; ++i) {
        if (!((*box->min)[i] < (*box->max)[i])) {
          refuse(box->max.source, fmt::format(": along {} the box ends at {}, not above its beginning {}; it is empty",
                                              "xyz"[i], (*box->max)[i], (*box->min)[i]));
          return;
        }
      }
    }
    if (const auto* space = std::get_if<CylinderSpace>(&particles.region->space); space && *space->from == *space->to) {
      refuse(space->to.source, ": both ends of the axis are the same point; a cylinder needs a length");
    }
  }
  if (particles.fibre && particles.fibre->second_moment) {
    const Located<Vec3>& shares = *particles.fibre->second_moment;
    if (std::abs(shares->sum() - 1.0) > 1e-6) {
      refuse(shares.source, fmt::format(": the shares sum to {:.6g}; expected 1", shares->sum()));
    }
  }
  if (particles.grains && !particles.grains->mesh && !particles.grains->size) {
    refuse(below(particles.grains->source, "size"),
           " is missing: give the lengths of a grain along the material's x, y, z in m, or a mesh that has them");
  }
  if (particles.repeat && particles.grains) {
    refuse(particles.grains->source, ": a source has no sub_particles in this build; remove one of the two");
  }
  if (particles.repeat && body.velocity->norm() == 0.0) {
    refuse(particles.repeat->source, ": a source whose matter stands still piles up in place; give velocity");
  }
  if (particles.fibre && particles.fibre->azimuth_deg.source.origin != Origin::standard && !particles.fibre->tilt_deg) {
    refuse(particles.fibre->azimuth_deg.source, ": needs tilt_deg, the angle from up");
  }
}

void Rules::check_body(const Body& body) {
  if (m_shot.is_particles(body)) {
    check_particles(body);
    return;
  }
  const ParticleBody& particles = body.particles;
  const auto refuse_particles = [&](const auto& key) {
    if (key) {
      refuse(key->source, fmt::format(": {} is not of model = \"mpm\", so this body has no particles",
                                      body.material->empty() ? "its material" : *body.material));
    }
  };
  refuse_particles(particles.region);
  refuse_particles(particles.fibre);
  refuse_particles(particles.repeat);
  refuse_particles(particles.grains);
  if (particles.region) {
    return;
  }
  const bool structured =
      std::holds_alternative<BoxShape>(body.shape) || std::holds_alternative<RodShape>(body.shape) ||
      std::holds_alternative<SheetShape>(body.shape) || std::holds_alternative<CylinderShape>(body.shape);
  const auto* mesh = std::get_if<MeshShape>(&body.shape);
  if (body.cells && !structured) {
    refuse(body.cells->source, ": only a box, rod, sheet or cylinder is made of cells; give resolution, an edge in m");
  }
  if (!body.cells && !body.resolution && !(mesh && mesh->is_tet_mesh)) {
    refuse(below(body.source, "resolution"),
           fmt::format(" is missing: give the target edge in m{}", structured ? ", or cells = [nx, ny, nz]" : ""));
  }
  constexpr double MOST_CELLS = 2e7;
  if (body.cells) {
    const auto& n = body.cells->value;
    const double count = static_cast<double>(n[0]) * static_cast<double>(n[1]) * static_cast<double>(n[2]);
    if (count > MOST_CELLS) {
      refuse(body.cells->source, fmt::format(": {:g} cells; at most {:g} are possible", count, MOST_CELLS));
    }
  }
  if (body.shell && mesh && mesh->is_tet_mesh) {
    refuse(body.shell->thickness.source, ": a tet mesh cannot be hollowed; give its surface as mesh, or remove shell");
  }
  if (body.shell && body.cells) {
    refuse(body.shell->thickness.source,
           ": what is made of cells cannot be hollowed; give resolution instead of cells");
  }
  check_mesh_only(body, mesh != nullptr);
  check_element(body);
  if (const auto* torus = std::get_if<TorusShape>(&body.shape); torus && *torus->tube_radius >= *torus->radius) {
    refuse(torus->tube_radius.source, fmt::format(" = {}: expected less than radius = {}, or the ring has no hole",
                                                  *torus->tube_radius, *torus->radius));
  }
}

void Rules::check_mesh_only(const Body& body, bool is_mesh) {
  const char* advice = ": only mesh files have it; primitives are in m and stand as they are, turn them with rotate";
  if (!is_mesh && *body.metres_per_unit != 1.0) {
    refuse(body.metres_per_unit.source, advice);
  }
  if (!is_mesh && body.up) {
    refuse(body.up->source, advice);
  }
}

void Rules::check_element(const Body& body) {
  const Material* material = m_shot.find_material(*body.material);
  if (material == nullptr || !sound(*material)) {
    return;
  }
  const bool plate = *material->model == MaterialModel::plate;
  const bool triangles = *body.element == Element::tri3 || *body.element == Element::tri6;
  if (triangles != plate && *body.element != Element::automatic) {
    refuse(body.element.source, plate ? ": a plate is made of triangles; expected \"tri3\" or \"tri6\""
                                      : ": triangles are elements of plates; expected \"tet4\" or \"tet10\", or "
                                        "material.model = \"plate\"");
  }
  const bool own_kernel = *body.element == Element::tet10 || *body.quadrature == Quadrature::one_point;
  const Located<std::string>& name = material->name;
  if (own_kernel && *material->model != MaterialModel::micropolar) {
    refuse(*body.element == Element::tet10 ? body.element.source : body.quadrature.source,
           fmt::format(": only material.model = \"micropolar\" has it, and '{}' is another", *name));
  }
  if (*body.element == Element::tet10 && *body.quadrature == Quadrature::one_point) {
    refuse(body.quadrature.source, " = \"one-point\": only tet4 can have it");
  }
  if (own_kernel && *material->microrotation == Microrotation::condensed) {
    refuse(material->microrotation.source, " = \"condensed\": only tet4 with full quadrature can have it");
  }
  if (own_kernel || plate) {
    check_linear_tets_only(body, *material);
  }
  if (plate && !material->thickness && !std::holds_alternative<SheetShape>(body.shape)) {
    refuse(below(material->source, "thickness"), " is missing: a plate that is no sheet needs its thickness in m");
  }
  if (plate && body.shell) {
    refuse(body.shell->thickness.source, ": a plate is a surface already; remove shell");
  }
  if (const auto* mesh = std::get_if<MeshShape>(&body.shape); plate && mesh && mesh->is_tet_mesh) {
    refuse(mesh->path.source, ": a plate is made of a surface, not of tets; give an obj, ply, ... file");
  }
}

void Rules::check_linear_tets_only(const Body& body, const Material& material) {
  const char* advice = ": only linear tets with the full quadrature (element = \"tet4\") have it";
  for (const auto* factor : {&material.vary.density, &material.vary.youngs_modulus, &material.vary.couple_modulus_ratio,
                             &material.vary.length_scale}) {
    if (*factor) {
      refuse((*factor)->source, advice);
    }
  }
  for (const auto& turn : body.rest_rotation) {
    if (turn) {
      refuse(turn->source, advice);
    }
  }
  if (*m_shot.fem.point_rotations != PointRotations::velocity) {
    refuse(m_shot.fem.point_rotations.source, advice);
  }
}

void Rules::check_condensed(const Material& material) {
  if (*material.microrotation != Microrotation::condensed) {
    return;
  }
  if (*material.model != MaterialModel::micropolar || *material.length_scale > 0.0 || *material.rotary_inertia > 0.0 ||
      *material.couple_modulus_ratio < 1.0) {
    refuse(material.microrotation.source,
           " = \"condensed\": expected model = \"micropolar\", length_scale = 0, rotary_inertia = 0 and "
           "couple_modulus_ratio >= 1, or the rotation of the matter is not the microrotation of least energy");
  }
}

void Rules::check_plate_only(const Material& material) {
  if (*material.model == MaterialModel::plate) {
    if (*material.curvature.model == CurvatureModel::orthotropic) {
      refuse(material.curvature.model.source, " = \"orthotropic\": plates have the isotropic one");
    }
    if (*material.bending == PlateBending::curv && *material.length_scale == 0.0) {
      refuse(material.bending.source, " = \"curv\" needs length_scale > 0, or nothing resists bending");
    }
    return;
  }
  for (const std::optional<Located<double>>* only : {&material.thickness, &material.max_stretch}) {
    if (*only) {
      refuse((*only)->source, ": only plates have it; write model = \"plate\", or remove it");
    }
  }
}

} // namespace wry::shots
