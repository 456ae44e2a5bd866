// SPDX-License-Identifier: MIT
#include "cloud/laz/pointwise_item.h"

#include <fmt/format.h>

#include <array>
#include <cstring>

#include "cloud/laz/color_models.h"
#include "cloud/laz/corrupt_chunk.h"
#include "cloud/laz/extra_bytes.h"
#include "cloud/laz/gps_time_version1.h"
#include "cloud/laz/point10_version1.h"
#include "cloud/laz/pointwise_rules.h"
#include "cloud/laz/shared_models.h"
#include "cloud/laz/wave_packet_models.h"

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

/// An item whose rules stand once for both directions.
template <class Rules>
class ItemOfRules final : public PointwiseItem {
 public:
  template <class... Arguments>
  explicit ItemOfRules(Arguments... arguments) : rules_(arguments...) {}

  void start(const std::byte* first) override { rules_.start(first); }

  void decode(ArithmeticDecoder& stream, std::byte* item) override {
    // A copy that nobody else knows can stay in registers.
    ArithmeticDecoder copy = stream;
    LayerDecoding coder(copy);
    rules_.code(coder, item);
    stream = copy;
  }

  void encode(ArithmeticEncoder& stream, const std::byte* item) override {
    LayerEncoding coder(stream);
    rules_.code(coder, item);
  }

 private:
  Rules rules_;
};

/// An item whose models replace the previous value by the next.
template <class Models, std::size_t size>
class ItemOfModels final : public PointwiseItem {
 public:
  void start(const std::byte* first) override {
    models_.reset();
    std::memcpy(last_.data(), first, size);
  }

  void decode(ArithmeticDecoder& stream, std::byte* item) override {
    models_.decode(stream, last_.data());
    std::memcpy(item, last_.data(), size);
  }

  void encode(ArithmeticEncoder& stream, const std::byte* item) override {
    models_.encode(stream, last_.data(), item);
    std::memcpy(last_.data(), item, size);
  }

 private:
  Models models_;
  std::array<std::byte, size> last_{};
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
        return std::make_unique<ItemOfModels<ColorModels, 6>>();
      case LazItemKind::wave_packet13:
        if (item.size != WavePacketModels::k_size || !old) break;
        return std::make_unique<ItemOfModels<WavePacketModels, WavePacketModels::k_size>>();
      case LazItemKind::byte:
        if (item.size == 0) break;
        if (old) return std::make_unique<ItemOfRules<BytesVersion1>>(item.size, BytesVersion1::Written::all);
        return std::make_unique<ItemOfRules<ExtraBytesVersion2>>(item.size);
      default:
        break;
    }
  }
  throw CorruptChunk(
      fmt::format("unknown part of point records; expected kinds 0 and 6 to 9 in versions 1 and 2, found "
                  "kind {} of {} bytes in version {}",
                  static_cast<unsigned>(item.kind), item.size, item.version));
}

}  // namespace

std::vector<PlacedItem> make_pointwise_items(const LazLayout& layout) {
  std::vector<PlacedItem> items;
  std::size_t place = 0;
  for (const LazItem& item : layout.items) {
    items.push_back({.place = place, .rules = make_pointwise_item(item)});
    place += item.size;
  }
  return items;
}

}  // namespace alidade
