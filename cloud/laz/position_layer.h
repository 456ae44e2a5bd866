// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cloud/laz/entropy_coder.h"
#include "cloud/laz/layer.h"
#include "cloud/laz/shared_models.h"

namespace alidade {

/// The first layer of POINT14, which every other needs: scanner channel, which attributes change, returns, x
/// and y. Passes through a chunk block by block, all points but the first.
class PositionLayer {
 public:
  /// Begins a chunk. For encoding, all records must stay where they are until the chunk ends.
  void start(const std::byte* first_record);

  /// Fills `points`, and x, y, returns and scanner channel of their records. The flags in the byte of the
  /// channel are left as they are.
  void decode(ArithmeticDecoder& decoder, std::span<LayeredPoint> points, std::byte* records,
              std::size_t record_size);

  /// Fills `points` from the records.
  void encode(ArithmeticEncoder& encoder, std::span<LayeredPoint> points, const std::byte* records,
              std::size_t record_size);

 private:
  /// The last point of a channel.
  struct Last {
    std::int32_t x, y;
    std::uint8_t returns;     // as in the record
    const std::byte* record;  // when encoding
  };

  struct Channel {
    void open(const Last& value);
    SymbolModelSet changes{8, 128};
    SymbolModel next_channel{3};
    SymbolModelSet number_of_returns{16, 16};
    SymbolModelSet return_number{16, 16};
    SymbolModel return_step{13};
    IntegerCompressor dx{32, 2};
    IntegerCompressor dy{32, 22};
    std::array<MedianPredictor, 12> median_x, median_y;
    Last last{};
    bool gps_time_changed = false;
  };

  template <class Coder, class Byte>
  void code(Coder& coder, LayeredPoint& point, Byte* record);
  template <class Coder>
  unsigned code_returns(Coder& coder, Channel& channel, unsigned changes, unsigned returns);

  ChannelStates<Channel> channels_;
};

}  // namespace alidade
