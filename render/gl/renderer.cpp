#include "render/renderer.h"

#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <numbers>
#include <string_view>

#include "render/gl/headless_context.h"
#include "render/overlay.h"
#include "render/passes/data_pass.h"
#include "render/passes/pass.h"

namespace wry::render {
namespace {

double cpu_ms() {
  timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double wall_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Offsets within the pixel of sub-frame `index`, an additive sequence of two irrationals (Roberts 2018), in [-.5, .5).
Eigen::Vector2f pixel_offset(int index, int count) {
  if (count == 1)
    return Eigen::Vector2f::Zero();
  const double x = 0.5 + 0.7548776662466927 * (index + 1);
  const double y = 0.5 + 0.5698402909980532 * (index + 1);
  return {static_cast<float>(x - std::floor(x) - 0.5), static_cast<float>(y - std::floor(y) - 0.5)};
}

/// i mirrored about the point: halves, quarters, eighths of the exposure in turn.
double mirrored(int index) {
  double place = 0.0;
  double part = 0.5;
  for (int i = index; i > 0; i /= 2, part *= 0.5)
    place += (i % 2) * part;
  return place;
}

/// When within the exposure sub-frame `index` is, from its middle [s].
double exposure_time(const RenderPlan& plan, int index) {
  if (plan.samples < 2 || !(plan.shutter > 0.0))
    return 0.0;
  return (mirrored(index) + 0.5 / plan.samples - 0.5) * plan.shutter / plan.fps;
}

/// Moves the eye over the lens and turns the picture so that what is in focus stays where it is. The first sub-frame
/// of many looks through the middle.
void use_lens(const RenderPlan& plan, const CameraPlan& asked, int index, Camera& camera, Eigen::Vector2f& jitter) {
  if (!asked.f_stop || plan.samples < 2)
    return;
  const double focal = 1e-3 * asked.lens_mm;
  const double aperture = 0.5 * focal / *asked.f_stop;
  // The camera is placed relative to the centre of the bounds: that is in focus unless the shot says otherwise.
  const double to_centre = camera.axes.col(2).dot(camera.eye);
  const double focus = std::max(asked.focus_distance.value_or(to_centre), camera.near_distance);
  const double radius = aperture * std::sqrt((index + 0.5) / plan.samples);
  const double angle = index * std::numbers::pi * (3.0 - std::sqrt(5.0));
  const Eigen::Vector2d offset(radius * std::cos(angle), radius * std::sin(angle));
  camera.eye += camera.axes.leftCols<2>() * offset;
  jitter += Eigen::Vector2f(static_cast<float>(offset.x() / (focus * camera.tan_half_width)),
                            static_cast<float>(offset.y() / (focus * camera.tan_half_height)));
}

/// World -> clip with an endless far plane and reversed depth: near_distance / distance, precise everywhere.
Eigen::Matrix4f clip_matrix(const Camera& camera, const Eigen::Vector2f& jitter) {
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();
  view.topLeftCorner<3, 3>() = camera.axes.transpose();
  view.topRightCorner<3, 1>() = -camera.axes.transpose() * camera.eye;
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(0, 0) = 1.0 / camera.tan_half_width;
  clip(1, 1) = 1.0 / camera.tan_half_height;
  clip(0, 2) = -jitter.x();
  clip(1, 2) = -jitter.y();
  clip(2, 3) = camera.near_distance;
  clip(3, 2) = -1.0;
  return (clip * view).cast<float>();
}

} // namespace

struct Renderer::Machinery {
  RenderPlan plan;
  std::unique_ptr<HeadlessContext> context;
  std::unique_ptr<DrawableScene> scene;
  std::unique_ptr<Targets> targets;
  std::unique_ptr<Geometry> geometry;
  std::vector<std::unique_ptr<Pass>> passes; ///< in the table's order, made when first needed
  std::unique_ptr<DataPass> data_pass;
  std::vector<PassTime> times;

