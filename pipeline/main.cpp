#include "pipeline/cli/command_line.h"

int main(int argc, char** argv) {
  return wry::pipeline::run_command_line(argc, argv);
}
