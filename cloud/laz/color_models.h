// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "cloud/laz/arithmetic_encoder.h"
#include "cloud/laz/entropy_coder.h"

namespace alidade {

/// Codes colours of LAZ streams, version 2 of the old and all versions of the new formats: which of the six
/// bytes differ from the previous colour's, then these bytes; green and blue are expected to change as red
/// did. A colour is the six bytes of a point data record: red, green, blue as u16.
class ColorModels {
 public:
  ColorModels();

  /// All models are fresh again.
  void reset();

  /// Replaces the previous colour by the next one. Does not allocate.
  void decode(ArithmeticDecoder& decoder, std::byte* color);

  /// Writes the colour that follows `previous`. False if that could be left out: neither does a byte differ,
  /// nor is the colour anything but grey.
  bool encode(ArithmeticEncoder& encoder, const std::byte* previous, const std::byte* color);

 private:
  SymbolModel used_;
  std::vector<SymbolModel> bytes_;  // by place in the record
};

}  // namespace alidade
