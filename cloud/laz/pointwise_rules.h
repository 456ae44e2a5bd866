// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "cloud/laz/entropy_coder.h"
#include "cloud/laz/shared_models.h"

namespace alidade {

/// The first 20 bytes of point data records of formats 0 to 5, as in LAS files.
struct Point10 {
  std::int32_t x = 0, y = 0, z = 0;
  std::uint16_t intensity = 0;
  std::uint8_t bits = 0;  ///< from the lowest: return number 3, number of returns 3, scan direction, edge
  std::uint8_t classification = 0;
  std::uint8_t scan_angle = 0;
  std::uint8_t user_data = 0;
  std::uint16_t source = 0;

  unsigned return_number() const { return bits & 7; }
  unsigned return_count() const { return bits >> 3 & 7; }
  unsigned scan_direction() const { return bits >> 6 & 1; }
};
static_assert(sizeof(Point10) == 20);

/// Models of both versions of LAZ item POINT10.
class Point10Models {
 protected:
  // Bits of the symbol that lists the changed fields; two others depend on the version.
  static constexpr unsigned k_source = 1, k_user_data = 2, k_scan_angle = 4, k_classification = 8;

  Point10Models(int intensity_contexts, int x_contexts, int y_contexts)
      : intensity_(16, intensity_contexts), x_(32, x_contexts), y_(32, y_contexts) {}

  /// Resets all models; the first record becomes the last point.
  void start(const std::byte* first) {
    last_ = load<Point10>(first);
    changed_.reset();
    for (SymbolModelSet* models : {&bits_, &classifications_, &user_data_}) models->reset();
    for (IntegerCompressor* compressor : {&intensity_, &source_, &x_, &y_, &z_}) compressor->reset();
  }

  /// Those of the bits above that a point sets, by its differences to the last one.
  unsigned changes_to(const Point10& point) const {
    return (point.classification != last_.classification ? k_classification : 0) |
           (point.scan_angle != last_.scan_angle ? k_scan_angle : 0) |
           (point.user_data != last_.user_data ? k_user_data : 0) |
           (point.source != last_.source ? k_source : 0);
  }
  template <class Coder>
  void code_classification(Coder& coder, unsigned changed, const Point10& point, Point10& next) {
    if ((changed & k_classification) != 0)
      next.classification = code_byte(coder, classifications_[last_.classification], point.classification);
  }
  template <class Coder>
  void code_user_data_and_source(Coder& coder, unsigned changed, const Point10& point, Point10& next) {
    if ((changed & k_user_data) != 0)
      next.user_data = code_byte(coder, user_data_[last_.user_data], point.user_data);
    if ((changed & k_source) != 0)
      next.source = static_cast<std::uint16_t>(coder.integer(source_, last_.source, point.source));
  }

  Point10 last_;
  SymbolModel changed_{64};
  SymbolModelSet bits_{256, 256};  // by the previous value, as the next two
  SymbolModelSet classifications_{256, 256};
  SymbolModelSet user_data_{256, 256};
  IntegerCompressor intensity_;
  IntegerCompressor source_{16, 1};
  IntegerCompressor x_;
  IntegerCompressor y_;
  IntegerCompressor z_{32, 20};
};

/// Rules of LAZ item POINT10, version 1, of old files: coordinates are predicted from the last three points,
/// other fields from the last point.
class Point10Version1 : Point10Models {
 public:
  Point10Version1() : Point10Models(1, 1, k_last_context + 1) {}

  void start(const std::byte* first) {
    Point10Models::start(first);
    x_steps_.fill(0);
    y_steps_.fill(0);
    oldest_ = 0;
    scan_angle_.reset();
  }

  /// Codes the next record.
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
  static constexpr unsigned k_bits = 16, k_intensity = 32;
  static constexpr int k_last_context = 19;

  static std::int32_t median(const std::array<std::int32_t, 3>& values) {
    return std::max(std::min(values[0], values[1]), std::min(std::max(values[0], values[1]), values[2]));
  }

  unsigned changes_to(const Point10& point) const {
    return Point10Models::changes_to(point) | (point.intensity != last_.intensity ? k_intensity : 0) |
           (point.bits != last_.bits ? k_bits : 0);
  }

