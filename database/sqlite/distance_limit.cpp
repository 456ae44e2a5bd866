// SPDX-License-Identifier: MIT
#include "database/sqlite/distance_limit.h"

#include <cstring>

#include "base/error.h"

namespace alidade {
namespace {

constexpr std::size_t k_head = 4;
constexpr std::byte k_mark[k_head - 1] = {std::byte{'a'}, std::byte{'l'}, std::byte{'d'}};

}  // namespace

std::vector<std::byte> encode(const DistanceLimit& limit) {
  std::vector<std::byte> bytes(k_head + sizeof limit.numbers);
  std::memcpy(bytes.data(), k_mark, sizeof k_mark);
  bytes[k_head - 1] = static_cast<std::byte>(limit.kind);
  std::memcpy(bytes.data() + k_head, limit.numbers.data(), sizeof limit.numbers);
  return bytes;
}

DistanceLimit decode_distance_limit(std::span<const std::byte> bytes) {
  DistanceLimit limit;
  const bool is_one = bytes.size() == k_head + sizeof limit.numbers &&
                      std::memcmp(bytes.data(), k_mark, sizeof k_mark) == 0 &&
                      bytes[k_head - 1] <= static_cast<std::byte>(DistanceLimit::Kind::plane);
  if (!is_one)
    throw Error(
        {.problem = "in_chunk: argument 2 is no limit", .expected = "ray_limit(...) or plane_limit(...)"});
  limit.kind = static_cast<DistanceLimit::Kind>(bytes[k_head - 1]);
  std::memcpy(limit.numbers.data(), bytes.data() + k_head, sizeof limit.numbers);
  return limit;
}

void add(const DistanceLimit& limit, PointFilter& filter) {
  const auto& n = limit.numbers;
  const glm::dvec3 place(n[0], n[1], n[2]), direction(n[3], n[4], n[5]);
  const Interval distance{n[6], n[7]};
  if (limit.kind == DistanceLimit::Kind::ray)
    filter.lines.push_back({.ray = make_ray(place, direction), .distance = distance});
  else if (limit.kind == DistanceLimit::Kind::plane)
    filter.planes.push_back({.plane = make_plane(place, direction), .distance = distance});
}

}  // namespace alidade
