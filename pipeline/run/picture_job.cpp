#include "pipeline/run/picture_job.h"

#include <algorithm>
#include <array>
#include <limits>

#include "pipeline/plan/build_id.h"
#include "render/exr.h"

namespace wry::pipeline {

namespace {

namespace fs = std::filesystem;

constexpr const char* INPUTS = "wry:inputs";
constexpr const char* EXR_INPUTS = "wryInputs";

fs::path exr_path(const PictureJob& job) {
  return fs::path(job.path).replace_extension(".exr");
}

/// Whether the OpenEXR file decodes and is of these inputs.
bool has_layers(const PictureJob& job) {
  const Result<render::ExrImage> there = render::read_exr(exr_path(job));
  return there && std::find(there->texts.begin(), there->texts.end(),
                            std::pair<std::string, std::string>(EXR_INPUTS, job.inputs)) != there->texts.end();
}

/// The layers that were asked for, named as compositing programs know them.
render::ExrImage exr_layers(const std::vector<std::string>& wanted, const render::LinearImage& light,
                            const render::DataLayers& data) {
  using Type = render::ExrChannel::Type;
  render::ExrImage image{light.width, light.height, {}, {}};
  const auto add = [&](const std::string& name, Type type, const auto& value_at) {
    render::ExrChannel channel{name, type, std::vector<float>(light.pixels.size() / 4)};
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      channel.values[i] = value_at(i);
    image.channels.push_back(std::move(channel));
  };
  const std::array<const char*, 4> colours = {"R", "G", "B", "A"};
  const std::array<const char*, 3> axes = {".X", ".Y", ".Z"};
  for (const std::string& layer : wanted) {
    for (std::size_t c = 0; layer == "colour" && c < 4; ++c)
      add(colours[c], Type::half_float, [&](std::size_t i) { return light.pixels[4 * i + c]; });
    if (layer == "Z")
      add("Z", Type::float32,
          [&](std::size_t i) { return data.body[i] == 0 ? std::numeric_limits<float>::infinity() : data.distance[i]; });
    for (std::size_t c = 0; layer == "N" && c < 3; ++c)
      add(std::string("N") + axes[c], Type::half_float, [&](std::size_t i) { return data.normal[i][c]; });
    for (std::size_t c = 0; layer == "velocity" && c < 3; ++c)
      add(std::string("velocity") + axes[c], Type::half_float, [&](std::size_t i) { return data.velocity[i][c]; });
    if (layer == "id")
      add("id", Type::integer, [&](std::size_t i) { return static_cast<float>(data.body[i]); });
  }
  return image;
}

} // namespace

bool is_up_to_date(const PictureJob& job) {
  if (!job.layers.empty() && !has_layers(job))
    return false;
  const Result<render::PngContents> there = render::read_png(job.path);
  if (!there)
    return false;
  return std::any_of(there->texts.begin(), there->texts.end(),
                     [&](const render::PngText& text) { return text.key == INPUTS && text.value == job.inputs; });
}

Status Draughtsman::draw(const Frame& frame, PictureJob job) {
  if (!m_renderer) {
    Result<render::Renderer> made = render::Renderer::create(m_plan, m_scene);
    if (!made)
      return made.error();
    m_renderer.emplace(std::move(*made));
  }
  const Result<render::Image> image = m_renderer->draw(frame, job.picture);
  if (!image)
    return image.error();
  if (!job.layers.empty()) {
    if (Status status = write_layers(frame, job); !status)
      return status;
  }
  job.texts.push_back({INPUTS, job.inputs});
  job.texts.push_back({"wry:build", fmt::format("{} {}", version(), render_build())});
  job.texts.push_back({"wry:gl", m_renderer->gl_version().backend + " " + m_renderer->gl_version().version});
  render::PngSettings settings;
  if (m_plan.background == render::Background::clear)
    settings.alpha = render::PngAlpha::straight;
  return render::write_png(job.path, *image, job.texts, settings);
}

Status Draughtsman::write_layers(const Frame& frame, const PictureJob& job) {
  const Result<render::LinearImage> light = m_renderer->draw_linear(frame, job.picture);
  if (!light)
    return light.error();
  const Result<render::DataLayers> data = m_renderer->draw_data(frame, job.picture);
  if (!data)
    return data.error();
  render::ExrImage image = exr_layers(job.layers, *light, *data);
  image.texts = {{EXR_INPUTS, job.inputs}, {"wryBuild", fmt::format("{} {}", version(), render_build())}};
  return render::write_exr(exr_path(job), image);
}

} // namespace wry::pipeline
