// SPDX-License-Identifier: MIT
#include "compare/metrics/flip_tile.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "compare/metrics/flip_tile.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "octree/simd/choose_table.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::compare::simd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using FloatLanes = hn::CappedTag<float, 16>;
using FloatVector = hn::Vec<FloatLanes>;
using IntLanes = hn::RebindToSigned<FloatLanes>;

HWY_INLINE FloatVector set(float value) {
  return hn::Set(FloatLanes(), value);
}

/// To 0 .. 1; NaN becomes 0. (Which of two operands a lane's maximum takes with NaN depends on the machine.)
HWY_INLINE FloatVector clamped(FloatVector value) {
  return hn::IfThenElseZero(hn::Gt(value, hn::Zero(FloatLanes())), hn::Min(value, set(1.0f)));
}

/// Relative error below 2e-7 for x in [1e-3, 2]. Source: Halley's method, twice, from the exponent divided by
/// three.
HWY_INLINE FloatVector cube_root(FloatVector x) {
  const IntLanes ints;
  const auto third = hn::Mul(hn::ConvertTo(FloatLanes(), hn::BitCast(ints, x)), set(1.0f / 3.0f));
  auto y = hn::BitCast(FloatLanes(), hn::Add(hn::ConvertTo(ints, third), hn::Set(ints, 709921077)));
  for (int i = 0; i < 2; ++i) {
    const auto cube = hn::Mul(hn::Mul(y, y), y);
    const auto twice = hn::Add(cube, cube);
    y = hn::Mul(y, hn::Div(hn::Add(cube, hn::Add(x, x)), hn::Add(twice, x)));
  }
  return y;
}

/// Error below 2e-7 of the larger of 1 and the result, for x in [1e-37, 1e37]. Series: as binary_logarithm().
HWY_INLINE FloatVector log2_of(FloatVector x) {
  const IntLanes ints;
  const auto bits = hn::BitCast(ints, x);
  // The bits of sqrt(1/2): mantissas lie on both sides of 1.
  const auto exponent = hn::ShiftRight<23>(hn::Sub(bits, hn::Set(ints, 0x3f3504f3)));
  const auto mantissa = hn::BitCast(FloatLanes(), hn::Sub(bits, hn::ShiftLeft<23>(exponent)));
  const auto s = hn::Div(hn::Sub(mantissa, set(1.0f)), hn::Add(mantissa, set(1.0f)));
  const auto s2 = hn::Mul(s, s);
  constexpr float k_twice_log2e = 2.88539008f;
  auto sum = set(k_twice_log2e / 9.0f);
  for (const float divisor : {7.0f, 5.0f, 3.0f, 1.0f})
    sum = hn::Add(hn::Mul(sum, s2), set(k_twice_log2e / divisor));
  return hn::Add(hn::ConvertTo(FloatLanes(), exponent), hn::Mul(s, sum));
}

/// 2^y, for y clamped to [-126, 126]. Relative error below 2e-7. Source: Taylor series around the nearest
/// integer.
HWY_INLINE FloatVector exp2_of(FloatVector y) {
  const IntLanes ints;
  y = hn::Min(hn::Max(y, set(-126.0f)), set(126.0f));
  // Conversion cuts off, towards 0 on every machine; so the number is made positive first.
  const auto whole = hn::Sub(hn::ConvertTo(ints, hn::Add(y, set(128.5f))), hn::Set(ints, 128));
  const auto x = hn::Mul(hn::Sub(y, hn::ConvertTo(FloatLanes(), whole)), set(0.693147181f));
  auto sum = set(1.0f / 5040.0f);
  for (const float factor : {1.0f / 720.0f, 1.0f / 120.0f, 1.0f / 24.0f, 1.0f / 6.0f, 0.5f, 1.0f, 1.0f})
    sum = hn::Add(hn::Mul(sum, x), set(factor));
  const auto power = hn::ShiftLeft<23>(hn::Add(whole, hn::Set(ints, 127)));
  return hn::Mul(sum, hn::BitCast(FloatLanes(), power));
}

