#pragma once

namespace wry::pipeline {

/// Parses the command line, runs the verb, prints its error. Returns the exit code of design §3.
int run_command_line(int argc, char** argv);

} // namespace wry::pipeline
