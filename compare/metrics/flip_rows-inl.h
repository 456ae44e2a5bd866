// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_FLIP_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_FLIP_ROWS_INL_H
#undef ALIDADE_FLIP_ROWS_INL_H
#else
#define ALIDADE_FLIP_ROWS_INL_H
#endif

#include <cstddef>

#include "compare/metrics/flip_math-inl.h"
#include "compare/metrics/flip_model.h"

// Filters along a row or across rows. A row's neighbours are `step` floats away: 1 along it, the pitch
// across. Rows are worked in whole vectors, up to 16 columns beyond the last.

HWY_BEFORE_NAMESPACE();
namespace alidade::compare::simd {
namespace HWY_NAMESPACE {

HWY_INLINE FloatVector both(const float* from, std::ptrdiff_t away) {
  const FloatLanes d;
  return hn::Add(hn::LoadU(d, from - away), hn::LoadU(d, from + away));
}

HWY_INLINE FloatVector apart(const float* from, std::ptrdiff_t away) {
  const FloatLanes d;
  return hn::Sub(hn::LoadU(d, from + away), hn::LoadU(d, from - away));
}

/// to = taps over from.
HWY_INLINE void filter_row(const float* from, std::ptrdiff_t step, int width, const HalfTaps& taps,
                           float* to) {
  const FloatLanes d;
  const auto count = static_cast<std::ptrdiff_t>(taps.size());
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(d));
  for (std::ptrdiff_t x = 0; x < width; x += lanes) {
    auto sum = hn::Mul(hn::LoadU(d, from + x), set(taps[0]));
    for (std::ptrdiff_t k = 1; k < count; ++k)
      sum = hn::Add(sum, hn::Mul(both(from + x, k * step), set(taps[static_cast<std::size_t>(k)])));
    hn::StoreU(sum, d, to + x);
  }
}

/// Applies two filters to one row in one pass, for blue-yellow.
HWY_INLINE void filter_row_twice(const float* from, std::ptrdiff_t step, int width, const HalfTaps& first,
                                 const HalfTaps& second, float* to_first, float* to_second) {
  const FloatLanes d;
  const auto count = static_cast<std::ptrdiff_t>(first.size());
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(d));
  for (std::ptrdiff_t x = 0; x < width; x += lanes) {
    const auto middle = hn::LoadU(d, from + x);
    auto sum = hn::Mul(middle, set(first[0])), other = hn::Mul(middle, set(second[0]));
    for (std::ptrdiff_t k = 1; k < count; ++k) {
      const auto pair = both(from + x, k * step);
      sum = hn::Add(sum, hn::Mul(pair, set(first[static_cast<std::size_t>(k)])));
      other = hn::Add(other, hn::Mul(pair, set(second[static_cast<std::size_t>(k)])));
    }
    hn::StoreU(sum, d, to_first + x);
    hn::StoreU(other, d, to_second + x);
  }
}

/// to = first over from_first + second over from_second.
HWY_INLINE void filter_row_sum(const float* from_first, const float* from_second, std::ptrdiff_t step,
                               int width, const HalfTaps& first, const HalfTaps& second, float* to) {
  const FloatLanes d;
  const auto count = static_cast<std::ptrdiff_t>(first.size());
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(d));
  for (std::ptrdiff_t x = 0; x < width; x += lanes) {
    auto sum = hn::Mul(hn::LoadU(d, from_first + x), set(first[0]));
    auto other = hn::Mul(hn::LoadU(d, from_second + x), set(second[0]));
    for (std::ptrdiff_t k = 1; k < count; ++k) {
      sum = hn::Add(sum, hn::Mul(both(from_first + x, k * step), set(first[static_cast<std::size_t>(k)])));
      other =
          hn::Add(other, hn::Mul(both(from_second + x, k * step), set(second[static_cast<std::size_t>(k)])));
    }
    hn::StoreU(hn::Add(sum, other), d, to + x);
  }
}

/// Smoothed, first and second derivative along the row.
HWY_INLINE void feature_row(const float* from, int width, const FlipFilters& filters, float* smooth,
                            float* edge, float* point) {
  const FloatLanes d;
  const auto count = static_cast<std::ptrdiff_t>(filters.smooth.size());
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(d));
  for (std::ptrdiff_t x = 0; x < width; x += lanes) {
    const auto middle = hn::LoadU(d, from + x);
    auto smooth_sum = hn::Mul(middle, set(filters.smooth[0]));
    auto point_sum = hn::Mul(middle, set(filters.point[0]));
    auto edge_sum = hn::Zero(d);
    for (std::ptrdiff_t k = 1; k < count; ++k) {
      const auto tap = static_cast<std::size_t>(k);
      const auto pair = both(from + x, k);
      smooth_sum = hn::Add(smooth_sum, hn::Mul(pair, set(filters.smooth[tap])));
      point_sum = hn::Add(point_sum, hn::Mul(pair, set(filters.point[tap])));
      edge_sum = hn::Add(edge_sum, hn::Mul(apart(from + x, k), set(filters.edge[tap])));
    }
    hn::StoreU(smooth_sum, d, smooth + x);
    hn::StoreU(edge_sum, d, edge + x);
    hn::StoreU(point_sum, d, point + x);
  }
}

HWY_INLINE FloatVector length(FloatVector x, FloatVector y) {
  return hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y)));
}

/// Filters the results of feature_row() across rows: strength of edges and of points.
HWY_INLINE void feature_columns(const float* smooth, const float* edge, const float* point,
                                std::ptrdiff_t step, int width, const FlipFilters& filters, float* edges,
                                float* points) {
  const FloatLanes d;
  const auto count = static_cast<std::ptrdiff_t>(filters.smooth.size());
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(d));
  for (std::ptrdiff_t x = 0; x < width; x += lanes) {
    const auto middle = hn::LoadU(d, smooth + x);
    auto edge_x = hn::Mul(hn::LoadU(d, edge + x), set(filters.smooth[0]));
    auto point_x = hn::Mul(hn::LoadU(d, point + x), set(filters.smooth[0]));
    auto point_y = hn::Mul(middle, set(filters.point[0]));
    auto edge_y = hn::Zero(d);
    for (std::ptrdiff_t k = 1; k < count; ++k) {
      const auto tap = static_cast<std::size_t>(k);
      const std::ptrdiff_t away = k * step;
      const auto smooth_tap = set(filters.smooth[tap]);
      edge_x = hn::Add(edge_x, hn::Mul(both(edge + x, away), smooth_tap));
      point_x = hn::Add(point_x, hn::Mul(both(point + x, away), smooth_tap));
      point_y = hn::Add(point_y, hn::Mul(both(smooth + x, away), set(filters.point[tap])));
      edge_y = hn::Add(edge_y, hn::Mul(apart(smooth + x, away), set(filters.edge[tap])));
    }
    hn::StoreU(length(edge_x, edge_y), d, edges + x);
    hn::StoreU(length(point_x, point_y), d, points + x);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace alidade::compare::simd
HWY_AFTER_NAMESPACE();

#endif
