#include "pipeline/export/exporter.h"

namespace wry::pipeline {

Status export_vdb(const ExportJob&) {
  return make_error(ErrorCode::unavailable,
                    "--to vdb: this build has no OpenVDB; configure with -DWRY_WITH_OPENVDB=ON");
}

} // namespace wry::pipeline
