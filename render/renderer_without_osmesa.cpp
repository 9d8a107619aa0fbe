#include "render/renderer.h"

namespace wry::render {

struct Renderer::Machinery {
  std::vector<PassTime> times;
  GlVersion version;
};

Renderer::Renderer(std::unique_ptr<Machinery> machinery)
    : m_machinery(std::move(machinery)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

namespace {

Error not_built() {
  return make_error(ErrorCode::unavailable, "this build draws no pictures; configure with -DWRY_WITH_OSMESA=ON");
}

} // namespace

Result<Renderer> Renderer::create(const RenderPlan&, const SceneStatic&) {
  return not_built();
}
Result<Image> Renderer::draw(const Frame&, const Picture&) {
  return not_built();
}
Result<LinearImage> Renderer::draw_linear(const Frame&, const Picture&) {
  return not_built();
}
Result<DataLayers> Renderer::draw_data(const Frame&, const Picture&) {
  return not_built();
}
const std::vector<PassTime>& Renderer::pass_times() const {
  return m_machinery->times;
}
const GlVersion& Renderer::gl_version() const {
  return m_machinery->version;
}

} // namespace wry::render