  template <class Coder>
  void code_attributes(Coder& coder, const Point10& point, int bits, Point10& next) {
    const unsigned changed = coder.symbol(changed_, Coder::k_decodes ? 0 : changes_to(point));
    if ((changed & k_intensity) != 0)
      next.intensity =
          static_cast<std::uint16_t>(coder.integer(intensity_, last_.intensity, point.intensity));
    if ((changed & k_bits) != 0) next.bits = code_byte(coder, bits_[last_.bits], point.bits);
    code_classification(coder, changed, point, next);
    if ((changed & k_scan_angle) != 0) {
      next.scan_angle = static_cast<std::uint8_t>(
          coder.integer(scan_angle_, last_.scan_angle, point.scan_angle, bits < 3 ? 1 : 0));
    }
    code_user_data_and_source(coder, changed, point, next);
  }

  std::array<std::int32_t, 3> x_steps_{};
  std::array<std::int32_t, 3> y_steps_{};
  std::size_t oldest_ = 0;  // of the steps
  IntegerCompressor scan_angle_{8, 2};
};

/// Rules of LAZ item POINT10, version 2: attributes are expected to stay; coordinates and intensities are
/// predicted from points that were the same return of as many returns.
class Point10Version2 : Point10Models {
 public:
  Point10Version2() : Point10Models(4, 2, 22) {}

  void start(const std::byte* first) {
    Point10Models::start(first);
    // Not those of the first point, as in all writers.
    last_intensities_.fill(0);
    last_z_.fill(0);
    x_steps_.fill({});
    y_steps_.fill({});
    scan_angles_.reset();
  }

  /// Codes the next record.
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
    code_classification(coder, changed, point, next);
    if ((changed & k_scan_angle) != 0) {
      SymbolModel& model = scan_angles_[next.scan_direction()];
      next.scan_angle = static_cast<std::uint8_t>(
          last_.scan_angle + coder.symbol(model, (point.scan_angle - last_.scan_angle) & 255));
    }
    code_user_data_and_source(coder, changed, point, next);
    code_position(coder, point, kind, next);
    Coder::put(record, next);
    last_ = next;
  }

 private:
  static constexpr unsigned k_intensity = 16, k_bits = 32;

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

  unsigned changes_to(const Point10& point) const {
    const unsigned kind = k_kinds[point.return_count()][point.return_number()];
    return Point10Models::changes_to(point) | (point.intensity != last_intensities_[kind] ? k_intensity : 0) |
           (point.bits != last_.bits ? k_bits : 0);
  }

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
                                              single + bits_context(x_.last_k(), 20));
    y_steps.insert(y_step);
    next.y = wrapped_sum(last_.y, y_step);
    next.z = coder.integer(z_, last_z_[level], point.z,
                           single + bits_context((x_.last_k() + y_.last_k()) / 2, 18));
    last_z_[level] = next.z;
  }

  std::array<std::uint16_t, 16> last_intensities_{};  // by kind
  std::array<std::int32_t, 8> last_z_{};              // by number of returns that are missing
  std::array<MedianPredictor, 16> x_steps_;           // by kind
  std::array<MedianPredictor, 16> y_steps_;
  SymbolModelSet scan_angles_{2, 256};  // by scan direction
};

/// Rules of LAZ item GPSTIME11, version 1, of old files: one sequence of times, the bits of doubles taken as
/// integers, each predicted by a multiple of an earlier difference or else written as it is.
class GpsTimeVersion1 {
 public:
  void start(const std::byte* first) {
    time_ = load<std::int64_t>(first);
    difference_ = 0;
    extremes_ = 0;
    first_.reset();
    multiple_.reset();
    integers_.reset();
  }

  /// Codes the next time.
  template <class Coder, class Byte>
  void code(Coder& coder, Byte* record) {
    const std::int64_t time = Coder::template value<std::int64_t>(record);
    const std::int64_t wide_change = wrapped_difference(time, time_);
    const std::int32_t change = static_cast<std::int32_t>(wide_change);
    const bool near = change == wide_change;
    if (difference_ == 0) {
      switch (coder.symbol(first_, wide_change == 0 ? 0 : near ? 1 : 2)) {
        case 0:
          break;
        case 1:
          difference_ = coder.integer(integers_, 0, change, 0);
          time_ = wrapped_sum<std::int64_t>(time_, difference_);
          break;
        default:
          time_ = static_cast<std::int64_t>(coder.raw64(static_cast<std::uint64_t>(time)));
      }
    } else {
      const unsigned symbol = coder.symbol(multiple_, Coder::k_decodes   ? 0
                                                      : wide_change == 0 ? k_unchanged
                                                      : near             ? multiple_of(change)
                                                                         : k_raw);
      if (symbol == k_raw) {
        time_ = static_cast<std::int64_t>(coder.raw64(static_cast<std::uint64_t>(time)));
      } else if (symbol != k_unchanged) {
        code_multiple(coder, symbol, change);
      }
    }
    Coder::put(record, time_);
  }

