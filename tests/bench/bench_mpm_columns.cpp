// How far cylinders of sand run out, by aspect ratio, resolution, friction of the sand and of the floor: a row of CSV
// for the numbers given on the command line (aspect, cells in the radius, friction angle, and the floor's friction
// coefficient or "sticky").

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "tests/mpm/column_collapse_support.h"

int main(int count, char** words) {
  if (count != 5) {
    std::fprintf(stderr, "usage: %s ASPECT CELLS DEGREES FLOOR\n", words[0]);
    return 2;
  }
  wry::mpm::test::ColumnCollapse column;
  column.aspect = std::atof(words[1]);
  column.cells = std::atoi(words[2]);
  column.friction_degrees = std::atof(words[3]);
  if (std::strcmp(words[4], "sticky") != 0)
    column.floor = std::atof(words[4]);
  const wry::mpm::test::RunOut out = wry::mpm::test::run_out(column);
  std::printf("%g,%d,%g,%s,%.4f,%.4f,%.4f,%.0f\n", column.aspect, column.cells, column.friction_degrees, words[4],
              out.front, out.most_mass, out.height, static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
  return 0;
}
