#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pipeline/study/study.h"

namespace wry::pipeline {

/// Fills in what came of a variant, from the records of its jobs, and checks what they say against its folder: frames
/// by the SHA-256 of their manifest, pictures by their presence.
void read_outcome(const StudyRequest& request, const std::vector<Job>& jobs, StudyRow& row);

/// Ok when every frame that is asked for is in the cache, whole, and (with pictures) drawn.
Status verify_outputs(const StudyRequest& request, const StudyRow& row);

} // namespace wry::pipeline
