#pragma once

#include <string>
#include <utility>

#include "shots/diagnostics.h"
#include "shots/shot.h"

namespace wry::shots {

/// Rules that need more than one key; each looks only at things whose keys are all right by themselves.
class Rules {
public:
  Rules(const Shot& shot, Diagnostics& diagnostics)
      : m_shot(shot)
      , m_diagnostics(diagnostics) {}

  void check();

private:
  template <class Item> bool sound(const Item& item) const { return !m_diagnostics.any_under(item.source.key); }

  void refuse(Source source, std::string message) { m_diagnostics.add(std::move(source), std::move(message)); }
  static Source below(Source source, const std::string& key) {
    source.key += "." + key;
    return source;
  }

  /// Keys of one method on a body of the other.
  void check_particles(const Body& body);
  void check_body(const Body& body);
  void check_mesh_only(const Body& body, bool is_mesh);
  void check_collider(const Collider& collider);
  void check_container(const OpenBoxShape& box, const Source& source);
  void check_motion(const Motion& motion);
  void check_element(const Body& body);
  void check_linear_tets_only(const Body& body, const Material& material);
  void check_condensed(const Material& material);
  void check_plate_only(const Material& material);
  void check_material(const Material& material);
  void check_isotropic(const Curvature& curvature);
  void check_orthotropic(const Curvature& curvature);
  void check_basis(const Located<Mat3>& basis);
  void check_region(const Region& region);
  void check_drive(const Drive& drive);
  const Material* material_of(const std::string& body_name) const;
  void check_load(const Load& load);
  void need_body(const std::string& body, const Source& source);
  void check_measure(const Measure& measure);
  void check_expectation(const Expectation& expectation);
  /// A frame that a run never comes to would never be judged. A range that the command line cuts says so as it runs.
  void check_expected_frame(const Located<std::int64_t>& frame);
  void check_settings();

  const Shot& m_shot;
  Diagnostics& m_diagnostics;
};

} // namespace wry::shots
