#include "pipeline/assets/scene_decoder.h"

namespace wry::pipeline {

Result<RawMesh> decode_scene(const MeshFile& file) {
  return make_error(ErrorCode::unavailable,
                    "this build has no assimp and reads PLY only, not .{}; configure with -DWRY_WITH_ASSIMP=ON",
                    file.extension);
}

} // namespace wry::pipeline
