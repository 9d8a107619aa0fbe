#pragma once

#include "sim/base/result.h"

namespace wry::pipeline {

/// Makes SIGTERM and SIGINT ask for a stop instead of ending the process; a second one ends it at once with exit
/// code 75. Also makes SIGPIPE and SIGXFSZ errors of the call that caused them (a closed pipe, a limit on the size of
/// files). Called once, by main. Errors: io.
Status install_stop_signals();

/// Whether a stop was asked for. Long loops look at it between steps, finish what must be whole, and return
/// stopped_by_signal().
bool stop_requested();

/// The error of a run that stopped when asked: which signal, and `what` was kept, e.g. "frame 12 of 120 is the last".
Error stopped_by_signal(const std::string& what);

/// As if no signal had come; for tests.
void clear_stop_request();

} // namespace wry::pipeline
