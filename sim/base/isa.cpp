#include "sim/base/isa.h"

#include <array>

namespace wry {

namespace {

constexpr std::array ISAS = {Isa::sse4, Isa::avx2, Isa::avx512};

} // namespace

Isa native_isa() {
  if (__builtin_cpu_supports("x86-64-v4"))
    return Isa::avx512;
  if (__builtin_cpu_supports("x86-64-v3"))
    return Isa::avx2;
  return Isa::sse4;
}

std::string_view isa_name(Isa isa) {
  switch (isa) {
  case Isa::sse4:
    return "sse4";
  case Isa::avx2:
    return "avx2";
  case Isa::avx512:
    return "avx512";
  }
  return "?";
}

Result<Isa> parse_isa(std::string_view name) {
  if (name == "auto")
    return native_isa();
  for (const Isa isa : ISAS) {
    if (isa_name(isa) != name)
      continue;
    if (isa > native_isa())
      return make_error(ErrorCode::unavailable, "--isa {}: this machine has no more than {}", name,
                        isa_name(native_isa()));
    return isa;
  }
  return make_error(ErrorCode::usage, "--isa {}: expected auto, sse4, avx2 or avx512", name);
}

} // namespace wry