/// base^exponent for base in [0, 1e30] and exponent in [0, 1]; 0^0 = 1.
HWY_INLINE FloatVector power(FloatVector base, FloatVector exponent) {
  constexpr float k_nearly_zero = 1e-30f;
  const auto zero = hn::Zero(FloatLanes());
  const auto result = exp2_of(hn::Mul(log2_of(hn::Max(base, set(k_nearly_zero))), exponent));
  const auto is_zero = hn::And(hn::Le(base, zero), hn::Gt(exponent, zero));
  return hn::IfThenElse(is_zero, zero, result);
}

// Filters along a row or across rows. A row's neighbours are `step` floats away: 1 along it, the pitch
// across. Rows are worked in whole vectors, up to 16 columns beyond the last.

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

struct Triple {
  FloatVector x, y, z;
};

HWY_INLINE FloatVector product(const float (&row)[3], const Triple& value) {
  return hn::Add(hn::Add(hn::Mul(value.x, set(row[0])), hn::Mul(value.y, set(row[1]))),
                 hn::Mul(value.z, set(row[2])));
}

HWY_INLINE Triple product(const float (&matrix)[3][3], const Triple& value) {
  return {product(matrix[0], value), product(matrix[1], value), product(matrix[2], value)};
}

HWY_INLINE Triple clamped(const Triple& value) {
  return {clamped(value.x), clamped(value.y), clamped(value.z)};
}

HWY_INLINE FloatVector rational(const ToneCurve& curve, FloatVector value) {
  // Squares of larger values may overflow; the curve has long reached its end.
  const auto x = hn::Min(value, set(1e9f)), x2 = hn::Mul(x, x);
  const auto above =
      hn::Add(hn::Add(hn::Mul(x2, set(curve.k[0])), hn::Mul(x, set(curve.k[1]))), set(curve.k[2]));
  const auto below =
      hn::Add(hn::Add(hn::Mul(x2, set(curve.k[3])), hn::Mul(x, set(curve.k[4]))), set(curve.k[5]));
  return hn::Div(above, below);
}

HWY_INLINE Triple toned(const ToneCurve& curve, Triple rgb) {
  if (curve.kind == ToneCurve::Kind::none) return clamped(rgb);
  const auto scale = set(curve.scale);
  rgb = {hn::Mul(rgb.x, scale), hn::Mul(rgb.y, scale), hn::Mul(rgb.z, scale)};
  if (curve.kind == ToneCurve::Kind::rational)
    return clamped(Triple{rational(curve, rgb.x), rational(curve, rgb.y), rational(curve, rgb.z)});
  constexpr float k_luminance[3] = {0.2126f, 0.7152f, 0.0722f};
  const auto divisor = hn::Add(product(k_luminance, rgb), set(1.0f));
  return clamped(Triple{hn::Div(rgb.x, divisor), hn::Div(rgb.y, divisor), hn::Div(rgb.z, divisor)});
}

void to_opponent(FlipTile& tile, int image, const ToneCurve& curve) {
  const FloatLanes d;
  const FlipColor& color = flip_color();
  const std::size_t count = tile.pitch() * static_cast<std::size_t>(tile.rows_with_margin());
  const float* const red = tile.rgb(image, 0);
  const float* const green = tile.rgb(image, 1);
  const float* const blue = tile.rgb(image, 2);
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const Triple rgb{hn::LoadU(d, red + i), hn::LoadU(d, green + i), hn::LoadU(d, blue + i)};
    const Triple xyz = product(color.xyz_from_rgb, toned(curve, rgb));
    hn::StoreU(xyz.y, d, tile.opponent(0) + i);
    hn::StoreU(hn::Sub(xyz.x, xyz.y), d, tile.opponent(1) + i);
    hn::StoreU(hn::Sub(xyz.y, xyz.z), d, tile.opponent(2) + i);
  }
}

/// Calls work(offset in the tile's planes with margin, offset in those without) for each row of the tile.
template <class Work>
HWY_INLINE void for_each_row(const FlipTile& tile, const Work& work) {
  for (int y = 0; y < tile.height(); ++y)
    work(tile.pitch() * static_cast<std::size_t>(y + tile.margin()),
         tile.pitch() * static_cast<std::size_t>(y));
}

