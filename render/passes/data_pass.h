#pragma once

#include "render/passes/pass.h"

namespace wry::render {

/// Velocity and body of what each pixel shows; the surface pass has distance and normal. Only for pictures that come
/// with data, once a picture.
class DataPass {
public:
  /// Errors: unavailable, out_of_memory.
  static Result<std::unique_ptr<DataPass>> create(const PassResources& resources);

  void draw(const SubFrame& sub_frame);
  /// Velocity [m/s] and the body from 1; 0 is nothing.
  const GlObject& texture() const { return m_data; }

private:
  DataPass(const PassResources& resources, Program triangles, Program grains)
      : m_resources(resources)
      , m_triangles(std::move(triangles))
      , m_grains(std::move(grains)) {}

  PassResources m_resources;
  Program m_triangles;
  Program m_grains;
  GlObject m_data;
  GlObject m_depth;
  GlObject m_frame;
};

} // namespace wry::render
