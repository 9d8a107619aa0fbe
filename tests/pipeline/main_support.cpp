#include <gtest/gtest.h>

#include "pipeline/assets/import_child.h"

/// Test programs import meshes as the product does: by starting themselves again.
int main(int argc, char** argv) {
  if (wry::pipeline::is_import_child(argc, argv))
    return wry::pipeline::import_child_main(argc, argv);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
