// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cloud/laz/integer_compressor.h"

namespace alidade {

/// Codes wave packets of LAZ streams, in the old and the new formats alike: descriptor index, place of the
/// waveform, which often follows the previous one, its size, and four floats as the integers of their bits.
/// A wave packet is the 29 bytes of a point data record.
class WavePacketModels {
 public:
  static constexpr std::size_t k_size = 29;

  WavePacketModels();

  /// All models are fresh again.
  void reset();

  /// Replaces the previous wave packet by the next one. Does not allocate.
  void decode(ArithmeticDecoder& decoder, std::byte* packet);

  /// Writes the wave packet that follows `previous`.
  void encode(ArithmeticEncoder& encoder, const std::byte* previous, const std::byte* packet);

 private:
  SymbolModel descriptor_index_;
  std::vector<SymbolModel> moves_;  // by the last move: how the place changes
  IntegerCompressor place_;
  IntegerCompressor size_;
  IntegerCompressor return_point_;
  IntegerCompressor direction_;  // context: x, y, z
  unsigned last_move_ = 0;
  std::int32_t last_difference_ = 0;  // of places, when it was last written
};

}  // namespace alidade
