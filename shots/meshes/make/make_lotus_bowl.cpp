// Writes what lotus_bowl.toml drops and into what: a lotus flower as tets in its curved shape, and a bowl.
// Usage: make_lotus_bowl FOLDER

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace {

constexpr int PETALS = 8;
constexpr double LENGTH = 0.15;     ///< from the centre to a tip, along the petal [m]
constexpr double THICKNESS = 0.004; ///< [m]
constexpr double CORE = 0.28;       ///< part of the length up to which petals are joined

struct Vertex {
  double x = 0.0, y = 0.0, z = 0.0;
};

/// A petal from the side: how it stands at a part of its length.
struct Stand {
  double radius = 0.0, height = 0.0; ///< [m]
  double angle = 0.0;                ///< of its slope
};

double slope_at(double part) {
  const double rise = std::min(1.0, part / 0.7);
  const double back = std::max(0.0, (part - 0.7) / 0.3);
  return std::numbers::pi / 180.0 * (78.0 * rise * rise * (3.0 - 2.0 * rise) - 25.0 * back * back);
}

Stand stand_at(double part) {
  constexpr int STEPS = 400;
  Stand stand;
  for (int i = 0; i < STEPS; ++i) {
    const double angle = slope_at(part * (i + 0.5) / STEPS);
    stand.radius += LENGTH * part / STEPS * std::cos(angle);
    stand.height += LENGTH * part / STEPS * std::sin(angle);
  }
  stand.angle = slope_at(part);
  return stand;
}

/// Half the angle that a petal takes at a part of its length: all of its sector in the core, then a leaf.
double half_angle(double part) {
  const double sector = std::numbers::pi / PETALS;
  if (part <= CORE)
    return sector;
  const double along = (part - CORE) / (1.0 - CORE);
  return sector * std::min(1.0 - 0.25 * std::min(1.0, 8.0 * along), 1.05 * std::cos(1.35 * along));
}

/// Vertices of rings x places; places of neighbouring petals are one in the core and two beyond it.
class Flower {
public:
  Flower(int rings, int across)
      : m_rings(rings)
      , m_across(across) {
    for (int side = 0; side < 2; ++side)
      add_vertices(side == 0 ? -0.5 * THICKNESS : 0.5 * THICKNESS);
    add_tets();
  }

  std::vector<Vertex> vertices;
  std::vector<std::array<int, 4>> tets;

private:
  void add_vertices(double offset) {
    vertices.push_back({0.0, offset, 0.0});
    for (int ring = 1; ring <= m_rings; ++ring) {
      const double part = static_cast<double>(ring) / m_rings;
      const Stand stand = stand_at(part);
      const double radius = stand.radius - offset * std::sin(stand.angle);
      const double height = stand.height + offset * std::cos(stand.angle);
      for (int petal = 0; petal < PETALS; ++petal) {
        for (int i = 0; i < places(ring); ++i) {
          const double aside = 2.0 * i / m_across - 1.0;
          const double angle = 2.0 * std::numbers::pi * petal / PETALS + aside * half_angle(part);
          vertices.push_back({radius * std::cos(angle), height, radius * std::sin(angle)});
        }
      }
    }
  }

  bool joined(int ring) const { return static_cast<double>(ring) / m_rings <= CORE; }
  /// Of one petal on a ring; a joined petal ends where the next begins.
  int places(int ring) const { return joined(ring) ? m_across : m_across + 1; }

  int vertex(int ring, int petal, int place) const {
    if (ring == 0)
      return 0;
    int first = 1;
    for (int r = 1; r < ring; ++r)
      first += PETALS * places(r);
    if (joined(ring) && place == m_across)
      return first + (petal + 1) % PETALS * places(ring);
    return first + petal * places(ring) + place;
  }

  void add_tets() {
    for (int petal = 0; petal < PETALS; ++petal) {
      for (int ring = 0; ring < m_rings; ++ring) {
        for (int i = 0; i < m_across; ++i) {
          const int a = vertex(ring, petal, i), b = vertex(ring + 1, petal, i);
          const int c = vertex(ring + 1, petal, i + 1), d = vertex(ring, petal, i + 1);
          add_prism(a, b, c);
          if (ring > 0)
            add_prism(a, c, d);
        }
      }
    }
  }

  /// Three tets; the diagonals of the sides start at the lower number, so that neighbours agree.
  void add_prism(int a, int b, int c) {
    const int up = static_cast<int>(vertices.size() / 2);
    std::array<int, 3> low = {std::min({a, b, c}), 0, std::max({a, b, c})};
    low[1] = a + b + c - low[0] - low[2];
    tets.push_back({low[0], low[1], low[2], low[2] + up});
    tets.push_back({low[0], low[1], low[1] + up, low[2] + up});
    tets.push_back({low[0], low[0] + up, low[1] + up, low[2] + up});
  }

  int m_rings, m_across;
};

bool write_flower(const Flower& flower, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  file << fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", flower.vertices.size());
  for (std::size_t i = 0; i < flower.vertices.size(); ++i)
    file << fmt::format("{} {:.6f} {:.6f} {:.6f}\n", i + 1, flower.vertices[i].x, flower.vertices[i].y,
                        flower.vertices[i].z);
  file << fmt::format("$EndNodes\n$Elements\n{}\n", flower.tets.size());
  for (std::size_t i = 0; i < flower.tets.size(); ++i)
    file << fmt::format("{} 4 2 1 1 {} {} {} {}\n", i + 1, flower.tets[i][0] + 1, flower.tets[i][1] + 1,
                        flower.tets[i][2] + 1, flower.tets[i][3] + 1);
  file << "$EndElements\n";
  fmt::print("{}: {} tets, {} vertices\n", path, flower.tets.size(), flower.vertices.size());
  return !file.fail();
}

/// A profile turned about y, closed: inside from the middle up to the rim, then outside down again.
bool write_bowl(const std::string& path) {
  constexpr int AROUND = 64;
  constexpr int ALONG = 16;
  constexpr double RADIUS = 0.30, WALL = 0.015, DEPTH = 70.0; // metres; degrees of the sphere that the bowl is
  std::vector<std::array<double, 2>> profile;
  for (int side = 0; side < 2; ++side) {
    for (int i = 0; i <= ALONG; ++i) {
      const double angle = DEPTH * std::numbers::pi / 180.0 * (side == 0 ? i : ALONG - i) / ALONG;
      const double radius = side == 0 ? RADIUS : RADIUS + WALL;
      profile.push_back({radius * std::sin(angle), RADIUS - radius * std::cos(angle)});
    }
  }
  std::ofstream file(path, std::ios::binary);
  file << "# written by make_lotus_bowl\n";
  const int last = static_cast<int>(profile.size()) - 1;
  file << fmt::format("v 0 {:.6f} 0\n", profile[0][1]);
  for (int i = 1; i < last; ++i) {
    for (int k = 0; k < AROUND; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / AROUND;
      file << fmt::format("v {:.6f} {:.6f} {:.6f}\n", profile[i][0] * std::cos(angle), profile[i][1],
                          profile[i][0] * std::sin(angle));
    }
  }
  file << fmt::format("v 0 {:.6f} 0\n", profile[static_cast<std::size_t>(last)][1]);
  const auto vertex = [&](int i, int k) {
    return i == 0 ? 1 : i == last ? 2 + (last - 1) * AROUND : 2 + (i - 1) * AROUND + k % AROUND;
  };
  for (int i = 0; i < last; ++i) {
    for (int k = 0; k < AROUND; ++k) {
      if (i > 0)
        file << fmt::format("f {} {} {}\n", vertex(i, k), vertex(i + 1, k + 1), vertex(i, k + 1));
      if (i + 1 < last)
        file << fmt::format("f {} {} {}\n", vertex(i, k), vertex(i + 1, k), vertex(i + 1, k + 1));
      else
        file << fmt::format("f {} {} {}\n", vertex(i, k), vertex(last, 0), vertex(i, k + 1));
    }
  }
  return !file.fail();
}

} // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: make_lotus_bowl FOLDER\n");
    return 2;
  }
  const std::string folder = arguments[1];
  const bool written = write_flower(Flower(18, 6), folder + "/lotus_flower.msh") &&
                       write_flower(Flower(32, 10), folder + "/lotus_flower_fine.msh") &&
                       write_bowl(folder + "/bowl.obj");
  if (!written)
    std::fprintf(stderr, "cannot write into %s\n", folder.c_str());
  return written ? 0 : 73;
}