  PassResources resources() const;
  Result<Pass*> pass(std::size_t index);
  Result<Camera> camera(const Frame& frame, const Picture& picture) const;
  SubFrame sub_frame(const View& view, const CameraPlan& asked, const Camera& camera, int index) const;
  void face_grains(const SubFrame& sub_frame);
  bool is_still(const CameraPlan& asked) const;
  HidingPicture hiding_picture(const SubFrame& drawn) const;
  void leave_out_hidden_grains(const SubFrame& drawn);
  Status draw_first_grains(SubFrame& first);
  Status draw_pass(std::size_t index, const SubFrame& sub_frame);
  Status draw_passes(const Frame& frame, const Picture& picture);
  Status draw_data_passes(const Frame& frame, const Picture& picture);
};

PassResources Renderer::Machinery::resources() const {
  return {context->gl(), plan, scene->look_table(), *targets, *geometry};
}

Result<Pass*> Renderer::Machinery::pass(std::size_t index) {
  if (!passes[index]) {
    Result<std::unique_ptr<Pass>> made = pass_table()[index].create(resources());
    if (!made.ok())
      return made.error();
    passes[index] = std::move(*made);
  }
  return passes[index].get();
}

Result<Camera> Renderer::Machinery::camera(const Frame& frame, const Picture& picture) const {
  Result<Camera> camera = frame_camera(picture.camera.value_or(plan.camera), plan.up, plan.bounds, plan.size,
                                       plan.framing, picture.orbit_turns);
  if (!camera.ok())
    return camera;
  if (const Status outside = scene->check_outside(frame, camera->eye); !outside.ok())
    return outside.error();
  camera->eye -= plan.bounds.centre();
  return camera;
}

SubFrame Renderer::Machinery::sub_frame(const View& view, const CameraPlan& asked, const Camera& camera,
                                        int index) const {
  SubFrame sub_frame;
  sub_frame.index = index;
  sub_frame.count = plan.samples;
  sub_frame.view = &view;
  sub_frame.camera = camera;
  sub_frame.jitter = 2.f * pixel_offset(index, plan.samples)
                               .cwiseQuotient(Eigen::Vector2f(static_cast<float>(plan.size.width),
                                                              static_cast<float>(plan.size.height)));
  // Views that are read rather than looked at stay sharp.
  const bool is_beauty = view.colouring == Colouring::look && view.signs == Signs::none;
  sub_frame.seconds = is_beauty ? static_cast<float>(exposure_time(plan, index)) : 0.f;
  use_lens(plan, asked, index, sub_frame.camera, sub_frame.jitter);
  sub_frame.still = is_still(asked);
  sub_frame.clip_from_world = clip_matrix(sub_frame.camera, sub_frame.jitter);
  sub_frame.scene_radius = static_cast<float>(plan.bounds.radius());
  double lowest = std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 8; ++corner)
    lowest =
        std::min(lowest, plan.up.dot(plan.bounds.box().corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner))));
  sub_frame.ground_height = static_cast<float>(plan.ground.height.value_or(lowest) - plan.up.dot(plan.bounds.centre()));
  const Vec3 back = world_frame(plan.up).transpose() * camera.axes.col(2);
  const double azimuth = std::atan2(back.x(), back.z()) * 180.0 / std::numbers::pi;
  sub_frame.lights = light_state(plan, azimuth, index, plan.samples);
  if (plan.samples > 1 && (plan.shutter > 0.0 || plan.camera.f_stop.has_value()))
    sub_frame.touched = {0, 0, plan.size.width, plan.size.height}; // what is blurred leaves its place
  else
    sub_frame.touched =
        touched_rect(plan, camera, sub_frame.lights, sub_frame.ground_height, OCCLUSION_REACH * plan.bounds.radius());
  return sub_frame;
}

/// Grains are cut anew only where they have moved: neither the lens nor the light's disc turns other faces to view.
void Renderer::Machinery::face_grains(const SubFrame& sub_frame) {
  const double cpu = cpu_ms();
  const double wall = wall_ms();
  geometry->face_eye(sub_frame.camera.eye.cast<float>(), sub_frame.seconds);
  if (sub_frame.lights.shadowed >= 0)
    geometry->face_light(sub_frame.lights.directions.col(sub_frame.lights.shadowed).head<3>(), sub_frame.seconds);
  times.front().cpu_ms += cpu_ms() - cpu;
  times.front().wall_ms += wall_ms() - wall;
}

/// Whether nothing but the raster moves between sub-frames.
bool Renderer::Machinery::is_still(const CameraPlan& asked) const {
  return plan.samples == 1 || (!(plan.shutter > 0.0) && !asked.f_stop.has_value());
}

HidingPicture Renderer::Machinery::hiding_picture(const SubFrame& drawn) const {
  std::vector<float> depth(static_cast<std::size_t>(plan.size.width) * static_cast<std::size_t>(plan.size.height));
  context->gl().GetTextureImage(targets->depth.name(), 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                                static_cast<GLsizei>(depth.size() * sizeof(float)), depth.data());
  return {FarthestDepths(std::move(depth), plan.size), drawn.clip_from_world, plan.size};
}

