#include "tests/fem/solvers_of_this_build.h"

namespace wry::fem {

std::vector<LinearSolver> solvers_of_this_build() {
  return {LinearSolver::pcg};
}

} // namespace wry::fem
