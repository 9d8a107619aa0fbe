// Writes shots/meshes/rosette.msh: a flat sheet cut into petals, as tets. Usage: make_rosette OUT.msh [LAYERS]

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numbers>
#include <vector>

#include <fmt/format.h>

namespace {

constexpr int PETALS = 8;
constexpr int ACROSS = 8;     ///< cells across a petal, and along a side of its part of the core
constexpr int ALONG = 20;     ///< cells along a petal
constexpr double CORE = 0.11; ///< distance of the core's sides from the centre [m]
constexpr double TIP = 0.5;   ///< of the petals' tips [m]
constexpr double THICKNESS = 0.005;
constexpr double HALF_SECTOR = std::numbers::pi / PETALS;

struct Point {
  double x = 0.0, z = 0.0;
};

/// Half the width of a petal at a part 0..1 of its length: as wide as its sector at the root, then a leaf.
double half_width(double part) {
  const double root = CORE * std::tan(HALF_SECTOR);
  const double leaf = 0.128 * std::pow(std::sin(std::numbers::pi * std::pow(0.13 + 0.87 * part, 0.9)), 0.78);
  const double room = (CORE + part * (TIP - CORE)) * std::tan(HALF_SECTOR) * 0.985;
  const double blend = std::min(1.0, part / 0.12);
  return std::min(room, (1.0 - blend) * root + blend * std::min(leaf, room));
}

class Sheet {
public:
  int vertex(Point at) {
    const std::pair key{std::lround(at.x * 1e7), std::lround(at.z * 1e7)};
    const auto [found, fresh] = m_known.try_emplace(key, static_cast<int>(points.size()));
    if (fresh)
      points.push_back(at);
    return found->second;
  }
  void triangle(int a, int b, int c) { triangles.push_back({a, b, c}); }

  void add_petal(int petal) {
    const double angle = petal * 2.0 * HALF_SECTOR;
    const auto turned = [&](double along, double aside) {
      return Point{along * std::cos(angle) - aside * std::sin(angle),
                   along * std::sin(angle) + aside * std::cos(angle)};
    };
    // The core's part: rows of growing length from the centre to the petal's root.
    for (int row = 0; row < ACROSS; ++row) {
      const auto at = [&](int r, int i) {
        const double along = CORE * r / ACROSS;
        const double aside = r == 0 ? 0.0 : along * std::tan(HALF_SECTOR) * (2.0 * i / r - 1.0);
        return vertex(turned(along, aside));
      };
      for (int i = 0; i <= row; ++i) {
        triangle(at(row, i), at(row + 1, i), at(row + 1, i + 1));
        if (i < row)
          triangle(at(row, i), at(row + 1, i + 1), at(row, i + 1));
      }
    }
    for (int cell = 0; cell < ALONG; ++cell) {
      const auto at = [&](int n, int i) {
        const double part = static_cast<double>(n) / ALONG;
        return vertex(turned(CORE + part * (TIP - CORE), half_width(part) * (2.0 * i / ACROSS - 1.0)));
      };
      for (int i = 0; i < ACROSS; ++i) {
        const std::array<int, 4> quad = {at(cell, i), at(cell, i + 1), at(cell + 1, i + 1), at(cell + 1, i)};
        if (quad[2] == quad[3]) { // the tip
          triangle(quad[0], quad[1], quad[2]);
        } else if (2 * i < ACROSS) {
          triangle(quad[0], quad[1], quad[3]);
          triangle(quad[1], quad[2], quad[3]);
        } else {
          triangle(quad[0], quad[1], quad[2]);
          triangle(quad[0], quad[2], quad[3]);
        }
      }
    }
  }

  std::vector<Point> points;
  std::vector<std::array<int, 3>> triangles;

private:
  std::map<std::pair<long, long>, int> m_known;
};

/// Tets of the prisms over the triangles: the diagonals of their sides start at the lower vertex number, so that
/// neighbours agree.
std::vector<std::array<int, 4>> fill(const Sheet& sheet, int layers) {
  std::vector<std::array<int, 4>> tets;
  const int count = static_cast<int>(sheet.points.size());
  for (std::array<int, 3> triangle : sheet.triangles) {
    std::sort(triangle.begin(), triangle.end());
    for (int layer = 0; layer < layers; ++layer) {
      const int low = layer * count, high = low + count;
      const auto [a, b, c] = triangle;
      tets.push_back({a + low, b + low, c + low, c + high});
      tets.push_back({a + low, b + low, b + high, c + high});
      tets.push_back({a + low, a + high, b + high, c + high});
    }
  }
  return tets;
}

} // namespace

int main(int count, char** arguments) {
  if (count < 2) {
    std::fprintf(stderr, "usage: make_rosette OUT.msh [LAYERS]\n");
    return 2;
  }
  const int layers = count > 2 ? std::max(1, std::atoi(arguments[2])) : 1;
  Sheet sheet;
  for (int petal = 0; petal < PETALS; ++petal)
    sheet.add_petal(petal);
  const std::vector<std::array<int, 4>> tets = fill(sheet, layers);
  std::ofstream file(arguments[1], std::ios::binary);
  file << fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", sheet.points.size() * (layers + 1));
  std::size_t number = 0;
  for (int layer = 0; layer <= layers; ++layer) {
    for (const Point& point : sheet.points)
      file << fmt::format("{} {:.6f} {:.6f} {:.6f}\n", ++number, point.x, THICKNESS * layer / layers, point.z);
  }
  file << fmt::format("$EndNodes\n$Elements\n{}\n", tets.size());
  for (std::size_t tet = 0; tet < tets.size(); ++tet)
    file << fmt::format("{} 4 2 1 1 {} {} {} {}\n", tet + 1, tets[tet][0] + 1, tets[tet][1] + 1, tets[tet][2] + 1,
                        tets[tet][3] + 1);
  file << "$EndElements\n";
  file.close();
  if (file.fail()) {
    std::fprintf(stderr, "cannot write %s\n", arguments[1]);
    return 73;
  }
  fmt::print("{} tets, {} vertices\n", tets.size(), sheet.points.size() * (layers + 1));
  return 0;
}
