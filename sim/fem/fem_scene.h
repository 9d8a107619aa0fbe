#pragma once

#include <memory>
#include <vector>

#include "sim/base/isa.h"
#include "sim/base/parallel.h"
#include "sim/base/result.h"
#include "sim/fem/body_elements.h"
#include "sim/fem/fem_model.h"
#include "sim/fem/fem_plan.h"
#include "sim/fem/mesh_order.h"

namespace wry::fem {

/// A plan turned into arrays: nodes of all bodies in one numbering, element batches, masses, and where each body
/// starts.
struct FemScene {
  FemModel model;
  std::vector<OrderedMesh> meshes;                     ///< per body
  std::vector<std::unique_ptr<BodyElements>> elements; ///< per body
  Points start_positions;                              ///< rest positions, lifted off planes that bodies touch [m]
  std::vector<double> edges;                           ///< mean edge length of each body [m]
  double suggested_contact_distance = 0.0;             ///< d-hat [m]
};

/// Errors: bad_input naming the body and the vertex, tet, key or number that is wrong.
Result<FemScene> build_scene(const FemPlan& plan, Isa isa, const Threads& threads);

/// Nodes of the simulation for vertices of a body's mesh.
std::vector<int> nodes_of(const FemScene& scene, int body, const std::vector<std::int32_t>& vertices);

/// Checks what does not need arrays: finite numbers in range, indices, materials that are not singular.
Status check_plan(const FemPlan& plan);

/// Lifts bodies that touch a plane (gap under a tenth of d-hat) to where the barrier carries their weight.
/// Errors: bad_input naming the body that starts below a plane, and how deep.
Status clear_planes(const FemPlan& plan, const ContactState& contact, FemScene& scene);

/// kappa of each body from its stiffness, weight and d-hat, unless the plan gives one.
std::vector<double> choose_contact_stiffness(const FemPlan& plan, const FemScene& scene, double distance);

} // namespace wry::fem
