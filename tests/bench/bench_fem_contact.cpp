// The twisting mat: 960 cells of 12 tets, one thick, wound up from both ends by 72 degrees per second until it folds
// over itself, in steps of 10 ms. Milliseconds per step by phase, over spans of half a second, as CSV; `over_limit`
// counts the steps that took more than 200 ms. The last column is a hash of all bits of the state, which must not
// depend on the number of threads. Usage: bench_fem_contact [seconds [threads [from [steps [isa]]]]]:
// numbers of steps before `from` seconds are not printed; `steps` is a file for a row per step; isa is auto, sse4, avx2
// or avx512.

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "sim/fem/fem_simulation.h"
#include "sim/geometry/structured_tets.h"

namespace {

using namespace wry;
using namespace wry::fem;

constexpr double TIME_STEP = 0.01;
constexpr double SPAN = 0.5;
constexpr double LIMIT_MS = 200.0;

FemPlan make_mat() {
  FemPlan plan;
  plan.gravity.setZero();
  const Result<geometry::TetMesh> mesh =
      geometry::make_block_tets(geometry::box_block(Vec3(1.0, 0.01, 0.6)), {{40, 1, 24}, geometry::CellSplit::twelve});
  FemBody body;
  body.name = "mat";
  body.mesh = std::make_shared<geometry::TetMesh>(mesh.value());
  body.material.youngs_modulus = 2e4;
  body.material.poisson_ratio = 0.4;
  for (const double side : {-1.0, 1.0}) {
    DrivenNodes drive;
    drive.name = side < 0.0 ? "left" : "right";
    for (Eigen::Index i = 0; i < body.mesh->vertices.rows(); ++i) {
      if (std::abs(body.mesh->vertices(i, 0) - 0.5 * side) < 1e-9)
        drive.nodes.push_back(static_cast<std::int32_t>(i));
    }
    drive.motion = *scene::Motion::along_keys(
        {{{0.0, Vec3::Zero(), Vec3::UnitX(), 0.0}, {100.0, Vec3::Zero(), Vec3::UnitX(), -side * 7200.0}},
         Vec3(0.5 * side, 0, 0)});
    plan.driven.push_back(std::move(drive));
  }
  plan.bodies.push_back(std::move(body));
  plan.contact = ContactOptions{};
  plan.settings.max_time_step = TIME_STEP;
  plan.settings.newton_tolerance = 1e-6; // N s, of 6 kg
  return plan;
}

/// FNV-1a of all numbers of a state.
std::uint64_t hash_of(const StateArchive& archive) {
  std::uint64_t hash = 1469598103934665603ULL;
  for (const NamedArray& array : archive) {
    for (const double value : array.values) {
      unsigned char bytes[sizeof(double)];
      std::memcpy(bytes, &value, sizeof(double));
      for (const unsigned char byte : bytes)
        hash = (hash ^ byte) * 1099511628211ULL;
    }
  }
  return hash;
}

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

} // namespace

int main(int count, char** arguments) {
  const double seconds = count > 1 ? std::atof(arguments[1]) : 5.0;
  const int threads = count > 2 ? std::atoi(arguments[2]) : 1;
  const double from = count > 3 ? std::atof(arguments[3]) : 0.0;
  const Result<Isa> isa = parse_isa(count > 5 ? arguments[5] : "auto");
  if (!isa) {
    std::fprintf(stderr, "%s\n", isa.error().message.c_str());
    return 2;
  }
  std::FILE* rows = count > 4 ? std::fopen(arguments[4], "w") : nullptr;
  if (rows != nullptr)
    std::fprintf(rows, "time_s,newton,projected,contacts,evaluate_ms,assemble_ms,solve_ms,search_ms,safe_step_ms,"
                       "total_ms\n");
  char machine[256] = "unknown";
  gethostname(machine, sizeof(machine) - 1);
  const FemPlan plan = make_mat();
  Result<std::unique_ptr<FemSimulation>> simulation = FemSimulation::create(plan, threads, *isa);
  if (!simulation) {
    std::fprintf(stderr, "%s\n", simulation.error().message.c_str());
    return 1;
  }
  std::printf("machine,tets,threads,time_s,newton_per_step,contacts,cpu_ms_per_step,ms_per_step,longest_ms,over_limit,"
              "evaluate_ms,assemble_ms,solve_ms,search_ms,safe_step_ms,detection_share,hash\n");
  for (double end = SPAN; end < seconds + 0.5 * SPAN; end += SPAN) {
    StepStats sum;
    int steps = 0;
    int over_limit = 0;
    double longest = 0.0;
    const double cpu_start = cpu_seconds();
    while ((*simulation)->time() < end - 1e-9) {
      const Result<StepStats> stats = (*simulation)->step(end);
      if (!stats) {
        std::fprintf(stderr, "%s\n", stats.error().message.c_str());
        return 1;
      }
      ++steps;
      over_limit += stats->total_ms > LIMIT_MS ? 1 : 0;
      sum.newton_iterations += stats->newton_iterations;
      sum.contacts = std::max(sum.contacts, stats->contacts);
      sum.evaluate_ms += stats->evaluate_ms;
      sum.assemble_ms += stats->assemble_ms;
      sum.solve_ms += stats->solve_ms;
      sum.contact_search_ms += stats->contact_search_ms;
      sum.safe_step_ms += stats->safe_step_ms;
      sum.total_ms += stats->total_ms;
      longest = std::max(longest, stats->total_ms);
      if (rows != nullptr)
        std::fprintf(rows, "%.2f,%d,%d,%d,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f\n", stats->time, stats->newton_iterations,
                     stats->projected_elements, stats->contacts, stats->evaluate_ms, stats->assemble_ms,
                     stats->solve_ms, stats->contact_search_ms, stats->safe_step_ms, stats->total_ms);
    }
    if (end < from)
      continue;
    const double n = steps;
    std::printf("%s,%td,%d,%.2f,%.1f,%d,%.1f,%.1f,%.1f,%d,%.1f,%.1f,%.1f,%.1f,%.1f,%.3f,%016llx\n", machine,
                static_cast<std::ptrdiff_t>(plan.bodies[0].mesh->tets.rows()), threads, end, sum.newton_iterations / n,
                sum.contacts, 1e3 * (cpu_seconds() - cpu_start) / n, sum.total_ms / n, longest, over_limit,
                sum.evaluate_ms / n, sum.assemble_ms / n, sum.solve_ms / n, sum.contact_search_ms / n,
                sum.safe_step_ms / n, (sum.contact_search_ms + sum.safe_step_ms) / sum.total_ms,
                static_cast<unsigned long long>(hash_of((*simulation)->archive())));
    std::fflush(stdout);
  }
  if (rows != nullptr)
    std::fclose(rows);
  return 0;
}
