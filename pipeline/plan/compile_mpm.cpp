#include "pipeline/plan/compile_mpm.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unistd.h>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "pipeline/plan/compile_fem.h"
#include "pipeline/plan/compile_grains.h"
#include "pipeline/plan/mesh_body.h"
#include "pipeline/plan/particle_formulas.h"
#include "sim/geometry/signed_distance.h"
#include "sim/mpm/grains/sub_particles.h"
#include "sim/mpm/mpm_simulation.h"
#include "sim/mpm/particle_sort.h"
#include "sim/mpm/seeding.h"

namespace wry::pipeline {

namespace {

constexpr double RADIANS = std::numbers::pi / 180.0;

/// Whether a point is in the space of a region; its bounds.
struct Space {
  Vec3 low, high;
  std::function<bool(const Vec3&)> inside;
  std::string text;
};

Space space_of(const shots::BoxSpace& box) {
  return {*box.min, *box.max, [](const Vec3&) { return true; }, "region box"};
}

Space space_of(const shots::SphereSpace& sphere) {
  const Vec3 centre = *sphere.centre;
  const double radius = *sphere.radius;
  return {centre - Vec3::Constant(radius), centre + Vec3::Constant(radius),
          [=](const Vec3& point) { return (point - centre).squaredNorm() <= radius * radius; }, "region sphere"};
}

Space space_of(const shots::CylinderSpace& cylinder) {
  const Vec3 from = *cylinder.from;
  const Vec3 axis = *cylinder.to - from;
  const double length = axis.norm();
  const Vec3 along = axis / length;
  const double radius = *cylinder.radius;
  // The ends are discs across the axis.
  const Vec3 reach = radius * (Vec3::Ones() - along.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
  return {from.cwiseMin(*cylinder.to) - reach, from.cwiseMax(*cylinder.to) + reach,
          [=](const Vec3& point) {
            const double height = (point - from).dot(along);
            return height >= 0.0 && height <= length &&
                   (point - from - height * along).squaredNorm() <= radius * radius;
          },
          "region cylinder"};
}

Space space_of(const shots::ParticleRegion& region) {
  return std::visit([](const auto& space) { return space_of(space); }, region.space);
}

/// Right-handed axes, local z along the fibre, local x as near `across` as can be.
Result<Mat3> axes_along(const Vec3& fibre, const std::optional<Vec3>& across) {
  const double length = fibre.norm();
  if (!(length > 1e-12) || !fibre.allFinite())
    return make_error(ErrorCode::bad_input,
                      "the direction ({}, {}, {}) has no length or is no number; expected one that is not 0", fibre.x(),
                      fibre.y(), fibre.z());
  const Vec3 z = fibre / length;
  Eigen::Index nearest = 0;
  z.cwiseAbs().minCoeff(&nearest);
  Vec3 x = across.value_or(Vec3::Unit(nearest));
  x -= x.dot(z) * z;
  if (!(x.norm() > 1e-6 * across.value_or(Vec3::UnitX()).norm()))
    return make_error(ErrorCode::bad_input, "across is along the fibre; expected another direction");
  x.normalize();
  Mat3 axes;
  axes << x, z.cross(x), z;
  return axes;
}

/// How many bytes of particles this machine can take, leaving room for the grid, frames and others.
double memory_for_particles() {
  return 0.5 * static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGE_SIZE));
}

/// Gives one body its particles, fibres and scales.
class ParticleCompiler {
public:
  ParticleCompiler(const shots::Shot& shot, const shots::Body& body, const mpm::MpmSettings& settings)
      : m_shot(shot)
      , m_body(body)
      , m_settings(settings) {}

  Result<CompiledParticles> compile();

private:
  Result<Space> space();
  Result<Space> inside_of_shape();
  Status seed(const Space& space);
  Status orient();
  Status scale(const std::optional<shots::Located<shots::Expression>>& expression, std::vector<double>& values);
  Status add_grains(const shots::SubParticleOptions& asked);
  void report(const Space& space, const mpm::CompiledMaterial& material, const mpm::ParticleCost& cost);
  Error located(Error error) const { return at_source(m_body.source, std::move(error)); }

