#pragma once

#include <string>
#include <vector>

#include "sim/geometry/surface_mesh.h"

namespace wry {

/// What the rows of a channel stand for.
enum class ChannelOn { vertex, tet, particle, global };

/// How a channel is stored; in memory it is always double.
enum class ChannelStorage { float32, float64 };

/// A quantity of one body on one frame, for pictures, measures and exports.
struct Channel {
  std::string name; ///< "position", "velocity", "microrotation", "speed", ...
  ChannelOn on = ChannelOn::vertex;
  int components = 1;
  ChannelStorage storage = ChannelStorage::float32;
  std::vector<double> values; ///< rows x components, row after row
};

/// What a body is made of. Surfaces move their vertices or move as a whole; particles are a cloud whose rows are those
/// of the channel "position" (particles x 3) and, where they are not round, "orientation" (particles x 4: w, x, y, z).
enum class BodyKind { surface, particles };

/// The form of each particle of a cloud where it is drawn. Local z is the fibre of a rod or straw, the normal of a card
/// or coin, the short side of a brick.
enum class GrainShape { sphere, rod, straw, card, coin, brick, mesh };

/// How a cloud's particles are drawn.
struct Grain {
  GrainShape shape = GrainShape::sphere;
  Vec3 size = Vec3::Constant(0.01); ///< extents along the local axes [m]; of a mesh: its factor along each of them
};

/// What of a body does not change from frame to frame.
struct SceneBody {
  std::string name;
  BodyKind kind = BodyKind::surface;
  Grain grain;           ///< of particles
  std::string look;      ///< name of its look in the shot; empty: the default
  bool simulated = true; ///< false: a collider that moves as a whole, see FrameBody::transform
  Points rest_positions; ///< [m]; of particles drawn as a mesh: that mesh's vertices about the particle, else none
  Tets tets;             ///< none for surfaces
  Triangles triangles;   ///< what is drawn, outward; indices into the vertices
};

/// What of the whole scene does not change: written once beside the frames.
struct SceneStatic {
  std::vector<SceneBody> bodies;
};

/// One body on one frame. Same order as SceneStatic::bodies.
struct FrameBody {
  std::string name;
  std::vector<Channel> channels; ///< simulated bodies have at least "position" (vertices x 3, float64)
  /// 4 x 4, row-major, rest -> world; for bodies that are not simulated.
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> transform = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>::Identity();
};

/// An immutable snapshot of the simulation at the time of one frame.
struct Frame {
  int number = 0;
  double time = 0.0; ///< (number - first) / fps [s]
  std::vector<FrameBody> bodies;
};

/// The channel of that name, or nullptr.
const Channel* find_channel(const FrameBody& body, const std::string& name);

} // namespace wry
