#include "sim/contact/select_search.h"

namespace wry::contact {

SearchTable select_search(Isa isa) {
  switch (isa) {
  case Isa::avx512:
    return avx512::search_table();
  case Isa::avx2:
    return avx2::search_table();
  case Isa::sse4:
    break;
  }
  return sse4::search_table();
}

} // namespace wry::contact
