// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

#include "cloud/laz/layered_point.h"
#include "cloud/laz/value_coders.h"

namespace alidade {

/// Neighbouring points of a chunk and their records; Byte is const for encoding.
template <class Byte>
struct LayerBlock {
  std::span<const LayeredPoint> points;
  Byte* records;  ///< that of the first of the points
  std::size_t record_size;
};

/// One attribute of the points of a layered LAZ chunk, which is a stream of its own. A layer is taken through
/// a chunk block by block, all points but the first, and is used again for the next chunk.
class Layer {
 public:
  /// Part of the record that holds the attribute, and what it is called in messages.
  struct Field {
    const char* name;
    std::size_t offset, size;  ///< bytes
  };

  explicit Layer(const Field& field) : field_(field) {}
  Layer(const Layer&) = delete;
  Layer& operator=(const Layer&) = delete;
  virtual ~Layer() = default;

  const char* name() const { return field_.name; }

  /// Begins a chunk with its first record, which is stored as it is; `channel` is that of its scanner.
  virtual void start(const std::byte* first_record, unsigned channel) = 0;

  /// Puts the attribute into the records. Errors: what ArithmeticDecoder::failed() says.
  virtual void decode(ArithmeticDecoder& decoder, const LayerBlock<std::byte>& block) = 0;

  virtual void encode(ArithmeticEncoder& encoder, const LayerBlock<const std::byte>& block) = 0;

  /// Whether the records need this layer: without it all of them have the value of the first.
  virtual bool needed(std::span<const std::byte> records, std::size_t record_size) const;

 protected:
  const Field& field() const { return field_; }

 private:
  Field field_;
};

/// A layer whose rules are `template <class Coder, class Byte> void code(Coder&, const LayeredPoint&, Byte*
/// field)` of Derived, for one point.
template <class Derived>
class LayerOfPoints : public Layer {
 public:
  using Layer::Layer;

  void decode(ArithmeticDecoder& decoder, const LayerBlock<std::byte>& block) final {
    // A copy that nothing else points to stays in registers.
    ArithmeticDecoder local = decoder;
    code_all<LayerDecoding>(local, block);
    decoder = local;
  }

  void encode(ArithmeticEncoder& encoder, const LayerBlock<const std::byte>& block) final {
    code_all<LayerEncoding>(encoder, block);
  }

 private:
  template <class Coder, class Stream, class Byte>
  void code_all(Stream& stream, const LayerBlock<Byte>& block) {
    Coder coder(stream);
    Byte* at = block.records + field().offset;
    for (const LayeredPoint& point : block.points) {
      static_cast<Derived&>(*this).code(coder, point, at);
      at += block.record_size;
    }
  }
};

}  // namespace alidade
