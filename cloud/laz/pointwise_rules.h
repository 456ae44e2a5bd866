// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstdlib>

#include "cloud/laz/median_predictor.h"
#include "cloud/laz/point10.h"
#include "cloud/laz/symbol_model_set.h"
#include "cloud/laz/value_coders.h"

namespace alidade {

/// Rules of LAZ item POINT10, version 2: attributes are expected to stay; coordinates and intensities are
/// predicted from points that were the same return of as many returns.
class Point10Version2 {
 public:
  void start(const std::byte* first);

  /// Codes the next record with a coder of layer_coders.h.
  template <class Coder, class Byte>
  void code(Coder& coder, Byte* record) {
    const Point10 point = Coder::template value<Point10>(record);
    Point10 next = last_;
    const unsigned changed = coder.symbol(changed_, Coder::k_decodes ? 0 : changes_to(point));
    if ((changed & k_bits) != 0) next.bits = code_byte(coder, bits_[last_.bits], point.bits);
    const unsigned kind = k_kinds[next.return_count()][next.return_number()];
    if ((changed & k_intensity) != 0) {
      last_intensities_[kind] = static_cast<std::uint16_t>(
          coder.integer(intensity_, last_intensities_[kind], point.intensity, std::min<int>(kind, 3)));
    }
    next.intensity = last_intensities_[kind];
    if ((changed & k_classification) != 0)
      next.classification = code_byte(coder, classifications_[last_.classification], point.classification);
    if ((changed & k_scan_angle) != 0) {
      SymbolModel& model = scan_angles_[next.scan_direction()];
      next.scan_angle = static_cast<std::uint8_t>(
          last_.scan_angle + coder.symbol(model, (point.scan_angle - last_.scan_angle) & 255));
    }
    if ((changed & k_user_data) != 0)
      next.user_data = code_byte(coder, user_data_[last_.user_data], point.user_data);
    if ((changed & k_source) != 0)
      next.source = static_cast<std::uint16_t>(coder.integer(source_, last_.source, point.source));
    code_position(coder, point, kind, next);
    Coder::put(record, next);
    last_ = next;
  }

 private:
  // Bits of the symbol that says what is not as expected.
  static constexpr unsigned k_source = 1, k_user_data = 2, k_scan_angle = 4, k_classification = 8,
                            k_intensity = 16, k_bits = 32;

  // Kinds of points by number of returns and return number.
  static constexpr std::array<std::array<std::uint8_t, 8>, 8> k_kinds = {{
      {15, 14, 13, 12, 11, 10, 9, 8},
      {14, 0, 1, 3, 6, 10, 10, 9},
      {13, 1, 2, 4, 7, 11, 11, 10},
      {12, 3, 4, 5, 8, 12, 12, 11},
      {11, 6, 7, 8, 9, 13, 13, 12},
      {10, 10, 11, 12, 13, 14, 14, 13},
      {9, 10, 11, 12, 13, 14, 15, 14},
      {8, 9, 10, 11, 12, 13, 14, 15},
  }};

  unsigned changes_to(const Point10& point) const;

  // Contexts grow with the number of bits of the coordinates before, up to a highest one.
  static int context(int bits, int highest) { return bits < highest ? bits & ~1 : highest; }

  template <class Coder>
  void code_position(Coder& coder, const Point10& point, unsigned kind, Point10& next) {
    const int single = next.return_count() == 1 ? 1 : 0;
    const unsigned level = static_cast<unsigned>(
        std::abs(static_cast<int>(next.return_count()) - static_cast<int>(next.return_number())));
    MedianPredictor& x_steps = x_steps_[kind];
    const std::int32_t x_step =
        coder.integer(x_, x_steps.median(), wrapped_difference(point.x, last_.x), single);
    x_steps.insert(x_step);
    next.x = wrapped_sum(last_.x, x_step);
    MedianPredictor& y_steps = y_steps_[kind];
    const std::int32_t y_step = coder.integer(y_, y_steps.median(), wrapped_difference(point.y, last_.y),
                                              single + context(x_.last_k(), 20));
    y_steps.insert(y_step);
    next.y = wrapped_sum(last_.y, y_step);
    next.z =
        coder.integer(z_, last_z_[level], point.z, single + context((x_.last_k() + y_.last_k()) / 2, 18));
    last_z_[level] = next.z;
  }

  Point10 last_;
  std::array<std::uint16_t, 16> last_intensities_{};  // by kind
  std::array<std::int32_t, 8> last_z_{};              // by number of returns that are missing
  std::array<MedianPredictor, 16> x_steps_;           // by kind
  std::array<MedianPredictor, 16> y_steps_;
  SymbolModel changed_{64};
  SymbolModelSet bits_{256, 256};  // by the value before, as the next two
  SymbolModelSet classifications_{256, 256};
  SymbolModelSet user_data_{256, 256};
  SymbolModelSet scan_angles_{2, 256};  // by scan direction
  IntegerCompressor intensity_{16, 4};
  IntegerCompressor source_{16, 1};
  IntegerCompressor x_{32, 2};
  IntegerCompressor y_{32, 22};
  IntegerCompressor z_{32, 20};
};

}  // namespace alidade
