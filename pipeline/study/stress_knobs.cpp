#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "pipeline/study/stress.h"

namespace wry::pipeline {

namespace {

using shots::Ladder;

std::string number_text(double value) {
  return fmt::format("{:.12g}", value + 0.0); // no -0
}

Ladder at(std::string key, const std::vector<double>& values) {
  Ladder knob{std::move(key), {}, {}, {}};
  for (const double value : values)
    knob.values.push_back(number_text(value));
  return knob;
}

Ladder times(std::string key, double own, const std::vector<double>& factors) {
  std::vector<double> values = factors;
  for (double& value : values)
    value *= own;
  return at(std::move(key), values);
}

/// A value that is a table or list, written anew for each factor.
template <class Text> Ladder written(std::string key, const std::vector<double>& factors, const Text& text) {
  Ladder knob{std::move(key), {}, {}, {}};
  for (const double factor : factors) {
    knob.values.push_back(text(factor));
    knob.labels.push_back(fmt::format("x {:g}", factor));
  }
  return knob;
}

Ladder per_axis(const std::string& key, const shots::PerAxis& own, const std::vector<double>& factors) {
  if (!own.is_table)
    return times(key, *own.values[0], factors);
  return written(key, factors, [&](double factor) {
    return fmt::format("{{ x = {}, y = {}, z = {} }}", number_text(factor * *own.values[0]),
                       number_text(factor * *own.values[1]), number_text(factor * *own.values[2]));
  });
}

Ladder rest_curvature(const std::string& key, const shots::Material& material) {
  return written(key, {10.0, 100.0}, [&](double factor) {
    std::string text;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t direction = 0; direction < 3; ++direction) {
        if (const auto& entry = material.rest_curvature[axis][direction])
          text += fmt::format("{}{}{} = \"{:g}*({})\"", text.empty() ? "" : ", ", "xyz"[axis], "xyz"[direction], factor,
                              (*entry) -> text);
      }
    }
    return "{ " + text + " }";
  });
}

Ladder faster(const std::string& key, const shots::Motion& motion) {
  return written(key, {10.0, 100.0}, [&](double factor) {
    std::string text;
    for (const shots::MotionKey& at : motion.keys)
      text += fmt::format("{}{{ time = {}, translate = [{}, {}, {}], axis = [{}, {}, {}], degrees = {} }}",
                          text.empty() ? "" : ", ", number_text(*at.time / factor), number_text(at.translate[0]),
                          number_text(at.translate[1]), number_text(at.translate[2]), number_text(at.axis[0]),
                          number_text(at.axis[1]), number_text(at.axis[2]), number_text(at.degrees));
    return "[" + text + "]";
  });
}

bool moves(const shots::Motion& motion) {
  return std::any_of(motion.keys.begin(), motion.keys.end(), [](const shots::MotionKey& key) { return *key.time > 0; });
}

