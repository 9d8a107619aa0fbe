#pragma once

#include <string>

namespace wry::pipeline {

/// "2 h 03 min", "4 min 10 s", "12 s".
std::string human_duration(double seconds);

/// "1.2 GiB", "340 MiB", "12 KiB".
std::string human_bytes(double bytes);

/// The host, its processor and how many cores it has: whatever a time depends on.
std::string machine_name();

} // namespace wry::pipeline
