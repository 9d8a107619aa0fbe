#pragma once

#include <new>
#include <string>

#include "sim/base/result.h"

namespace wry::pipeline {

/// What `call` returns (a Result), or out_of_memory naming `what` when an allocation fails in it.
template <class Call> auto or_out_of_memory(const std::string& what, const Call& call) -> decltype(call()) {
  try {
    return call();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, "not enough memory for " + what};
  }
}

} // namespace wry::pipeline
