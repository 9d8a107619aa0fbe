#pragma once

#include <string>
#include <vector>

#include "sim/base/result.h"

namespace wry::pipeline {

/// What a program of the system said.
struct CapturedProgram {
  int exit_code = 0;
  std::string out; ///< stdout
  std::string err; ///< stderr
};

/// Runs a program found in PATH without a shell, gives it `input`, and waits. Errors: unavailable when there is no such
/// program; io.
Result<CapturedProgram> run_program(const std::vector<std::string>& words, const std::string& input = {});

} // namespace wry::pipeline
