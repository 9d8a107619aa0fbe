#pragma once

namespace wry::pipeline {

/// Whether this process was started as an import process; main asks before anything else.
bool is_import_child(int argc, char** argv);

/// Reads one mesh file with as few rights as that takes, and writes the answer to IMPORT_ANSWER_FD. Returns the exit
/// code of the process; main must do nothing else.
int import_child_main(int argc, char** argv);

} // namespace wry::pipeline