/// Knobs in two lists: those worth turning in pairs, and the rest.
class KnobFinder {
public:
  explicit KnobFinder(const shots::Shot& shot)
      : m_shot(shot) {}
  ShotKnobs find() {
    for (const shots::Material& material : m_shot.materials) {
      if (!is_used(material))
        continue;
      const bool particles = *material.model == shots::MaterialModel::mpm;
      (particles ? m_particles : m_solids) = true;
      if (particles)
        add_matter(material);
      else
        add_solid(material);
    }
    add_scene();
    add_methods();
    ShotKnobs found{std::move(m_main), 0};
    constexpr std::size_t MOST_PAIRED = 8;
    found.paired = std::min(found.knobs.size(), MOST_PAIRED);
    found.knobs.insert(found.knobs.end(), m_more.begin(), m_more.end());
    return found;
  }

private:
  bool is_used(const shots::Material& material) const {
    return std::any_of(m_shot.bodies.begin(), m_shot.bodies.end(),
                       [&](const shots::Body& body) { return *body.material == *material.name; });
  }
  void add_solid(const shots::Material& material) {
    const std::string key = "material." + *material.name;
    m_main.push_back(times(key + ".youngs_modulus", *material.youngs_modulus, {1e-4, 1e-2, 1e2, 1e4, 1e6}));
    m_main.push_back(at(key + ".poisson_ratio", {-0.9, 0.0, 0.45, 0.49, 0.499, 0.4999, 0.5}));
    m_main.push_back(times(key + ".density", *material.density, {1e-3, 1e-1, 1e1, 1e3}));
    const bool micropolar = shots::is_micropolar(*material.model);
    if (micropolar)
      m_main.push_back(at(key + ".couple_modulus_ratio", {1e-6, 1e-3, 1e3, 1e6}));
    if (micropolar || *material.model == shots::MaterialModel::plate)
      m_main.push_back(at(key + ".length_scale", {0.0, 1e-9, 1.0, 1e3}));
    if (material.has_rest_curvature())
      m_more.push_back(rest_curvature(key + ".rest_curvature", material));
  }
  void add_matter(const shots::Material& material) {
    const std::string key = "material." + *material.name;
    const shots::Matter& matter = material.matter;
    m_main.push_back(per_axis(key + ".youngs_modulus", matter.youngs_modulus, {1e-4, 1e-2, 1e2, 1e4}));
    m_main.push_back(times(key + ".density", *material.density, {1e-2, 1e-1, 1e1, 1e2}));
    if (matter.youngs_modulus.is_table)
      m_main.push_back(times(key + ".youngs_modulus.z", *matter.youngs_modulus.values[2], {1e-2, 1e-1, 1e1, 1e2}));
    if (*matter.plasticity != shots::Plasticity::none && matter.plastic_scale.is_table)
      m_main.push_back(times(key + ".plastic_scale.z", *matter.plastic_scale.values[2], {0.1, 0.3, 3.0, 10.0}));
    if (*matter.plasticity == shots::Plasticity::drucker_prager)
      m_more.push_back(at(key + ".friction_angle", {1.0, 20.0, 60.0, 89.0}));
  }
  void add_scene() {
    const Vec3& gravity = *m_shot.shot.gravity;
    if (gravity.norm() > 0.0)
      m_main.push_back(written("shot.gravity", {0.0, 10.0, 100.0}, [&](double factor) {
        return fmt::format("[{}, {}, {}]", number_text(factor * gravity[0]), number_text(factor * gravity[1]),
                           number_text(factor * gravity[2]));
      }));
    for (const shots::Collider& collider : m_shot.colliders)
      m_more.push_back(at("collider." + *collider.name + ".friction", {0.0, 0.5, 1.0, 10.0}));
    if (m_shot.contact)
      m_more.push_back(at("contact.friction", {0.0, 0.5, 1.0, 10.0}));
    for (const shots::Drive& drive : m_shot.drives) {
      if (moves(drive.motion))
        m_more.push_back(faster("drive." + *drive.name + ".keys", drive.motion));
    }
    for (const shots::Collider& collider : m_shot.colliders) {
      if (moves(collider.motion))
        m_more.push_back(faster("collider." + *collider.name + ".keys", collider.motion));
    }
  }
  void add_methods() {
    if (m_solids) {
      m_main.push_back(at("fem.time_step", {1e-3, 1e-2, 1e-1, 1.0}));
      for (const shots::Body& body : m_shot.bodies) {
        if (body.resolution)
          m_more.push_back(times("body." + *body.name + ".resolution", **body.resolution, {0.7, 2.0, 4.0}));
      }
    }
    if (m_particles) {
      m_main.push_back(at("mpm.time_step", {1e-4, 1e-3, 1e-2}));
      if (m_shot.mpm.cell_size)
        m_main.push_back(times("mpm.cell_size", **m_shot.mpm.cell_size, {0.7, 2.0, 4.0}));
    }
  }

  const shots::Shot& m_shot;
  bool m_solids = false, m_particles = false;
  std::vector<Ladder> m_main, m_more;
};

} // namespace

ShotKnobs knobs_of(const shots::Shot& shot) {
  return KnobFinder(shot).find();
}

} // namespace wry::pipeline
