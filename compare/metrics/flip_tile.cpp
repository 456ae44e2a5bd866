// SPDX-License-Identifier: MIT
#include "compare/metrics/flip_model.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "compare/metrics/flip_tile.cpp"
#include <hwy/foreach_target.h>

#include "compare/metrics/flip_model.h"
#include "compare/metrics/flip_rows-inl.h"
#include "octree/simd/choose_table.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::compare::simd {
namespace HWY_NAMESPACE {

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
