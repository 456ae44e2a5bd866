// SPDX-License-Identifier: MIT
#include "cloud/laz/pointwise_codec.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

#include "cloud/laz/pointwise_rules.h"

namespace alidade {
namespace {

class GpsTimeVersion2 {
 public:
  void start(const std::byte* first) { model_.start(load<std::int64_t>(first)); }

  template <class Coder, class Byte>
  void code(Coder& coder, Byte* record) {
    Coder::put(record, model_.code(coder, Coder::template value<std::int64_t>(record)));
  }

 private:
  GpsTimeModel model_{GpsTimeModel::Unchanged::has_code};
};

/// Rules whose models replace the previous value by the next.
template <class Models, std::size_t size>
class ValueRules {
 public:
  void start(const std::byte* first) {
    models_.reset();
    std::memcpy(last_.data(), first, size);
  }

  template <class Coder, class Byte>
  void code(Coder& coder, Byte* record) {
    models_.code(coder, last_.data(), record);
    Coder::put(record, last_);
  }

 private:
  Models models_;
  std::array<std::byte, size> last_{};
};

/// An item whose rules are written once for decoding and encoding.
template <class Rules>
class ItemOfRules final : public PointwiseItem {
 public:
  template <class... Arguments>
  explicit ItemOfRules(Arguments... arguments) : rules_(arguments...) {}

  void start(const std::byte* first) override { rules_.start(first); }

  void decode(ArithmeticDecoder& stream, std::byte* item) override {
    // A copy that nothing else points to stays in registers.
    ArithmeticDecoder copy = stream;
    rules_.code(copy, item);
    stream = copy;
  }

  void encode(ArithmeticEncoder& stream, const std::byte* item) override { rules_.code(stream, item); }

 private:
  Rules rules_;
};

std::unique_ptr<PointwiseItem> make_pointwise_item(const LazItem& item) {
  const bool old = item.version == 1;
  if (old || item.version == 2) {
    switch (item.kind) {
      case LazItemKind::point10:
        if (item.size != sizeof(Point10)) break;
        if (old) return std::make_unique<ItemOfRules<Point10Version1>>();
        return std::make_unique<ItemOfRules<Point10Version2>>();
      case LazItemKind::gps_time11:
        if (item.size != 8) break;
        if (old) return std::make_unique<ItemOfRules<GpsTimeVersion1>>();
        return std::make_unique<ItemOfRules<GpsTimeVersion2>>();
      case LazItemKind::rgb12:
        if (item.size != 6) break;
        if (old) return std::make_unique<ItemOfRules<BytesVersion1>>(6, BytesVersion1::Written::changed);
        return std::make_unique<ItemOfRules<ValueRules<ColorModels, 6>>>();
      case LazItemKind::wave_packet13:
        if (item.size != WavePacketModels::k_size || !old) break;
        return std::make_unique<ItemOfRules<ValueRules<WavePacketModels, WavePacketModels::k_size>>>();
      case LazItemKind::byte:
        if (item.size == 0) break;
        if (old) return std::make_unique<ItemOfRules<BytesVersion1>>(item.size, BytesVersion1::Written::all);
        return std::make_unique<ItemOfRules<ExtraBytesVersion2>>(item.size);
      default:
        break;
    }
  }
  throw CorruptChunk(
      fmt::format("unsupported item; expected kinds 0 and 6 to 9 in versions 1 and 2, found "
                  "kind {} of {} bytes in version {}",
                  static_cast<unsigned>(item.kind), item.size, item.version));
}

constexpr std::size_t k_shortest_stream = 4;  // an empty stream

/// The items of a layout in their order. Errors: CorruptChunk, if pointwise streams have no such items.
std::vector<PlacedItem> make_pointwise_items(const LazLayout& layout) {
  std::vector<PlacedItem> items;
  std::size_t offset = 0;
  for (const LazItem& item : layout.items) {
    items.push_back({.offset = offset, .rules = make_pointwise_item(item)});
    offset += item.size;
  }
  return items;
}

}  // namespace

PointwiseDecoder::PointwiseDecoder(const LazLayout& layout)
    : record_size_(layout.record_size()), items_(make_pointwise_items(layout)) {}

void PointwiseDecoder::start(std::span<const std::byte> chunk) {
  const std::size_t shortest = record_size_ + k_shortest_stream;
  if (chunk.size() < shortest) {
    throw CorruptChunk(
        fmt::format("the chunk is too short; expected at least {} bytes for one point, found {}", shortest,
                    chunk.size()));
  }
  chunk_ = chunk;
  stream_ = ArithmeticDecoder(chunk.subspan(record_size_));
  point_ = 0;
}

void PointwiseDecoder::decode(std::span<std::byte> records) {
  assert(records.size() % record_size_ == 0);
  std::byte* record = records.data();
  std::byte* const end = record + records.size();
  if (point_ == 0 && record != end) {
    std::memcpy(record, chunk_.data(), record_size_);
    for (const PlacedItem& item : items_) item.rules->start(record + item.offset);
    if (stream_.failed()) throw_corrupt();
    record += record_size_;
    ++point_;
  }
  for (; record != end; record += record_size_, ++point_) {
    for (const PlacedItem& item : items_) item.rules->decode(stream_, record + item.offset);
    if (stream_.failed()) throw_corrupt();
  }
}

void PointwiseDecoder::throw_corrupt() const {
  const std::size_t size = chunk_.size();
  if (record_size_ + stream_.consumed() == size) {
    throw CorruptChunk(
        fmt::format("the points do not end with the chunk; expected all within {} bytes, found more", size),
        point_);
  }
  throw CorruptChunk("invalid point; expected valid arithmetic codes", point_);
}

PointwiseEncoder::PointwiseEncoder(const LazLayout& layout)
    : record_size_(layout.record_size()), items_(make_pointwise_items(layout)) {}

std::vector<std::byte> PointwiseEncoder::encode(std::span<const std::byte> records) {
  assert(!records.empty() && records.size() % record_size_ == 0);
  for (const PlacedItem& item : items_) item.rules->start(records.data() + item.offset);
  ArithmeticEncoder encoder;
  for (std::size_t at = record_size_; at < records.size(); at += record_size_)
    for (const PlacedItem& item : items_) item.rules->encode(encoder, records.data() + at + item.offset);
  const std::vector<std::byte> stream = encoder.finish();
  std::vector<std::byte> chunk(record_size_ + stream.size());
  std::copy_n(records.data(), record_size_, chunk.data());
  std::copy(stream.begin(), stream.end(), chunk.begin() + static_cast<std::ptrdiff_t>(record_size_));
  return chunk;
}

}  // namespace alidade