void Renderer::Machinery::leave_out_hidden_grains(const SubFrame& drawn) {
  const double cpu = cpu_ms();
  const double wall = wall_ms();
  geometry->show_seen(hiding_picture(drawn));
  times.front().cpu_ms += cpu_ms() - cpu;
  times.front().wall_ms += wall_ms() - wall;
}

/// Of a heap most grains are behind others. What the eye meets first is drawn first, so that those which it hides are
/// never cut to triangles; the sub-frame then adds the rest.
Status Renderer::Machinery::draw_first_grains(SubFrame& first) {
  constexpr std::size_t WORTH_IT = 20000;
  if (geometry->grains() < WORTH_IT)
    return {};
  const double cpu = cpu_ms();
  const double wall = wall_ms();
  geometry->show_first_met(first.clip_from_world, plan.size);
  times.front().cpu_ms += cpu_ms() - cpu;
  times.front().wall_ms += wall_ms() - wall;
  face_grains(first);
  const auto surface = std::find_if(pass_table().begin(), pass_table().end(),
                                    [](const PassEntry& entry) { return entry.create == create_surface_pass; });
  const auto index = static_cast<std::size_t>(surface - pass_table().begin());
  if (Status status = draw_pass(index, first); !status.ok())
    return status;
  const double cpu_then = cpu_ms();
  const double wall_then = wall_ms();
  geometry->show_rest(hiding_picture(first));
  times.front().cpu_ms += cpu_ms() - cpu_then;
  times.front().wall_ms += wall_ms() - wall_then;
  first.surface_begun = true;
  return {};
}

Status Renderer::Machinery::draw_pass(std::size_t index, const SubFrame& sub_frame) {
  const Result<Pass*> ready = pass(index);
  if (!ready.ok())
    return ready.error();
  const double cpu = cpu_ms();
  const double wall = wall_ms();
  (*ready)->draw(sub_frame);
  context->gl().Finish();
  times[index + 1].cpu_ms += cpu_ms() - cpu;
  times[index + 1].wall_ms += wall_ms() - wall;
  return {};
}

Status Renderer::Machinery::draw_passes(const Frame& frame, const Picture& picture) {
  const Result<View> view = find_view(plan, picture.view);
  if (!view.ok())
    return view.error();
  const Result<Camera> placed = camera(frame, picture);
  if (!placed.ok())
    return placed.error();
  const double geometry_cpu = cpu_ms();
  const double geometry_wall = wall_ms();
  Result<DrawList> list = scene->list(frame, *view);
  if (!list.ok())
    return list.error();
  geometry->upload(std::move(*list));
  times.assign(1, {"geometry", cpu_ms() - geometry_cpu, wall_ms() - geometry_wall});
  for (const PassEntry& entry : pass_table())
    times.push_back({entry.name, 0.0, 0.0});
  for (int index = 0; index < plan.samples; ++index) {
    SubFrame current = sub_frame(*view, picture.camera.value_or(plan.camera), *placed, index);
    const bool still = is_still(picture.camera.value_or(plan.camera)) && geometry->has_clouds() &&
                       plan.hidden_grains == RenderPlan::HiddenGrains::left_out;
    if (index == 0 && still) {
      if (const Status status = draw_first_grains(current); !status.ok())
        return status;
    }
    face_grains(current);
    for (std::size_t p = 0; p < pass_table().size(); ++p) {
      const PassEntry& entry = pass_table()[p];
      const PassRate rate = entry.rate(plan);
      const bool now = rate == PassRate::sub_frame || (rate == PassRate::first_sub_frame && index == 0) ||
                       (rate == PassRate::last_sub_frame && index + 1 == plan.samples);
      if (!now || !entry.needed(plan, *view))
        continue;
      if (const Status status = draw_pass(p, current); !status.ok())
        return status;
    }
    if (index == 0 && plan.samples > 1 && still)
      leave_out_hidden_grains(current);
  }
  if (const GLenum error = context->gl().GetError(); error != GL_NO_ERROR)
    return make_error(error == GL_OUT_OF_MEMORY ? ErrorCode::out_of_memory : ErrorCode::unavailable,
                      "frame {}, view {}: OpenGL reports error {:#x}", frame.number, picture.view, error);
  return {};
}

