#pragma once

#include <vector>

#include "sim/base/isa.h"

namespace wry::test {

/// The instruction sets that this machine can run.
inline std::vector<Isa> runnable_isas() {
  std::vector<Isa> isas;
  for (const Isa isa : {Isa::sse4, Isa::avx2, Isa::avx512}) {
    if (isa <= native_isa())
      isas.push_back(isa);
  }
  return isas;
}

} // namespace wry::test