  const shots::Shot& m_shot;
  const shots::Body& m_body;
  const mpm::MpmSettings& m_settings;
  double m_bytes = 0.0;
  ParticleFormulas m_formulas; ///< once it is known what the body fills
  CompiledParticles m_made;
};

/// The inside of the body's own shape or mesh, through its level set.
Result<Space> ParticleCompiler::inside_of_shape() {
  Result<PlacedSurface> placed = body_surface(m_body, *m_shot.shot.up, m_settings.cell);
  if (!placed)
    return placed.error();
  const Result<geometry::SignedDistance> field =
      geometry::SignedDistance::from_surface(placed->surface, 0.5 * m_settings.cell);
  if (!field)
    return located(field.error());
  m_formulas = ParticleFormulas(placed->surface);
  m_made.assets = std::move(placed->assets);
  m_made.report.notes = std::move(placed->notes);
  return Space{field->low(), field->high(), [field = *field](const Vec3& point) { return field.is_inside(point); },
               placed->description};
}

Result<Space> ParticleCompiler::space() {
  if (!m_body.particles.region)
    return inside_of_shape();
  Space space = space_of(*m_body.particles.region);
  if (m_body.particles.region->expression) {
    Result<ParticleFormula> value = m_formulas.compile(*m_body.particles.region->expression);
    if (!value)
      return value.error();
    space.inside = [inside = space.inside, value = std::move(*value)](const Vec3& point) {
      return inside(point) && value(point) != 0.0;
    };
  }
  return space;
}

Status ParticleCompiler::seed(const Space& space) {
  mpm::SeedSettings seeds;
  seeds.cell = m_settings.cell;
  seeds.particles_per_cell = *m_body.particles.per_cell;
  seeds.sampling =
      *m_shot.mpm.sampling == shots::ParticleSampling::jittered ? mpm::Sampling::jittered : mpm::Sampling::lattice;
  seeds.seed = static_cast<std::uint64_t>(*m_shot.shot.seed);
  const double room = memory_for_particles() / m_bytes;
  const double asked = mpm::lattice_size(space.low, space.high, seeds);
  constexpr double LATTICE_PER_ROOM = 64.0; // points that are looked at cost time, not memory
  if (asked > LATTICE_PER_ROOM * room)
    return located(
        make_error(ErrorCode::out_of_memory,
                   "its region holds {:.3g} particles of {:.0f} bytes, this machine has room for {:.3g}; try "
                   "a larger mpm.cell_size ({:.4g} m now) or fewer particles_per_cell",
                   asked, m_bytes, room, m_settings.cell));
  seeds.most = static_cast<std::size_t>(room);
  Result<mpm::Seeds> filled = mpm::fill(space.low, space.high, space.inside, seeds);
  if (!filled)
    return located(filled.error());
  m_made.body.particle_volume = filled->volume;
  m_made.body.positions = std::make_shared<const Points>(std::move(filled->positions));
  return {};
}

Status ParticleCompiler::orient() {
  const std::optional<shots::Fibre>& fibre = m_body.particles.fibre;
  if (!fibre)
    return {};
  const std::optional<Vec3> across = fibre->across ? std::optional<Vec3>(**fibre->across) : std::nullopt;
  if (!fibre->expression) {
    Vec3 direction = fibre->direction ? **fibre->direction : Vec3(Vec3::UnitZ());
    if (fibre->tilt_deg) {
      const int up = static_cast<int>(*m_shot.shot.up);
      const Vec3 first = Vec3::Unit(up == 0 ? 1 : 0);
      const Vec3 second = Vec3::Unit(up).cross(first);
      const double tilt = **fibre->tilt_deg * RADIANS;
      const double azimuth = *fibre->azimuth_deg * RADIANS;
      direction =
          std::cos(tilt) * Vec3::Unit(up) + std::sin(tilt) * (std::cos(azimuth) * first + std::sin(azimuth) * second);
    }
    const Result<Mat3> axes = axes_along(direction, across);
    if (!axes)
      return at_source(fibre->source, axes.error());
    m_made.body.frame = *axes;
    return {};
  }
  std::array<ParticleFormula, 3> components;
  for (std::size_t i = 0; i < 3; ++i) {
    components[i] = [](const Vec3&) { return 0.0; };
    if (!(*fibre->expression)[i])
      continue;
    Result<ParticleFormula> component = m_formulas.compile(*(*fibre->expression)[i]);
    if (!component)
      return component.error();
    components[i] = std::move(*component);
  }
  const Points& positions = *m_made.body.positions;
  Quaternions frames(positions.rows(), 4);
  for (Eigen::Index i = 0; i < positions.rows(); ++i) {
    const Vec3 at = positions.row(i);
    const Result<Mat3> axes = axes_along(Vec3(components[0](at), components[1](at), components[2](at)), across);
    if (!axes)
      return at_source(fibre->source, make_error(ErrorCode::bad_input, "at ({:.4g}, {:.4g}, {:.4g}) m {}", at.x(),
                                                 at.y(), at.z(), axes.error().message));
    const Eigen::Quaterniond q(*axes);
    frames.row(i) << q.w(), q.x(), q.y(), q.z();
  }
  m_made.body.frames = std::make_shared<const Quaternions>(std::move(frames));
  return {};
}

Status ParticleCompiler::scale(const std::optional<shots::Located<shots::Expression>>& expression,
                               std::vector<double>& values) {
  if (!expression)
    return {};
  const Result<ParticleFormula> factor = m_formulas.compile(*expression);
  if (!factor)
    return factor.error();
  const Points& positions = *m_made.body.positions;
  values.resize(static_cast<std::size_t>(positions.rows()));
  for (Eigen::Index i = 0; i < positions.rows(); ++i) {
    const double value = (*factor)(positions.row(i));
    if (!(value > 0.0) || !std::isfinite(value))
      return at_source(expression->source,
                       make_error(ErrorCode::bad_input, "is {} at ({:.4g}, {:.4g}, {:.4g}) m; expected a factor > 0",
                                  value, positions(i, 0), positions(i, 1), positions(i, 2)));
    values[static_cast<std::size_t>(i)] = value;
  }
  return {};
}

Status ParticleCompiler::add_grains(const shots::SubParticleOptions& asked) {
  Result<CompiledGrains> grains = compile_grains(asked, m_body, m_made.body.material);
  if (!grains)
    return grains.error();
  grains->settings.second_moment = m_made.body.second_moment;
  const double particles = static_cast<double>(m_made.body.positions->rows());
  const double count = particles * grains->settings.per_particle;
  std::vector<std::string>& notes = m_made.report.notes;
  notes.insert(notes.end(), grains->notes.begin(), grains->notes.end());
  notes.push_back(fmt::format("{:.0f} grains are drawn: {:.3g} MB in memory, {:.3g} MB in a frame", count,
                              1e-6 * count * mpm::BYTES_PER_GRAIN, 1e-6 * count * mpm::BYTES_PER_GRAIN_AND_FRAME));
  if (std::string warning = too_many_triangles(grains->settings, particles); !warning.empty())
    m_made.warnings.push_back(std::move(warning));
  m_made.grain_assets = std::move(grains->assets);
  m_made.body.sub_particles = std::move(grains->settings);
  return {};
}

void ParticleCompiler::report(const Space& space, const mpm::CompiledMaterial& material,
                              const mpm::ParticleCost& cost) {
  BodyReport& report = m_made.report;
  const Points& positions = *m_made.body.positions;
  report.name = *m_body.name;
  report.source = space.text;
  report.size = (positions.colwise().maxCoeff() - positions.colwise().minCoeff()).transpose();
  report.particles = static_cast<std::size_t>(positions.rows());
  report.bytes_per_particle = cost.bytes;
  report.volume = static_cast<double>(positions.rows()) * m_made.body.particle_volume;
  report.mass = report.volume * m_made.body.material.density;
  report.model = fmt::format("mpm ({}): {}, density {:.4g} kg/m^3, wave speed {:.4g} m/s", m_made.body.material.name,
                             material.runs, m_made.body.material.density, material.sound_speed);
  report.notes.push_back("a particle carries " + cost.channels);
  m_made.warnings.insert(m_made.warnings.end(), material.warnings.begin(), material.warnings.end());
}

Result<CompiledParticles> ParticleCompiler::compile() {
  const shots::Material& asked = *m_shot.find_material(*m_body.material);
  Result<mpm::Material> material = compile_matter(asked);
  if (!material)
    return material.error();
  material->fibre_varies = m_body.particles.fibre && m_body.particles.fibre->expression;
  material->stiffness_varies = asked.matter.stiffness_scale.has_value();
  material->strength_varies = asked.matter.strength_scale.has_value();
  const Result<mpm::CompiledMaterial> compiled = mpm::compile_material(*material);
  if (!compiled)
    return at_source(asked.source, compiled.error());
  const Result<mpm::ParticleCost> cost = mpm::particle_cost(*material, m_settings.precision);
  if (!cost)
    return at_source(asked.source, cost.error());
  // Sorting needs a second copy; positions and identities are there once more in doubles.
  m_bytes = 2.0 * static_cast<double>(cost->bytes) + 150.0;
  m_made.body.name = *m_body.name;
  m_made.body.material = std::move(*material);
  m_made.body.initial_velocity = *m_body.velocity;
  const Result<Space> filled = space();
  if (!filled)
    return filled.error();
  if (Status status = seed(*filled); !status)
    return status.error();
  if (Status status = orient(); !status)
    return status.error();
  if (Status status = scale(asked.matter.stiffness_scale, m_made.body.stiffness_scale); !status)
    return status.error();
  if (Status status = scale(asked.matter.strength_scale, m_made.body.strength_scale); !status)
    return status.error();
  if (m_body.particles.fibre && m_body.particles.fibre->second_moment)
    m_made.body.second_moment = **m_body.particles.fibre->second_moment;
  if (m_body.particles.grains) {
    if (Status status = add_grains(*m_body.particles.grains); !status)
      return status.error();
  }
  if (m_body.particles.repeat) {
    mpm::Source source;
    source.name = *m_body.name;
    source.every = source.from = *m_body.particles.repeat->every;
    source.until = *m_body.particles.repeat->until;
    m_made.source = source;
  }
  report(*filled, *compiled, *cost);
  return std::move(m_made);
}

} // namespace