Renderer::Renderer(std::unique_ptr<Machinery> machinery)
    : m_machinery(std::move(machinery)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Result<Renderer> Renderer::create(const RenderPlan& plan, const SceneStatic& scene) {
  if (const Status good = check_render_plan(plan); !good.ok())
    return good.error();
  if (const Result<Camera> good = frame_camera(plan.camera, plan.up, plan.bounds, plan.size, plan.framing, 0.0);
      !good.ok())
    return good.error();
  Result<DrawableScene> drawable = DrawableScene::create(plan, scene);
  if (!drawable.ok())
    return drawable.error();
  Result<std::unique_ptr<HeadlessContext>> context = HeadlessContext::create(plan.backend, plan.raster_threads);
  if (!context.ok())
    return context.error();
  auto machinery = std::make_unique<Machinery>();
  machinery->plan = plan;
  machinery->context = std::move(*context);
  machinery->scene = std::make_unique<DrawableScene>(std::move(*drawable));
  const GlFunctions& gl = machinery->context->gl();
  gl.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  Result<Targets> targets = make_targets(gl, plan);
  if (!targets.ok())
    return targets.error();
  machinery->targets = std::make_unique<Targets>(std::move(*targets));
  machinery->geometry = std::make_unique<Geometry>(gl, machinery->scene->textures());
  machinery->passes.resize(pass_table().size());
  return Renderer(std::move(machinery));
}

namespace {

/// The picture in GL's order of rows turned over.
template <class Value> void turn_over(std::vector<Value>& rows, const ImageSize& size) {
  const std::size_t row = static_cast<std::size_t>(size.width) * 4;
  for (int y = 0; y < size.height / 2; ++y)
    std::swap_ranges(rows.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y) * row),
                     rows.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y + 1) * row),
                     rows.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(size.height - 1 - y) * row));
}

Image read_display(const GlFunctions& gl, const Targets& targets, int bits) {
  Image image(targets.size.width, targets.size.height);
  if (bits == 8) {
    gl.GetTextureImage(targets.display.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(image.pixels.size()),
                       image.pixels.data());
    turn_over(image.pixels, targets.size);
    return image;
  }
  image.deep.resize(image.pixels.size());
  gl.GetTextureImage(targets.display.name(), 0, GL_RGBA, GL_UNSIGNED_SHORT, static_cast<GLsizei>(2 * image.deep.size()),
                     image.deep.data());
  turn_over(image.deep, targets.size);
  for (std::size_t i = 0; i < image.deep.size(); ++i)
    image.pixels[i] = static_cast<std::uint8_t>((image.deep[i] + 128u) / 257u);
  return image;
}

/// Text is drawn with 8 bits; where it changed the picture it counts for the 16 too.
void deepen_overlay(const Image& before, Image& image) {
  for (std::size_t i = 0; i < image.deep.size(); ++i) {
    if (image.pixels[i] != before.pixels[i])
      image.deep[i] = static_cast<std::uint16_t>(257u * image.pixels[i]);
  }
}

} // namespace

Result<Image> Renderer::draw(const Frame& frame, const Picture& picture) {
  if (const Status drawn = m_machinery->draw_passes(frame, picture); !drawn.ok())
    return drawn.error();
  Image image = read_display(m_machinery->context->gl(), *m_machinery->targets, m_machinery->plan.bits);
  const Image before = image.deep.empty() ? Image() : image;
  const Result<View> view = find_view(m_machinery->plan, picture.view);
  if (view.ok() && view->heat.has_value())
    draw_colour_bar(image, *view->heat);
  std::vector<std::string> lines = m_machinery->plan.slate;
  lines.insert(lines.end(), picture.slate.begin(), picture.slate.end());
  draw_slate(image, lines);
  deepen_overlay(before, image);
  return image;
}

Result<LinearImage> Renderer::draw_linear(const Frame& frame, const Picture& picture) {
  if (const Status drawn = m_machinery->draw_passes(frame, picture); !drawn.ok())
    return drawn.error();
  const ImageSize& size = m_machinery->plan.size;
  const std::size_t row = static_cast<std::size_t>(size.width) * 4;
  std::vector<float> from_below(row * static_cast<std::size_t>(size.height));
  m_machinery->context->gl().GetTextureImage(m_machinery->targets->accumulation.name(), 0, GL_RGBA, GL_FLOAT,
                                             static_cast<GLsizei>(from_below.size() * sizeof(float)),
                                             from_below.data());
  LinearImage image{size.width, size.height, std::vector<float>(from_below.size())};
  for (std::size_t y = 0; y < static_cast<std::size_t>(size.height); ++y)
    std::copy_n(from_below.data() + (static_cast<std::size_t>(size.height) - 1 - y) * row, row,
                image.pixels.data() + y * row);
  return image;
}

