// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cloud/laz/symbol_model_set.h"
#include "cloud/laz/value_coders.h"

namespace alidade {

/// Rules of LAZ item BYTE, version 2: each byte has a model of its differences.
class ExtraBytesVersion2 {
 public:
  explicit ExtraBytesVersion2(std::size_t count) : last_(count), differences_(count, 256) {}

  void start(const std::byte* first);

  /// Codes the next bytes with a coder of layer_coders.h.
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

/// Rules of LAZ items BYTE and RGB12 in version 1, of old files: bytes predicted by themselves; of colours
/// only those that have changed, which a symbol says, are written.
class BytesVersion1 {
 public:
  enum class Written { all, changed };

  BytesVersion1(std::size_t count, Written written);

  void start(const std::byte* first);

  /// Codes the next bytes with a coder of layer_coders.h.
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
