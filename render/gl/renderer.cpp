#include "render/renderer.h"

#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <numbers>

#include "render/gl/headless_context.h"
#include "render/overlay.h"
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
  std::vector<PassTime> times;

  Result<Pass*> pass(std::size_t index);
  Result<Camera> camera(const Frame& frame, const Picture& picture) const;
  SubFrame sub_frame(const View& view, const Camera& camera, int index) const;
  Status draw_passes(const Frame& frame, const Picture& picture);
};

Result<Pass*> Renderer::Machinery::pass(std::size_t index) {
  if (!passes[index]) {
    const PassResources resources{context->gl(), plan, scene->look_table(), *targets, *geometry};
    Result<std::unique_ptr<Pass>> made = pass_table()[index].create(resources);
    if (!made.ok())
      return made.error();
    passes[index] = std::move(*made);
  }
  return passes[index].get();
}

Result<Camera> Renderer::Machinery::camera(const Frame& frame, const Picture& picture) const {
  Result<Camera> camera = frame_camera(plan.camera, plan.up, plan.bounds, plan.size, plan.framing, picture.orbit_turns);
  if (!camera.ok())
    return camera;
  if (const Status outside = scene->check_outside(frame, camera->eye); !outside.ok())
    return outside.error();
  camera->eye -= plan.bounds.centre();
  return camera;
}

SubFrame Renderer::Machinery::sub_frame(const View& view, const Camera& camera, int index) const {
  SubFrame sub_frame;
  sub_frame.index = index;
  sub_frame.count = plan.samples;
  sub_frame.view = &view;
  sub_frame.camera = camera;
  sub_frame.jitter = 2.f * pixel_offset(index, plan.samples)
                               .cwiseQuotient(Eigen::Vector2f(static_cast<float>(plan.size.width),
                                                              static_cast<float>(plan.size.height)));
  sub_frame.clip_from_world = clip_matrix(camera, sub_frame.jitter);
  sub_frame.scene_radius = static_cast<float>(plan.bounds.radius());
  double lowest = std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 8; ++corner)
    lowest =
        std::min(lowest, plan.up.dot(plan.bounds.box().corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner))));
  sub_frame.ground_height = static_cast<float>(plan.ground.height.value_or(lowest) - plan.up.dot(plan.bounds.centre()));
  const Vec3 back = world_frame(plan.up).transpose() * camera.axes.col(2);
  const double azimuth = std::atan2(back.x(), back.z()) * 180.0 / std::numbers::pi;
  sub_frame.lights = light_state(plan, azimuth, index, plan.samples);
  sub_frame.touched =
      touched_rect(plan, camera, sub_frame.lights, sub_frame.ground_height, OCCLUSION_REACH * plan.bounds.radius());
  return sub_frame;
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
  const Result<DrawList> list = scene->list(frame, *view);
  if (!list.ok())
    return list.error();
  geometry->upload(*list);
  times.assign(1, {"geometry", cpu_ms() - geometry_cpu, wall_ms() - geometry_wall});
  for (const PassEntry& entry : pass_table())
    times.push_back({entry.name, 0.0, 0.0});
  for (int index = 0; index < plan.samples; ++index) {
    const SubFrame current = sub_frame(*view, *placed, index);
    for (std::size_t p = 0; p < pass_table().size(); ++p) {
      const PassEntry& entry = pass_table()[p];
      const bool now = entry.rate == PassRate::sub_frame || (entry.rate == PassRate::first_sub_frame && index == 0) ||
                       (entry.rate == PassRate::last_sub_frame && index + 1 == plan.samples);
      if (!now || !entry.needed(plan, *view))
        continue;
      const Result<Pass*> ready = pass(p);
      if (!ready.ok())
        return ready.error();
      const double cpu = cpu_ms();
      const double wall = wall_ms();
      (*ready)->draw(current);
      context->gl().Finish();
      times[p + 1].cpu_ms += cpu_ms() - cpu;
      times[p + 1].wall_ms += wall_ms() - wall;
    }
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
  Result<Targets> targets = make_targets(gl, plan.size);
  if (!targets.ok())
    return targets.error();
  machinery->targets = std::make_unique<Targets>(std::move(*targets));
  machinery->geometry = std::make_unique<Geometry>(gl);
  machinery->passes.resize(pass_table().size());
  return Renderer(std::move(machinery));
}

Result<Image> Renderer::draw(const Frame& frame, const Picture& picture) {
  if (const Status drawn = m_machinery->draw_passes(frame, picture); !drawn.ok())
    return drawn.error();
  const ImageSize& size = m_machinery->plan.size;
  Image from_below(size.width, size.height);
  m_machinery->context->gl().GetTextureImage(m_machinery->targets->display.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE,
                                             static_cast<GLsizei>(from_below.pixels.size()), from_below.pixels.data());
  Image image(size.width, size.height);
  for (int y = 0; y < size.height; ++y)
    std::copy_n(from_below.at(0, size.height - 1 - y), static_cast<std::size_t>(size.width) * 4, image.at(0, y));
  const Result<View> view = find_view(m_machinery->plan, picture.view);
  if (view.ok() && view->heat.has_value())
    draw_colour_bar(image, *view->heat);
  std::vector<std::string> lines = m_machinery->plan.slate;
  lines.insert(lines.end(), picture.slate.begin(), picture.slate.end());
  draw_slate(image, lines);
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

const std::vector<PassTime>& Renderer::pass_times() const {
  return m_machinery->times;
}

const GlVersion& Renderer::gl_version() const {
  return m_machinery->context->version();
}

} // namespace wry::render