Result<mpm::MpmSettings> compile_mpm_settings(const shots::Shot& shot) {
  const shots::MpmOptions& options = shot.mpm;
  mpm::MpmSettings settings;
  settings.transfer = *options.transfer == shots::GridTransfer::mls ? mpm::Transfer::mls : mpm::Transfer::gradient;
  settings.precision = *options.precision == shots::NumberPrecision::f64 ? mpm::Precision::f64 : mpm::Precision::f32;
  settings.courant = *options.courant;
  settings.max_deformation = *options.max_deformation;
  settings.keep_fields = *options.keep_fields;
  if (options.time_step)
    settings.time_step = **options.time_step;
  if (options.semi_implicit)
    settings.semi_implicit = mpm::SemiImplicit{*options.semi_implicit->courant, *options.semi_implicit->implicitness,
                                               *options.semi_implicit->damping, *options.semi_implicit->tolerance};
  if (options.cell_size) {
    settings.cell = **options.cell_size;
    return settings;
  }
  constexpr double CELLS_ACROSS = 16.0;
  double least = std::numeric_limits<double>::infinity();
  for (const shots::Body& body : shot.bodies) {
    if (!shot.is_particles(body) || !body.particles.region)
      continue;
    const Space space = space_of(*body.particles.region);
    least = std::min(least, (space.high - space.low).minCoeff());
  }
  if (!std::isfinite(least))
    return make_error(ErrorCode::bad_input,
                      "{}: mpm.cell_size: no body of particles has a region to take it from; "
                      "give it in m",
                      shot.file);
  settings.cell = least / CELLS_ACROSS;
  return settings;
}

