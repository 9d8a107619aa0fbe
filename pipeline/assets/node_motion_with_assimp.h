#pragma once

#include <string>

#include "pipeline/assets/import_protocol.h"
#include "sim/base/result.h"

struct aiScene;

namespace wry::pipeline {

/// Where the node of that name, or the first camera when the name is empty, is over the file's first animation, with
/// all that moves above it; sampled so finely that going straight from sample to sample is as good. Errors: bad_input
/// for a node that is not there, with the names there are. `extension` is the
/// file's, in lower case: what assimp says of cameras depends on it.
Result<RawMotion> read_node_motion(const aiScene& scene, const std::string& node, const std::string& extension);

} // namespace wry::pipeline
