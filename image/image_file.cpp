// SPDX-License-Identifier: MIT
#include "image/image_exr.h"

#include <Imath/half.h>

#include <algorithm>
#include <cassert>
#include <cstring>

namespace alidade {
namespace {

constexpr float k_largest_half = 65504.0f;

float value_of(const Film& film, std::size_t pixel, const Channel& channel, const glm::dvec3& offset) {
  const int i = channel.component;
  switch (channel.layer) {
    case Layer::color:
      return i == 3 ? film.alpha[pixel] : film.color[pixel][i];
    case Layer::depth:
      return film.depth[pixel];
    case Layer::distance:
      return film.distance[pixel];
    case Layer::normal:
      return film.normal[pixel][i];
    // A pixel without a surface stays 0 0 0; infinite depth tells it from a real place.
    case Layer::position:
      return film.id[pixel] == 0 ? 0.0f : static_cast<float>(film.position[pixel][i] - offset[i]);
    case Layer::albedo:
      return film.albedo[pixel][i];
    case Layer::variance:
      return film.variance[pixel][i];
    case Layer::id:
      break;
  }
  return 0.0f;
}

template <typename Value>
std::size_t put(std::span<std::byte> bytes, std::size_t place, const Value& value) {
  std::memcpy(bytes.data() + place, &value, sizeof value);
  return place + sizeof value;
}

}  // namespace

std::vector<Channel> exr_channels(const OutputSettings& output) {
  const ChannelType color = output.half ? ChannelType::half_float : ChannelType::single_float;
  const std::vector<Channel> all{
      {"R", color, Layer::color, 0},
      {"G", color, Layer::color, 1},
      {"B", color, Layer::color, 2},
      {"A", color, Layer::color, 3},
      {"Z", ChannelType::single_float, Layer::depth, 0},
      {"distance.T", ChannelType::single_float, Layer::distance, 0},
      {"N.X", color, Layer::normal, 0},
      {"N.Y", color, Layer::normal, 1},
      {"N.Z", color, Layer::normal, 2},
      {"P.X", ChannelType::single_float, Layer::position, 0},
      {"P.Y", ChannelType::single_float, Layer::position, 1},
      {"P.Z", ChannelType::single_float, Layer::position, 2},
      {"albedo.R", color, Layer::albedo, 0},
      {"albedo.G", color, Layer::albedo, 1},
      {"albedo.B", color, Layer::albedo, 2},
      {"id", ChannelType::unsigned_integer, Layer::id, 0},
      {"variance.R", ChannelType::single_float, Layer::variance, 0},
      {"variance.G", ChannelType::single_float, Layer::variance, 1},
      {"variance.B", ChannelType::single_float, Layer::variance, 2},
  };
  std::vector<Channel> channels;
  std::ranges::copy_if(all, std::back_inserter(channels), [&](const Channel& channel) {
    return std::ranges::find(output.layers, channel.layer) != output.layers.end();
  });
  return channels;
}

std::size_t pixel_bytes(std::span<const Channel> channels) {
  std::size_t bytes = 0;
  for (const Channel& channel : channels) bytes += channel.type == ChannelType::half_float ? 2 : 4;
  return bytes;
}

void pack_row(const Film& film, int y, std::span<const Channel> channels, const glm::dvec3& offset,
              std::span<std::byte> bytes) {
  assert(bytes.size() == pixel_bytes(channels) * static_cast<std::size_t>(film.width));
  std::size_t place = 0;
  for (int x = 0; x < film.width; ++x) {
    const std::size_t pixel = film.index(x, y);
    for (const Channel& channel : channels) {
      if (channel.type == ChannelType::unsigned_integer) {
        place = put(bytes, place, film.id[pixel]);
        continue;
      }
      const float value = value_of(film, pixel, channel, offset);
      if (channel.type == ChannelType::single_float) {
        place = put(bytes, place, value);
      } else {
        // Brighter than a half can say (a view into the sun): the brightest, since infinity spoils every
        // later filter.
        place = put(bytes, place, Imath::half(std::clamp(value, -k_largest_half, k_largest_half)));
      }
    }
  }
}

}  // namespace alidade
