#pragma once

#include <string>
#include <string_view>

#include "sim/base/result.h"

namespace wry {

/// Instruction sets that hot kernels are compiled for; the bits of a result are promised per set.
enum class Isa { sse4, avx2, avx512 };

/// The widest set that this processor and operating system can run.
Isa native_isa();

/// "sse4", "avx2" or "avx512".
std::string_view isa_name(Isa isa);

/// The set of that name ("auto" means native_isa()). Errors: usage for an unknown name, unavailable if it cannot run
/// here.
Result<Isa> parse_isa(std::string_view name);

} // namespace wry
