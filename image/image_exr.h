// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "image/image_file.h"

namespace alidade {

/// How a channel's values are stored.
enum class ChannelType { half_float, single_float, unsigned_integer };

/// A channel of an EXR file, under the name other programs look for.
struct Channel {
  std::string name;
  ChannelType type;
  Layer layer;
  int component;  ///< 0, 1, 2 of a vector or colour; 3 = alpha
};

/// The channels of the layers asked for, in the order of the enumeration Layer.
std::vector<Channel> exr_channels(const OutputSettings& output);

/// Size of a pixel of these channels in bytes, each value in its own type, without gaps.
std::size_t pixel_bytes(std::span<const Channel> channels);

/// Row `y` of the film as such pixels. `offset`: see position_offset(). `bytes` holds width * pixel_bytes.
void pack_row(const Film& film, int y, std::span<const Channel> channels, const glm::dvec3& offset,
              std::span<std::byte> bytes);

}  // namespace alidade
