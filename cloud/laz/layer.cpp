// SPDX-License-Identifier: MIT
#include "cloud/laz/layer.h"

#include <cassert>
#include <cstring>

#include "cloud/laz/field_layers.h"
#include "cloud/laz/layered_codec.h"

namespace alidade {

bool Layer::needed(std::span<const std::byte> records, std::size_t record_size) const {
  const std::byte* const first = records.data() + field_.offset;
  for (std::size_t at = record_size; at < records.size(); at += record_size)
    if (std::memcmp(first, first + at, field_.size) != 0) return true;
  return false;
}

namespace {

class Maker {
 public:
  Maker(const LazLayers& wanted, std::size_t layers) : wanted_(wanted) { layers_.reserve(layers); }

  void add(const LazItem& item) {
    switch (item.kind) {
      case LazItemKind::point14:
        add_point();
        break;
      case LazItemKind::rgb14:
        add<ColorLayer>(wanted_.color, "colour", offset_, item.version);
        break;
      case LazItemKind::rgb_nir14:
        add<ColorLayer>(wanted_.color, "colour", offset_, item.version);
        add<NearInfraredLayer>(wanted_.near_infrared, "near infrared", offset_ + k_color_size, item.version);
        break;
      case LazItemKind::wave_packet14:
        add<WavePacketLayer>(wanted_.wave_packet, "wave packet", offset_, item.version);
        break;
      case LazItemKind::byte14:
        for (std::size_t byte = 0; byte < item.size; ++byte)
          add<ExtraByteLayer>(wanted_.extra_bytes, "extra byte", offset_ + byte, item.version);
        break;
      default:
        assert(false && "count_layers() refuses other items");
    }
    offset_ += item.size;
  }

  std::vector<std::unique_ptr<Layer>> take() { return std::move(layers_); }

 private:
  void add_point() {
    add<ZLayer>(wanted_.z);
    add<ClassificationLayer>(wanted_.classification);
    add<FlagsLayer>(wanted_.flags);
    add<IntensityLayer>(wanted_.intensity);
    add<ScanAngleLayer>(wanted_.scan_angle);
    add<UserDataLayer>(wanted_.user_data);
    add<PointSourceLayer>(wanted_.point_source);
    add<GpsTimeLayer>(wanted_.gps_time);
  }

  template <class L, class... Arguments>
  void add(bool wanted, Arguments... arguments) {
    layers_.push_back(wanted ? std::make_unique<L>(arguments...) : nullptr);
  }

  const LazLayers& wanted_;
  std::size_t offset_ = 0;  // of the item in the record
  std::vector<std::unique_ptr<Layer>> layers_;
};

}  // namespace

std::vector<std::unique_ptr<Layer>> make_layers(const LazLayout& layout, const LazLayers& wanted) {
  Maker maker(wanted, count_layers(layout) - 1);
  for (const LazItem& item : layout.items) maker.add(item);
  return maker.take();
}

}  // namespace alidade
