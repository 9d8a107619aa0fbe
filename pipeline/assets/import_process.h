#pragma once

#include <string>
#include <vector>

#include "pipeline/assets/import_protocol.h"
#include "pipeline/assets/sandbox.h"
#include "sim/base/result.h"

namespace wry::pipeline {

/// The first argument that makes our own program an import process; not for users.
inline constexpr const char* IMPORT_VERB = "__import";

/// The file descriptor on which an import process answers.
inline constexpr int IMPORT_ANSWER_FD = 3;

/// What to run.
struct ImportProcess {
  std::string program; ///< empty: this very program (/proc/self/exe), whose main must call import_child_main
  std::string path;    ///< of the mesh file
  std::string node;    ///< empty: all of it
  ImportWhat what = ImportWhat::mesh;
  SandboxLimits limits;
};

/// Runs the process and gives back what it answered, at most `limits.memory_bytes`. Errors: bad_input naming the signal
/// or the limit when it was killed, io when it could not be started.
Result<std::string> run_import_process(const ImportProcess& process);

} // namespace wry::pipeline