void filter_channel(FlipTile& tile, int channel, const HalfTaps& taps, float* to) {
  const auto step = static_cast<std::ptrdiff_t>(tile.pitch());
  for (int y = 0; y < tile.rows_with_margin(); ++y) {
    const std::size_t row = tile.pitch() * static_cast<std::size_t>(y);
    filter_row(tile.opponent(channel) + row + tile.margin(), 1, tile.width(), taps, tile.pass(0) + row);
  }
  for_each_row(tile, [&](std::size_t wide, std::size_t narrow) {
    filter_row(tile.pass(0) + wide, step, tile.width(), taps, to + narrow);
  });
}

void filter_blue_yellow(FlipTile& tile, const FlipFilters& filters, float* to) {
  const auto step = static_cast<std::ptrdiff_t>(tile.pitch());
  for (int y = 0; y < tile.rows_with_margin(); ++y) {
    const std::size_t row = tile.pitch() * static_cast<std::size_t>(y);
    filter_row_twice(tile.opponent(2) + row + tile.margin(), 1, tile.width(), filters.blue_yellow,
                     filters.blue_yellow_wide, tile.pass(0) + row, tile.pass(1) + row);
  }
  for_each_row(tile, [&](std::size_t wide, std::size_t narrow) {
    filter_row_sum(tile.pass(0) + wide, tile.pass(1) + wide, step, tile.width(), filters.blue_yellow,
                   filters.blue_yellow_wide, to + narrow);
  });
}

void find_features(FlipTile& tile, int image, const FlipFilters& filters) {
  const auto step = static_cast<std::ptrdiff_t>(tile.pitch());
  for (int y = 0; y < tile.rows_with_margin(); ++y) {
    const std::size_t row = tile.pitch() * static_cast<std::size_t>(y);
    feature_row(tile.opponent(0) + row + tile.margin(), tile.width(), filters, tile.pass(0) + row,
                tile.pass(1) + row, tile.pass(2) + row);
  }
  for_each_row(tile, [&](std::size_t wide, std::size_t narrow) {
    feature_columns(tile.pass(0) + wide, tile.pass(1) + wide, tile.pass(2) + wide, step, tile.width(),
                    filters, tile.edges(image) + narrow, tile.points(image) + narrow);
  });
}

HWY_INLINE FloatVector lab_curve(FloatVector value) {
  constexpr float k_knee = 6.0f / 29.0f;
  const auto line = hn::Add(hn::Mul(value, set(1.0f / (3.0f * k_knee * k_knee))), set(4.0f / 29.0f));
  // The root of values far below the knee is not used, but must not divide by zero.
  const auto curved = cube_root(hn::Max(value, set(1e-3f)));
  return hn::IfThenElse(hn::Gt(value, set(k_knee * k_knee * k_knee)), curved, line);
}

/// The filtered channels of an image become colours as hunt_color() makes them.
void to_hunt(FlipTile& tile, int image) {
  const FloatLanes d;
  const FlipColor& color = flip_color();
  float* const first = tile.color(image, 0);
  float* const second = tile.color(image, 1);
  float* const third = tile.color(image, 2);
  const std::size_t count = tile.pitch() * static_cast<std::size_t>(tile.height());
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto y = hn::LoadU(d, first + i);
    const Triple filtered{hn::Add(y, hn::LoadU(d, second + i)), y, hn::Sub(y, hn::LoadU(d, third + i))};
    const Triple xyz = product(color.xyz_from_rgb, clamped(product(color.rgb_from_xyz, filtered)));
    const auto fx = lab_curve(xyz.x), fy = lab_curve(xyz.y), fz = lab_curve(xyz.z);
    const auto lightness = hn::Sub(hn::Mul(fy, set(116.0f)), set(16.0f));
    const auto hunt = hn::Mul(lightness, set(0.01f));
    hn::StoreU(lightness, d, first + i);
    hn::StoreU(hn::Mul(hunt, hn::Mul(hn::Sub(fx, fy), set(500.0f))), d, second + i);
    hn::StoreU(hn::Mul(hunt, hn::Mul(hn::Sub(fy, fz), set(200.0f))), d, third + i);
  }
}

