#pragma once

#include <array>
#include <limits>

#include <xmmintrin.h>

#include "sim/contact/moving_box.h"

namespace wry::contact {

/// Up to four boxes, each of which is asked whether it meets another; those that were never put meet none.
template <class AnyBox> class BoxPack {
public:
  void put(int lane, const AnyBox& box) {
    m_boxes[static_cast<std::size_t>(lane)] = box;
    m_count = std::max(m_count, lane + 1);
  }
  /// A bit per box.
  unsigned meeting(const AnyBox& box) const {
    unsigned mask = 0;
    for (int lane = 0; lane < m_count; ++lane)
      mask |= static_cast<unsigned>(m_boxes[static_cast<std::size_t>(lane)].meets(box)) << lane;
    return mask;
  }
  AnyBox whole() const {
    AnyBox box = m_boxes[0];
    for (int lane = 1; lane < m_count; ++lane)
      box.include(m_boxes[static_cast<std::size_t>(lane)]);
    return box;
  }
  /// The sides of all, summed.
  double sizes() const {
    double sum = 0.0;
    for (int lane = 0; lane < m_count; ++lane) {
      const AnyBox& box = m_boxes[static_cast<std::size_t>(lane)];
      for (int i = 0; i < 3; ++i)
        sum += box.high[i] - box.low[i];
    }
    return sum;
  }

private:
  std::array<AnyBox, 4> m_boxes;
  int m_count = 0;
};

/// In single precision all four are asked at once.
template <> class BoxPack<MovingBox> {
public:
  BoxPack() {
    constexpr float NEVER = std::numeric_limits<float>::infinity();
    m_low.fill(Eigen::Array4f::Constant(NEVER));
    m_high.fill(Eigen::Array4f::Constant(-NEVER));
    m_way_low = m_low;
    m_way_high = m_high;
  }
  void put(int lane, const MovingBox& box) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      m_low[i][lane] = box.low[axis];
      m_high[i][lane] = box.high[axis];
      m_way_low[i][lane] = box.way_low[axis];
      m_way_high[i][lane] = box.way_high[axis];
    }
  }
  unsigned meeting(const MovingBox& box) const {
    Eigen::Array4f gap = Eigen::Array4f::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      const Eigen::Array4f below = (m_low[i] - box.high[axis]) + (m_way_low[i] - box.way_high[axis]).min(0.0F);
      const Eigen::Array4f above = (box.low[axis] - m_high[i]) + (box.way_low[axis] - m_way_high[i]).min(0.0F);
      gap = gap.max(below.max(above));
    }
    const __m128 apart = _mm_cmpgt_ps(_mm_load_ps(gap.data()), _mm_setzero_ps());
    return static_cast<unsigned>(_mm_movemask_ps(apart)) ^ 15U;
  }
  MovingBox whole() const {
    MovingBox box = MovingBox::of(Eigen::Array4f::Zero(), Eigen::Array4f::Zero());
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      box.low[axis] = m_low[i].minCoeff();
      box.high[axis] = m_high[i].maxCoeff();
      box.way_low[axis] = m_way_low[i].minCoeff();
      box.way_high[axis] = m_way_high[i].maxCoeff();
    }
    return box;
  }
  double sizes() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < 3; ++i)
      sum += static_cast<double>((m_high[i] - m_low[i]).max(0.0F).sum());
    return sum;
  }

private:
  std::array<Eigen::Array4f, 3> m_low, m_high, m_way_low, m_way_high; ///< by axis, then box
};

} // namespace wry::contact