 private:
  static constexpr unsigned k_largest_multiple = 509, k_raw = 510, k_unchanged = 511;

  unsigned multiple_of(std::int32_t change) const {
    const std::int64_t quotient = std::int64_t{change} / difference_;
    return static_cast<unsigned>(std::clamp<std::int64_t>(quotient, 0, k_largest_multiple));
  }

  template <class Coder>
  void code_multiple(Coder& coder, unsigned symbol, std::int32_t change) {
    std::int32_t coded;
    if (symbol == 1) {
      coded = coder.integer(integers_, difference_, change, 1);
      difference_ = coded;
      extremes_ = 0;
    } else {
      const std::int32_t prediction =
          symbol == 0 ? difference_ / 4
                      : static_cast<std::int32_t>(symbol * static_cast<std::uint32_t>(difference_));
      const int context = symbol == 0 ? 2 : symbol < 10 ? 3 : symbol < 50 ? 4 : 5;
      coded = coder.integer(integers_, prediction, change, context);
      if ((symbol == 0 || symbol == k_largest_multiple) && ++extremes_ > 3) {
        difference_ = coded;
        extremes_ = 0;
      }
    }
    time_ = wrapped_sum<std::int64_t>(time_, coded);
  }

  std::int64_t time_ = 0;
  std::int32_t difference_ = 0;  // of two times, the unit of those that follow; 0 = not known yet
  int extremes_ = 0;             // differences far from the unit since the last near one
  SymbolModel first_{3};         // unchanged, by a difference, any
  SymbolModel multiple_{512};
  IntegerCompressor integers_{32, 6};
};

/// Rules of LAZ item BYTE, version 2: each byte has a model of its differences.
class ExtraBytesVersion2 {
 public:
  explicit ExtraBytesVersion2(std::size_t count) : last_(count), differences_(count, 256) {}

  void start(const std::byte* first) {
    std::memcpy(last_.data(), first, last_.size());
    differences_.reset();
  }

  /// Codes the next bytes.
  template <class Coder, class Byte>
  void code(Coder& coder, Byte* record) {
    for (std::size_t i = 0; i < last_.size(); ++i) {
      const std::uint8_t value = Coder::template value<std::uint8_t>(record + i);
      last_[i] =
          static_cast<std::uint8_t>(last_[i] + coder.symbol(differences_[i], (value - last_[i]) & 255));
      Coder::put(record + i, last_[i]);
    }
  }

 private:
  std::vector<std::uint8_t> last_;
  SymbolModelSet differences_;
};

/// Rules of LAZ items BYTE and RGB12 in version 1, of old files: each byte is predicted by its last value; of
/// colours only the changed bytes are written, after a symbol that lists them.
class BytesVersion1 {
 public:
  enum class Written { all, changed };

  BytesVersion1(std::size_t count, Written written)
      : written_(written), last_(count), bytes_(8, static_cast<int>(count)) {
    assert(written == Written::all || count == 6);
  }

  void start(const std::byte* first) {
    std::memcpy(last_.data(), first, last_.size());
    changed_.reset();
    bytes_.reset();
  }

  /// Codes the next bytes.
  template <class Coder, class Byte>
  void code(Coder& coder, Byte* record) {
    unsigned changed = 0;
    if (written_ == Written::changed) {
      if constexpr (!Coder::k_decodes) {
        for (std::size_t i = 0; i < last_.size(); ++i)
          changed |= (Coder::template value<std::uint8_t>(record + i) != last_[i] ? 1u : 0u) << i;
      }
      changed = coder.symbol(changed_, changed);
    }
    for (std::size_t i = 0; i < last_.size(); ++i) {
      if (written_ == Written::all || (changed >> i & 1) != 0) {
        last_[i] = static_cast<std::uint8_t>(coder.integer(
            bytes_, last_[i], Coder::template value<std::uint8_t>(record + i), static_cast<int>(i)));
      }
      Coder::put(record + i, last_[i]);
    }
  }

 private:
  Written written_;
  std::vector<std::uint8_t> last_;
  SymbolModel changed_{64};
  IntegerCompressor bytes_;
};

}  // namespace alidade
