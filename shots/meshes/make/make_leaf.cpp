// Writes a leaf for grains to be drawn as: its length along y, its face up z, folded at the rib and curled, metres.
// Usage: make_leaf FOLDER

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <string>

#include <fmt/format.h>

namespace {

constexpr int STATIONS = 6;       ///< between stem and tip
constexpr double LENGTH = 0.036;  ///< [m]
constexpr double WIDTH = 0.020;   ///< [m]
constexpr double FOLD = 0.35;     ///< slope of either half at the rib
constexpr double CURL = 0.10;     ///< rise of both ends over the middle, of the length
constexpr double STEM_PART = 0.1; ///< of the length, without a blade

double half_width(double part) {
  const double along = std::max(0.0, (part - STEM_PART) / (1.0 - STEM_PART));
  return 0.5 * WIDTH * std::sin(std::numbers::pi * std::pow(along, 0.8));
}

double rise(double part) {
  return CURL * LENGTH * std::pow(2.0 * part - 1.0, 2.0);
}

} // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::fprintf(stderr, "usage: make_leaf FOLDER\n");
    return 2;
  }
  std::ofstream file(std::string(words[1]) + "/leaf.obj");
  file << "# A leaf of our own: shots/meshes/make/make_leaf.cpp. Apache-2.0. Metres, its face towards z.\n";
  const auto vertex = [&](double x, double part) {
    file << fmt::format("v {:.6f} {:.6f} {:.6f}\n", x, LENGTH * (part - 0.5), rise(part) + FOLD * std::abs(x));
  };
  vertex(0.0, 0.0);
  for (int station = 1; station <= STATIONS; ++station) { // left rim, rib, right rim
    const double part = STEM_PART + (1.0 - STEM_PART) * station / (STATIONS + 1.0);
    for (const double side : {-1.0, 0.0, 1.0})
      vertex(side * half_width(part), part);
  }
  vertex(0.0, 1.0);
  const int tip = 3 * STATIONS + 2;
  const auto at = [](int station, int side) { return 2 + 3 * station + side; };
  const auto face = [&](int a, int b, int c) { file << fmt::format("f {} {} {}\n", a, b, c); };
  face(1, at(0, 1), at(0, 0));
  face(1, at(0, 2), at(0, 1));
  for (int station = 0; station + 1 < STATIONS; ++station) {
    for (int side = 0; side < 2; ++side) {
      face(at(station, side), at(station, side + 1), at(station + 1, side + 1));
      face(at(station, side), at(station + 1, side + 1), at(station + 1, side));
    }
  }
  face(at(STATIONS - 1, 0), at(STATIONS - 1, 1), tip);
  face(at(STATIONS - 1, 1), at(STATIONS - 1, 2), tip);
  return file ? 0 : 1;
}