/// One sub-frame through the middle of each pixel and of the lens, in the middle of the exposure.
Status Renderer::Machinery::draw_data_passes(const Frame& frame, const Picture& picture) {
  if (plan.data != DataWanted::yes)
    return make_error(ErrorCode::bad_input, "the plan asks for no data layers");
  const Result<View> view = find_view(plan, picture.view);
  if (!view.ok())
    return view.error();
  const Result<Camera> placed = camera(frame, picture);
  if (!placed.ok())
    return placed.error();
  Result<DrawList> list = scene->list(frame, *view);
  if (!list.ok())
    return list.error();
  geometry->upload(std::move(*list));
  CameraPlan pinhole = picture.camera.value_or(plan.camera);
  pinhole.f_stop.reset();
  SubFrame middle = sub_frame(*view, pinhole, *placed, 0);
  middle.jitter.setZero();
  middle.seconds = 0.f;
  middle.clip_from_world = clip_matrix(middle.camera, middle.jitter);
  geometry->face_eye(middle.camera.eye.cast<float>(), 0.f);
  geometry->attach_grain_data();
  if (!data_pass) {
    Result<std::unique_ptr<DataPass>> made = DataPass::create(resources());
    if (!made.ok())
      return made.error();
    data_pass = std::move(*made);
  }
  for (std::size_t p = 0; p < pass_table().size(); ++p) {
    if (std::string_view(pass_table()[p].name) != "surface")
      continue;
    const Result<Pass*> surface = pass(p);
    if (!surface.ok())
      return surface.error();
    (*surface)->draw(middle);
  }
  data_pass->draw(middle);
  return {};
}

namespace {

/// The inverse of the surface pass's code.
std::array<float, 3> decoded_normal(std::uint32_t code) {
  const auto snorm = [](std::uint32_t bits) {
    return std::max(static_cast<float>(static_cast<std::int16_t>(bits & 0xffffu)) / 32767.f, -1.f);
  };
  Eigen::Vector3f n(snorm(code), snorm(code >> 16), 0.f);
  n.z() = 1.f - std::abs(n.x()) - std::abs(n.y());
  const float fold = std::max(-n.z(), 0.f);
  n.x() += n.x() >= 0.f ? -fold : fold;
  n.y() += n.y() >= 0.f ? -fold : fold;
  n.normalize();
  return {n.x(), n.y(), n.z()};
}

} // namespace

Result<DataLayers> Renderer::draw_data(const Frame& frame, const Picture& picture) {
  if (const Status drawn = m_machinery->draw_data_passes(frame, picture); !drawn.ok())
    return drawn.error();
  const ImageSize& size = m_machinery->plan.size;
  const std::size_t count = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  std::vector<float> depth(count);
  std::vector<std::uint32_t> surface(2 * count);
  std::vector<float> data(4 * count);
  const GlFunctions& gl = m_machinery->context->gl();
  const auto bytes = [](const auto& values) { return static_cast<GLsizei>(values.size() * sizeof(values.front())); };
  gl.GetTextureImage(m_machinery->targets->depth.name(), 0, GL_DEPTH_COMPONENT, GL_FLOAT, bytes(depth), depth.data());
  gl.GetTextureImage(m_machinery->targets->surface.name(), 0, GL_RG_INTEGER, GL_UNSIGNED_INT, bytes(surface),
                     surface.data());
  gl.GetTextureImage(m_machinery->data_pass->texture().name(), 0, GL_RGBA, GL_FLOAT, bytes(data), data.data());
  const Result<Camera> camera = m_machinery->camera(frame, picture);
  if (!camera.ok())
    return camera.error();
  DataLayers layers{size.width,
                    size.height,
                    std::vector<float>(count),
                    std::vector<std::array<float, 3>>(count),
                    std::vector<std::array<float, 3>>(count),
                    std::vector<std::uint32_t>(count)};
  for (std::size_t y = 0; y < static_cast<std::size_t>(size.height); ++y) {
    for (std::size_t x = 0; x < static_cast<std::size_t>(size.width); ++x) {
      const std::size_t to = y * static_cast<std::size_t>(size.width) + x;
      const std::size_t from =
          (static_cast<std::size_t>(size.height) - 1 - y) * static_cast<std::size_t>(size.width) + x;
      if (!(depth[from] > 0.f) || surface[2 * from] == 0)
        continue;
      layers.distance[to] = static_cast<float>(camera->near_distance) / depth[from];
      layers.normal[to] = decoded_normal(surface[2 * from + 1]);
      layers.velocity[to] = {data[4 * from], data[4 * from + 1], data[4 * from + 2]};
      layers.body[to] = static_cast<std::uint32_t>(std::lround(data[4 * from + 3]));
    }
  }
  return layers;
}

const std::vector<PassTime>& Renderer::pass_times() const {
  return m_machinery->times;
}

const GlVersion& Renderer::gl_version() const {
  return m_machinery->context->version();
}

} // namespace wry::render
