#include <cstdio>

#include "pipeline/cli/verb.h"
#include "shots/reference.h"

namespace wry::pipeline {

Status schema_verb(const Invocation& invocation) {
  const std::string text = invocation.markdown ? shots::reference_markdown() : shots::json_schema() + "\n";
  std::fputs(text.c_str(), stdout);
  return {};
}

} // namespace wry::pipeline
