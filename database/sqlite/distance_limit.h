// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "database/point_filter.h"

namespace alidade {

/// A limit on dist_ray or dist_plane as one SQL value: what ray_limit() and plane_limit() answer and
/// in_chunk() takes.
struct DistanceLimit {
  enum class Kind : unsigned char { none, ray, plane };
  Kind kind = Kind::none;
  /// Place and direction or normal, as they were given; least and largest distance, inclusive.
  std::array<double, 8> numbers{};
};

std::vector<std::byte> encode(const DistanceLimit& limit);

/// Errors: the bytes are not what encode() gave.
DistanceLimit decode_distance_limit(std::span<const std::byte> bytes);

/// Adds the limit to what a filter demands; none adds nothing. Errors: as make_ray() and make_plane().
void add(const DistanceLimit& limit, PointFilter& filter);

}  // namespace alidade
