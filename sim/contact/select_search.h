#pragma once

#include "sim/base/isa.h"
#include "sim/contact/search_kernels.h"

namespace wry::contact {

/// The functions of an instruction set.
SearchTable select_search(Isa isa);

} // namespace wry::contact
