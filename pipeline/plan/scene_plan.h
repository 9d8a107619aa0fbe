#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/measure/measure.h"
#include "shots/shot.h"
#include "sim/sim_plan.h"

namespace wry::pipeline {

/// A file that the shot reads, with what it held.
struct Asset {
  std::string path;
  std::string sha256;
};

/// How a body was meshed, for people.
struct BodyReport {
  std::string name;
  std::string source; ///< "mesh meshes/bunny.obj", "box", ...
  std::string model;
  Vec3 size = Vec3::Zero();                          ///< extents of its rest shape [m]
  std::size_t particles = 0, bytes_per_particle = 0; ///< of the material point method
  std::size_t tets = 0, nodes = 0, dofs = 0, surface_triangles = 0;
  double volume = 0.0; ///< [m^3]
  double mass = 0.0;   ///< [kg]
  double min_dihedral_deg = 0.0, max_dihedral_deg = 0.0;
  double min_edge = 0.0, mean_edge = 0.0; ///< [m]
  std::vector<std::string> notes;         ///< fall-backs, places, warnings
};

struct ScenePlan;

/// What a scene would take more of with a part that it leaves out, predicted.
struct Saving {
  double seconds = 0.0;
  double memory_bytes = 0.0, disk_bytes = 0.0;
};

/// A part of the program that this scene runs, or does not, and why.
struct PlanLine {
  std::string what;
  std::string why;
  std::function<void(ScenePlan&)> with = {}; ///< of what is left out: puts it in; empty: it would take next to nothing
  std::optional<Saving> saving = {};         ///< of what is left out, once describe_savings() was asked
};

/// What a part of a shot takes, and how the shot is told to take less.
struct CostShare {
  std::string what; ///< in the plural: "the 48510 particles of body load"
  std::string cure; ///< "a larger mpm.cell_size needs less"
  std::uint64_t memory_bytes = 0, disk_bytes = 0;
};

/// What a shot costs, predicted.
struct CostEstimate {
  std::uint64_t memory_bytes = 0;    ///< the process that simulates, at its largest
  std::uint64_t bytes_per_frame = 0; ///< of the frame cache
  std::uint64_t bytes_per_checkpoint = 0;
  double checkpoints_kept = 0.0;
  std::uint64_t field_bytes = 0; ///< of all frames: what mpm.keep_fields keeps
  std::vector<CostShare> shares; ///< what takes most of memory and disk; not all of it
  double seconds_per_step = 0.0;
  double newton_directions = 0.0;     ///< linear systems of the whole shot
  double seconds_of_directions = 0.0; ///< of all of them, once describe_solver() was asked; not in seconds_per_step
  double steps = 0.0;                 ///< of the whole shot
  double time_step = 0.0;             ///< the shorter of both methods' [s]

  /// CPU time of the whole shot [s].
  double seconds() const { return steps * seconds_per_step + seconds_of_directions; }

  /// Frames, fields, and the checkpoints that are there at the end.
  std::uint64_t disk_bytes(double frame_count) const {
    return static_cast<std::uint64_t>(frame_count * static_cast<double>(bytes_per_frame) +
                                      checkpoints_kept * static_cast<double>(bytes_per_checkpoint)) +
           field_bytes;
  }
};

/// Everything that is decided before anything runs: the simulation's plan, the measures, and what to tell the user.
struct ScenePlan {
  std::string name;
  SimPlan sim;
  std::vector<int> frames;             ///< that are asked for
  std::vector<std::string> body_looks; ///< per body of sim; empty: the default look
  std::vector<MeasurePlan> measures;
  std::vector<bool> measure_is_relative; ///< per measure: divided by its first frame's value
  std::vector<Asset> assets;
  std::string simulation_key; ///< SHA-256 of all that the frames depend on
  std::string matter_key;     ///< the same without what grains alone depend on
  std::vector<BodyReport> bodies;
  CostEstimate cost;
  std::vector<PlanLine> runs;
  std::vector<PlanLine> left_out;
  std::vector<std::string> warnings;
};

/// What the machine and the command line add to a shot.
struct PlanOptions {
  std::vector<int> frames; ///< that are asked for, ascending
  Isa isa = Isa::sse4;
  std::string shared; ///< folder of meshes that processes share; empty: none
};

/// Imports and meshes every asset and compiles the shot. Errors: whatever an asset or a value can be wrong about, with
/// file:line of the key.
Result<ScenePlan> compile_scene(const shots::Shot& shot, const PlanOptions& options);

} // namespace wry::pipeline
