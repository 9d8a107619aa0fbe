#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "sim/base/parallel.h"
#include "sim/base/result.h"
#include "sim/contact/broad_phase.h"
#include "sim/contact/distance.h"
#include "sim/contact/safe_step.h"
#include "sim/fem/fem_scene.h"

namespace wry::fem {

/// A pair of primitives closer than its d-hat.
struct ContactPair {
  contact::PairKind kind = contact::PairKind::point_triangle;
  std::array<std::int32_t, 4> nodes = {}; ///< obstacles' nodes follow the unknowns'
  std::int32_t parts[2] = {0, 0};
  double activation = 0.0;          ///< d-hat of this pair [m]
  double thickness = 0.0;           ///< what of its distance is matter of plates and thick sheets, and no gap [m]
  double mollifier_threshold = 0.0; ///< of edges, else 0
};

/// Pairs of primitives of bodies and obstacles: who may touch whom, where obstacles are, who is near whom now, and how
/// far a step may go. Pure geometry stays in sim/contact; energies in the terms that read this.
class ContactSystem {
public:
  /// nullptr when nothing but planes can touch: no [contact] and no obstacle. Errors: bad_input naming the first two
  /// things that intersect or touch at the start.
  static Result<std::unique_ptr<ContactSystem>> create(const FemPlan& plan, const FemScene& scene, double distance,
                                                       const Threads& threads, Isa isa);

  /// Obstacles go back to where they are at the start of the step, and are to go to where they are at its end.
  void begin_step(double start_time, double end_time);
  /// How far nodes are expected to go per step from here on [m]: saves searches, and changes no result.
  void expect_ways(const Points& ways);
  /// Moves obstacles as far along their way as is safe. Returns the share of the way that is left.
  double advance_obstacles(const Points& positions);

  /// The pairs closer than their d-hat, in a fixed order.
  const std::vector<ContactPair>& pairs_at(const Points& positions);
  /// The place of each node of a pair as pairs_at last saw it.
  contact::PairPoints points_of(const ContactPair& pair) const;
  /// How far each node of a pair has come since the start of the step, obstacles too.
  contact::PairPoints way_of(const ContactPair& pair, const Points& positions, const Points& start_positions) const;
  /// The fraction of a change of positions that is proven to keep everything apart.
  double step_limit(const Points& positions, const Points& change);

  const Threads& threads() const { return m_threads; }
  bool is_unknown(int node) const { return node < m_unknown_nodes; }
  double stiffness(const ContactPair& pair) const { return m_stiffness[slot(pair.parts[0], pair.parts[1])]; }
  const Friction& friction(const ContactPair& pair) const { return m_friction[slot(pair.parts[0], pair.parts[1])]; }
  bool any_friction() const;
  bool has_obstacles() const { return !m_obstacles.empty(); }
  double distance() const { return m_distance; }

  /// Contacts of the state, for statistics and for adapting the stiffness.
  struct Gaps {
    double least = 0.0; ///< [m]; infinity when nothing is near
    int active = 0;
  };
  Gaps measure(const Points& positions);
  /// Makes the barriers of parts stiffer whose least gap is below this share of d-hat.
  void stiffen_crowded(const Points& positions, double share, double factor);

  /// Makes the barrier of the parts stiffer that limited the last step.
  void stiffen_limiting(double factor);

  /// What must survive a checkpoint.
  std::vector<double>& stiffnesses() { return m_stiffness; }
  const std::vector<double>& stiffnesses() const { return m_stiffness; }
  /// Obstacles stand where they are at that time.
  void place_obstacles(double time);
  /// The pair that limited the last step, in words; empty when nothing did.
  std::string describe_limit() const;

  /// Wall time since the last call [ms].
  struct Cost {
    double search_ms = 0.0; ///< broad phase, and which candidates are near
    double safe_step_ms = 0.0;
  };
  Cost take_cost();
  std::size_t candidate_count() const;
  std::size_t memory_bytes() const;

private:
  /// Gaps below this many units in the last place of the positions could be closed by rounding the positions alone.
  static constexpr double ROUNDING_UNITS = 32.0;

  struct Obstacle {
    const scene::Collider* collider;
    int first_node = 0; ///< in the numbering of all nodes
    Points rest;
  };

  ContactSystem(const FemPlan& plan, const FemScene& scene, double distance, const Threads& threads, Isa isa);
  Status add_parts();
  void choose_coefficients();
  Status check_start();
  std::string part_name(int part) const;
  std::size_t slot(int a, int b) const;
  void stiffen(std::size_t slot, double factor);
  void pose_obstacles(double time, Points& out) const;
  const Points& all_positions(const Points& positions);
  void update_pairs();
  void add_near_pairs(contact::PairGroup group, contact::PairKind kind);
  double rest_limit(contact::PairKind kind, const std::array<std::int32_t, 4>& nodes) const;
  double thickness_of(contact::PairKind kind, const std::array<std::int32_t, 4>& nodes) const;
  Status check_thickness() const;
  double safe_fraction(const Points& from, const Points& to);

  const FemPlan& m_plan;
  const FemScene& m_scene;
  double m_distance;
  double m_room = 0.0; ///< that nodes get before candidates are searched again [m]
  const Threads& m_threads;
  Isa m_isa;
  contact::CcdTable m_ccd;
  int m_unknown_nodes = 0;
  contact::Surface m_surface;
  std::unique_ptr<contact::BroadPhase> m_broad_phase;
  std::vector<Obstacle> m_obstacles;
  Points m_rest; ///< of all nodes
  Points m_all;  ///< of all nodes now
  Points m_from, m_to;
  Points m_obstacle_start, m_obstacle_end; ///< rows of obstacles only
  double m_obstacle_share = 1.0;
  std::vector<double> m_half_thickness;  ///< of parts: plates, and open meshes that are thick [m]
  double m_most_thickness = 0.0;         ///< of two parts that may meet [m]
  std::vector<double> m_edge_squares;    ///< squared rest lengths of the surface's edges
  std::vector<double> m_stiffness;       ///< parts x parts [N/m]
  std::vector<double> m_least_stiffness; ///< as chosen from the scene: what it grows from
  std::vector<Friction> m_friction;      ///< parts x parts
  std::vector<ContactPair> m_pairs;
  std::vector<std::vector<ContactPair>> m_chunks;
  Points m_pairs_at;              ///< where the pairs hold
  contact::Ways m_since_measured; ///< ways of all nodes since the candidates' distances were measured
  contact::SafeStep m_last_limit;
  Cost m_cost;
};

} // namespace wry::fem