Result<CompiledParticles> compile_particles(const shots::Shot& shot, const shots::Body& body,
                                            const mpm::MpmSettings& settings) {
  return ParticleCompiler(shot, body, settings).compile();
}

std::vector<std::string> overlapping_bodies(const shots::Shot& shot, const mpm::MpmPlan& plan) {
  // A cell that has particles of two bodies at the start.
  std::unordered_map<mpm::BlockCoord, std::size_t, mpm::BlockCoordHash> owner;
  std::vector<std::string> warnings;
  std::vector<std::pair<std::size_t, std::size_t>> said;
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const Points& positions = *plan.bodies[b].positions;
    for (Eigen::Index i = 0; i < positions.rows(); ++i) {
      const Vec3 cell = (positions.row(i).transpose() / plan.settings.cell).array().floor();
      const mpm::BlockCoord key{static_cast<std::int64_t>(cell.x()), static_cast<std::int64_t>(cell.y()),
                                static_cast<std::int64_t>(cell.z())};
      const auto [found, is_new] = owner.emplace(key, b);
      const std::pair<std::size_t, std::size_t> pair{found->second, b};
      if (is_new || found->second == b || std::find(said.begin(), said.end(), pair) != said.end())
        continue;
      said.push_back(pair);
      const shots::Body* body = shot.find_body(plan.bodies[b].name);
      warnings.push_back(fmt::format(
          "{}: its particles and those of body {} are in one cell near ({:.4g}, {:.4g}, {:.4g}) m at the start: where "
          "they overlap matter is there twice, and bursts apart",
          body->source.text(), plan.bodies[found->second].name, positions(i, 0), positions(i, 1), positions(i, 2)));
    }
  }
  return warnings;
}

} // namespace wry::pipeline