/// Colour difference in 0 .. 1: HyAB^0.7, up to 0.4 of the largest spread over 0 .. 0.95.
HWY_INLINE FloatVector color_difference(FloatVector distance) {
  constexpr float k_power = 0.7f, k_knee = 0.4f, k_share = 0.95f;
  const float largest = flip_color().largest_difference, knee = k_knee * largest;
  const auto difference = power(distance, set(k_power));
  const auto low = hn::Mul(difference, set(k_share / knee));
  const auto high = hn::Add(hn::Mul(hn::Sub(difference, set(knee)), set((1.0f - k_share) / (largest - knee))),
                            set(k_share));
  return clamped(hn::IfThenElse(hn::Lt(difference, set(knee)), low, high));
}

void raise_map(FlipTile& tile) {
  const FloatLanes d;
  constexpr float k_inverse_sqrt2 = 0.707106781f;
  const auto one = set(1.0f);
  const std::size_t count = tile.pitch() * static_cast<std::size_t>(tile.height());
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto apart_in = [&](float* reference, float* test) {
      return hn::Sub(hn::LoadU(d, reference + i), hn::LoadU(d, test + i));
    };
    const auto lightness = hn::Abs(apart_in(tile.color(0, 0), tile.color(1, 0)));
    const auto chroma =
        length(apart_in(tile.color(0, 1), tile.color(1, 1)), apart_in(tile.color(0, 2), tile.color(1, 2)));
    const auto color = color_difference(hn::Add(lightness, chroma));
    const auto feature = hn::Max(hn::Abs(apart_in(tile.edges(0), tile.edges(1))),
                                 hn::Abs(apart_in(tile.points(0), tile.points(1))));
    const auto feature_difference = hn::Sqrt(clamped(hn::Mul(feature, set(k_inverse_sqrt2))));
    const auto flip = power(color, hn::Sub(one, feature_difference));
    hn::StoreU(hn::Max(hn::LoadU(d, tile.map() + i), hn::Min(flip, one)), d, tile.map() + i);
  }
}

void add_exposure(FlipTile& tile, const FlipFilters& filters, const ToneCurve& curve) {
  for (int image = 0; image < 2; ++image) {
    to_opponent(tile, image, curve);
    filter_channel(tile, 0, filters.achromatic, tile.color(image, 0));
    filter_channel(tile, 1, filters.red_green, tile.color(image, 1));
    filter_blue_yellow(tile, filters, tile.color(image, 2));
    find_features(tile, image, filters);
    to_hunt(tile, image);
  }
  raise_map(tile);
}

constexpr FlipKernel k_flip_kernel{add_exposure};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::compare::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::compare {

namespace {
constexpr std::size_t k_widest_vector = 16;

std::size_t in_vectors(std::size_t count) {
  return (count + k_widest_vector - 1) / k_widest_vector * k_widest_vector;
}
}  // namespace

FlipTile::FlipTile(int most_width, int most_height, int margin) : margin_(margin) {
  const auto wide_margin = static_cast<std::size_t>(2 * margin), rows = static_cast<std::size_t>(most_height);
  pitch_ = in_vectors(in_vectors(static_cast<std::size_t>(most_width)) + wide_margin);
  wide_size_ = pitch_ * (rows + wide_margin);
  narrow_size_ = pitch_ * rows;
  values_.assign(12 * wide_size_ + 11 * narrow_size_, 0.0f);
}

void FlipTile::begin(int width, int height) {
  width_ = width;
  height_ = height;
  std::fill_n(map(), narrow_size_, 0.0f);
}

namespace simd {

const FlipKernel& flip_kernel(InstructionSet instruction_set) {
  ALIDADE_CHOOSE_TABLE(instruction_set, k_flip_kernel)
}

}  // namespace simd
}  // namespace alidade::compare
#endif  // HWY_ONCE
