// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>

#include "cloud/laz/point10.h"
#include "cloud/laz/symbol_model_set.h"
#include "cloud/laz/value_coders.h"

namespace alidade {

/// Rules of LAZ item POINT10, version 1, of old files: coordinates are predicted from the last three points,
/// all else from the last.
class Point10Version1 {
 public:
  void start(const std::byte* first);

  /// Codes the next record with a coder of layer_coders.h.
  template <class Coder, class Byte>
  void code(Coder& coder, Byte* record) {
    const Point10 point = Coder::template value<Point10>(record);
    Point10 next = last_;
    const std::int32_t x_step = coder.integer(x_, median(x_steps_), wrapped_difference(point.x, last_.x));
    const int x_bits = x_.last_k();
    const std::int32_t y_step = coder.integer(y_, median(y_steps_), wrapped_difference(point.y, last_.y),
                                              std::min(x_bits, k_last_context));
    const int bits = (x_bits + y_.last_k()) / 2;
    next.x = wrapped_sum(last_.x, x_step);
    next.y = wrapped_sum(last_.y, y_step);
    next.z = coder.integer(z_, last_.z, point.z, std::min(bits, k_last_context));
    code_attributes(coder, point, bits, next);
    x_steps_[oldest_] = x_step;
    y_steps_[oldest_] = y_step;
    oldest_ = (oldest_ + 1) % 3;
    Coder::put(record, next);
    last_ = next;
  }

 private:
  // Bits of the symbol that says what has changed; two of them differ from version 2.
  static constexpr unsigned k_source = 1, k_user_data = 2, k_scan_angle = 4, k_classification = 8,
                            k_bits = 16, k_intensity = 32;
  static constexpr int k_last_context = 19;

  static std::int32_t median(const std::array<std::int32_t, 3>& values) {
    return std::max(std::min(values[0], values[1]), std::min(std::max(values[0], values[1]), values[2]));
  }

  unsigned changes_to(const Point10& point) const;

  template <class Coder>
  void code_attributes(Coder& coder, const Point10& point, int bits, Point10& next) {
    const unsigned changed = coder.symbol(changed_, Coder::k_decodes ? 0 : changes_to(point));
    if ((changed & k_intensity) != 0)
      next.intensity =
          static_cast<std::uint16_t>(coder.integer(intensity_, last_.intensity, point.intensity));
    if ((changed & k_bits) != 0) next.bits = code_byte(coder, bits_[last_.bits], point.bits);
    if ((changed & k_classification) != 0)
      next.classification = code_byte(coder, classifications_[last_.classification], point.classification);
    if ((changed & k_scan_angle) != 0) {
      next.scan_angle = static_cast<std::uint8_t>(
          coder.integer(scan_angle_, last_.scan_angle, point.scan_angle, bits < 3 ? 1 : 0));
    }
    if ((changed & k_user_data) != 0)
      next.user_data = code_byte(coder, user_data_[last_.user_data], point.user_data);
    if ((changed & k_source) != 0)
      next.source = static_cast<std::uint16_t>(coder.integer(source_, last_.source, point.source));
  }

  Point10 last_;
  std::array<std::int32_t, 3> x_steps_{};
  std::array<std::int32_t, 3> y_steps_{};
  std::size_t oldest_ = 0;  // of the steps
  SymbolModel changed_{64};
  SymbolModelSet bits_{256, 256};  // by the value before, as the next two
  SymbolModelSet classifications_{256, 256};
  SymbolModelSet user_data_{256, 256};
  IntegerCompressor scan_angle_{8, 2};
  IntegerCompressor intensity_{16, 1};
  IntegerCompressor source_{16, 1};
  IntegerCompressor x_{32, 1};
  IntegerCompressor y_{32, k_last_context + 1};
  IntegerCompressor z_{32, k_last_context + 1};
};

}  // namespace alidade
