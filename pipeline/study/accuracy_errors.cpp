#include "pipeline/study/accuracy_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "pipeline/cache/frame_cache.h"
#include "pipeline/report/csv_table.h"
#include "pipeline/run/render_frames.h"
#include "render/png.h"

namespace wry::pipeline {

namespace {

constexpr double NAN_VALUE = std::numeric_limits<double>::quiet_NaN();
/// Cells of the grid for densities along the longest extent of the reference.
constexpr double DENSITY_CELLS = 16.0;

/// Difference of a channel at the last frame, root mean square over all rows; NaN when their numbers differ.
/// Quaternions are compared up to their sign.
double channel_difference(const Frame& a, const Frame& b, const std::string& name) {
  double sum = 0.0;
  std::size_t rows = 0;
  for (std::size_t body = 0; body < std::min(a.bodies.size(), b.bodies.size()); ++body) {
    const Channel* x = find_channel(a.bodies[body], name);
    const Channel* y = find_channel(b.bodies[body], name);
    if (x == nullptr || y == nullptr)
      continue;
    if (x->values.size() != y->values.size() || x->components != y->components)
      return NAN_VALUE;
    const auto columns = static_cast<std::size_t>(x->components);
    for (std::size_t row = 0; row + columns <= x->values.size(); row += columns) {
      double minus = 0.0, plus = 0.0;
      for (std::size_t c = 0; c < columns; ++c) {
        minus += (x->values[row + c] - y->values[row + c]) * (x->values[row + c] - y->values[row + c]);
        plus += (x->values[row + c] + y->values[row + c]) * (x->values[row + c] + y->values[row + c]);
      }
      sum += columns == 4 ? std::min(minus, plus) : minus;
      ++rows;
    }
  }
  return rows > 0 ? std::sqrt(sum / static_cast<double>(rows)) : NAN_VALUE;
}

Points positions_of(const FrameBody& body) {
  const Channel* position = find_channel(body, "position");
  if (position == nullptr || position->values.size() < 3)
    return Points(0, 3);
  return Eigen::Map<const Points>(position->values.data(), static_cast<Eigen::Index>(position->values.size() / 3), 3);
}

double extent_of(const Frame& frame) {
  double size = 0.0;
  for (const FrameBody& body : frame.bodies) {
    if (const Points points = positions_of(body); points.rows() > 0)
      size = std::max(size, (points.colwise().maxCoeff() - points.colwise().minCoeff()).maxCoeff());
  }
  return size;
}

/// Sum of the volumes of all tets [m^3].
double volume_of(const SceneStatic& scene, const Frame& frame) {
  double volume = 0.0;
  for (std::size_t i = 0; i < std::min(scene.bodies.size(), frame.bodies.size()); ++i) {
    const Tets& tets = scene.bodies[i].tets;
    const Points points = positions_of(frame.bodies[i]);
    for (Eigen::Index t = 0; t < tets.rows() && points.rows() > 0; ++t) {
      Mat3 edges;
      for (int k = 0; k < 3; ++k)
        edges.col(k) = (points.row(tets(t, k + 1)) - points.row(tets(t, 0))).transpose();
      volume += edges.determinant() / 6.0;
    }
  }
  return volume;
}

/// Shares of each cloud's particles in cells of a grid, spread linearly over the eight nearest.
using Shares = std::map<std::array<long, 4>, double>;
Shares shares_of(const SceneStatic& scene, const Frame& frame, double cell) {
  Shares shares;
  for (std::size_t i = 0; i < std::min(scene.bodies.size(), frame.bodies.size()); ++i) {
    if (scene.bodies[i].kind != BodyKind::particles)
      continue;
    const Points points = positions_of(frame.bodies[i]);
    for (Eigen::Index p = 0; p < points.rows(); ++p) {
      const Vec3 at = points.row(p).transpose() / cell;
      const Vec3 base = at.array().floor();
      for (int corner = 0; corner < 8; ++corner) {
        double weight = 1.0 / static_cast<double>(points.rows());
        std::array<long, 4> key{static_cast<long>(i), 0, 0, 0};
        for (int axis = 0; axis < 3; ++axis) {
          const int up = (corner >> axis) & 1;
          const double part = at[axis] - base[axis];
          weight *= up != 0 ? part : 1.0 - part;
          key[static_cast<std::size_t>(axis) + 1] = std::lround(base[axis]) + up;
        }
        shares[key] += weight;
      }
    }
  }
  return shares;
}

double density_error(const SceneStatic& scene, const Frame& mine, const SceneStatic& exact_scene, const Frame& exact) {
  const double cell = extent_of(exact) / DENSITY_CELLS;
  if (!(cell > 0.0))
    return NAN_VALUE;
  Shares difference = shares_of(exact_scene, exact, cell);
  double total = 0.0, moved = 0.0;
  for (auto& [key, share] : difference) {
    total += share;
    share = -share;
  }
  for (const auto& [key, share] : shares_of(scene, mine, cell))
    difference[key] += share;
  for (const auto& [key, share] : difference)
    moved += std::abs(share);
  return total > 0.0 ? 0.5 * moved / total : NAN_VALUE;
}

/// Sum of all energies by the time at the end of each step, and the largest change of any of them.
struct EnergyHistory {
  std::vector<double> times, sums;
  double scale = 0.0;
};

EnergyHistory energies_of(const StudyRow& row) {
  const CsvTable stats = read_csv_table(row.folder / "stats.csv");
  EnergyHistory history;
  history.times = stats.numbers("time_s");
  history.sums.assign(history.times.size(), 0.0);
  for (const std::string& column : stats.columns) {
    if (!column.ends_with("_energy_J"))
      continue;
    const std::vector<double> values = stats.numbers(column);
    for (std::size_t i = 0; i < std::min(values.size(), history.sums.size()); ++i) {
      history.sums[i] += values[i];
      history.scale = std::max(history.scale, std::abs(values[i] - values.front()));
    }
  }
  return history;
}

/// Over the times that both runs stopped at, which those of the frames are.
double energy_error(const StudyRow& row, const StudyRow& reference) {
  const EnergyHistory mine = energies_of(row), exact = energies_of(reference);
  double sum = 0.0;
  int count = 0;
  std::size_t i = 0;
  for (std::size_t e = 0; e < exact.times.size(); ++e) {
    const double same = 1e-9 * std::max(1.0, exact.times[e]);
    while (i < mine.times.size() && mine.times[i] < exact.times[e] - same)
      ++i;
    if (i == mine.times.size())
      break;
    if (mine.times[i] > exact.times[e] + same)
      continue;
    sum += (mine.sums[i] - exact.sums[e]) * (mine.sums[i] - exact.sums[e]);
    ++count;
  }
  return count > 0 && exact.scale > 0.0 ? std::sqrt(sum / count) / exact.scale : NAN_VALUE;
}

double linear_light(std::uint8_t value) {
  const double v = value / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

} // namespace

double measure_error(const StudyRow& row, const StudyRow& reference, const std::string& measure) {
  const CsvTable a = read_csv_table(row.folder / "measure.csv"), b = read_csv_table(reference.folder / "measure.csv");
  const std::vector<double> frames_a = a.numbers("frame"), frames_b = b.numbers("frame");
  const std::vector<double> values_a = a.numbers(measure), values_b = b.numbers(measure);
  if (values_a.size() != frames_a.size() || values_b.size() != frames_b.size())
    return NAN_VALUE;
  double sum = 0.0, scale = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < frames_a.size(); ++i) {
    const auto same = std::find(frames_b.begin(), frames_b.end(), frames_a[i]);
    if (same == frames_b.end())
      continue;
    const double exact = values_b[static_cast<std::size_t>(same - frames_b.begin())];
    sum += (values_a[i] - exact) * (values_a[i] - exact);
    scale = std::max(scale, std::abs(exact));
    ++count;
  }
  return count > 0 && scale > 0.0 ? std::sqrt(sum / count) / scale : NAN_VALUE;
}

double exact_error(const StudyRow& row, const std::string& measure, double exact) {
  const CsvTable table = read_csv_table(row.folder / "measure.csv");
  const std::vector<double> values = table.numbers(measure);
  return values.empty() || exact == 0.0 ? NAN_VALUE : std::abs(values.back() - exact) / std::abs(exact);
}

std::vector<ErrorValue> errors_of_frames(const StudyRow& row, const StudyRow& reference) {
  std::vector<ErrorValue> errors = {
      {"position", NAN_VALUE}, {"rotation", NAN_VALUE}, {"energy", NAN_VALUE},
      {"volume", NAN_VALUE},   {"density", NAN_VALUE},
  };
  if (row.frames.empty())
    return errors;
  const Result<FrameCache> a = FrameCache::open_to_read(row.folder / "frames"),
                           b = FrameCache::open_to_read(reference.folder / "frames");
  if (!a || !b)
    return errors;
  const Result<Frame> mine = a->read_frame(row.frames.back()), exact = b->read_frame(row.frames.back());
  const Result<SceneStatic> scene = a->read_static(), exact_scene = b->read_static();
  if (!mine || !exact || !scene || !exact_scene)
    return errors;
  errors[0].error = channel_difference(*mine, *exact, "position") / extent_of(*exact);
  errors[1].error = channel_difference(*mine, *exact, "microrotation");
  if (std::isnan(errors[1].error))
    errors[1].error = channel_difference(*mine, *exact, "orientation");
  errors[2].error = energy_error(row, reference);
  if (const double volume = volume_of(*exact_scene, *exact); volume > 0.0)
    errors[3].error = std::abs(volume_of(*scene, *mine) - volume) / volume;
  errors[4].error = density_error(*scene, *mine, *exact_scene, *exact);
  return errors;
}

double picture_error(const StudyRow& row, const StudyRow& reference) {
  std::array<double, 256> light{};
  for (std::size_t i = 0; i < light.size(); ++i)
    light[i] = linear_light(static_cast<std::uint8_t>(i));
  double sum = 0.0, count = 0.0;
  for (const shots::Located<shots::View>& view : row.shot->render.views) {
    for (const int frame : row.frames) {
      const std::string& name = *row.shot->shot.name;
      const Result<render::PngContents> mine = render::read_png(picture_path(row.folder, name, view->name, frame)),
                                        exact =
                                            render::read_png(picture_path(reference.folder, name, view->name, frame));
      if (!mine || !exact || mine->image.pixels.size() != exact->image.pixels.size())
        return NAN_VALUE;
      for (std::size_t i = 0; i < mine->image.pixels.size(); ++i) {
        const double difference = light[mine->image.pixels[i]] - light[exact->image.pixels[i]];
        sum += i % 4 != 3 ? difference * difference : 0.0;
      }
      count += 0.75 * static_cast<double>(mine->image.pixels.size());
    }
  }
  return count > 0.0 ? std::sqrt(sum / count) : NAN_VALUE;
}

} // namespace wry::pipeline
