#include <array>

#include "pipeline/run/engines/engine.h"

namespace wry::pipeline {

namespace {

constexpr std::array KINDS = {
    EngineKind{"local", "processes on this machine, --jobs at a time", make_local_engine},
    EngineKind{"slurm", "job arrays of the Slurm that sbatch reaches", make_slurm_engine},
};

} // namespace

std::span<const EngineKind> engine_kinds() {
  return KINDS;
}

Result<std::unique_ptr<Engine>> make_engine(std::string_view name) {
  std::string known;
  for (const EngineKind& kind : engine_kinds()) {
    if (kind.name == name)
      return kind.make();
    known += (known.empty() ? "" : ", ") + std::string(kind.name);
  }
  return make_error(ErrorCode::usage,
                    "--engine {}: there is no such engine; expected one of {}; for another farm, "
                    "`--list --json` prints the jobs",
                    name, known);
}

} // namespace wry::pipeline
