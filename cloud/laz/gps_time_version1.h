// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "cloud/laz/value_coders.h"

namespace alidade {

/// Rules of LAZ item GPSTIME11, version 1, of old files: one sequence of times, the bits of doubles taken as
/// integers, each predicted by a multiple of an earlier difference or else written as it is.
class GpsTimeVersion1 {
 public:
  void start(const std::byte* first);

  /// Codes the next time with a coder of layer_coders.h.
  template <class Coder, class Byte>
  void code(Coder& coder, Byte* record) {
    const std::int64_t time = Coder::template value<std::int64_t>(record);
    const std::uint64_t wide_change = static_cast<std::uint64_t>(time) - static_cast<std::uint64_t>(time_);
    const std::int32_t change = static_cast<std::int32_t>(wide_change);
    const bool near = change == static_cast<std::int64_t>(wide_change);
    if (difference_ == 0) {
      switch (coder.symbol(first_, wide_change == 0 ? 0 : near ? 1 : 2)) {
        case 0:
          break;
        case 1:
          difference_ = coder.integer(integers_, 0, change, 0);
          add(difference_);
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

  unsigned multiple_of(std::int32_t change) const;

  void add(std::int32_t change) {
    time_ = static_cast<std::int64_t>(static_cast<std::uint64_t>(time_) +
                                      static_cast<std::uint64_t>(std::int64_t{change}));
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
    add(coded);
  }

  std::int64_t time_ = 0;
  std::int32_t difference_ = 0;  // of two times, the unit of those that follow; 0 = not known yet
  int extremes_ = 0;             // differences far from the unit since the last near one
  SymbolModel first_{3};         // unchanged, by a difference, any
  SymbolModel multiple_{512};
  IntegerCompressor integers_{32, 6};
};

}  // namespace alidade
