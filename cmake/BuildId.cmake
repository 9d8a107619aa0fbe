# Run as a script: writes OUTPUT, a C++ file with the version and a hash of the sources that frames and pictures depend on,
# so that a cache knows which build made it. Touches OUTPUT only when something changed.
set(ids)
foreach(part sim render)
  file(GLOB_RECURSE sources ${SOURCE_DIR}/${part}/*.cpp ${SOURCE_DIR}/${part}/*.h)
  list(SORT sources)
  set(all "")
  foreach(source IN LISTS sources)
    file(SHA256 ${source} one)
    string(APPEND all ${one})
  endforeach()
  string(SHA256 all "${all}")
  string(SUBSTRING ${all} 0 12 id_${part})
endforeach()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [[
#include "pipeline/plan/build_id.h"

namespace wry::pipeline {

std::string_view version() { return "@VERSION@"; }
std::string_view simulation_build() { return "@id_sim@"; }
std::string_view render_build() { return "@id_render@"; }

} // namespace wry::pipeline
]])
