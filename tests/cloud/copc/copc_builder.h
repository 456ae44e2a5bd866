// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "cloud/copc/copc_file.h"
#include "cloud/las/las_header.h"
#include "cloud/las/las_records.h"
#include "cloud/laz/chunk_table.h"
#include "cloud/laz/laz_layout.h"
#include "tests/cloud/laz/laz_builder.h"

// COPC files of random points for tests: every point goes down the octree until a node has room for it.

namespace alidade::test {

struct CopcSample {
  std::vector<std::byte> bytes;
  std::size_t info_offset = 429;  ///< data of the record of COPC
  std::size_t pages_offset = 0;   ///< first byte of the hierarchy
  std::vector<CopcKey> keys;      ///< of the entries
  std::vector<std::uint32_t> counts;
};

inline constexpr double k_copc_half_size = 64.0;

/// `count` points of format 7 in a cube of side 128 around the lattice's offset, of at most `node_points` to
/// a node. `seed` also determines the order of the nodes in the file.
inline CopcSample build_copc(std::size_t count, std::size_t node_points = 40, std::uint64_t seed = 1) {
  LasFile file;
  file.version_minor = 4;
  file.point_format = 7;
  file.scale = {0.001, 0.001, 0.001};
  std::mt19937_64 engine(seed);
  std::map<CopcKey, std::vector<LasPoint>> nodes;
  for (LasPoint& point : random_las_points(7, count, 0, seed)) {
    // Two sheets and some dust, so that parts of the cube are empty.
    const auto coordinate = [&] { return static_cast<std::int32_t>(engine() % 128000) - 64000; };
    point.x = coordinate();
    point.y = coordinate();
    point.z = engine() % 10 == 0 ? coordinate() : static_cast<std::int32_t>(engine() % 3000) - 20000;
    CopcKey key;
    while (nodes[key].size() >= node_points) {
      const int level = key.level + 1;
      const double side = 2 * k_copc_half_size / std::ldexp(1.0, level);
      const auto cell = [&](std::int32_t steps) {
        return static_cast<std::int32_t>(std::floor((steps * 0.001 + k_copc_half_size) / side));
      };
      key = {level, cell(point.x), cell(point.y), cell(point.z)};
    }
    nodes[key].push_back(point);
  }

  CopcSample sample;
  for (const auto& [key, points] : nodes) sample.keys.push_back(key);
  std::shuffle(sample.keys.begin(), sample.keys.end(), engine);
  LazOptions options{.chunk_sizes = {}, .variable = true};
  for (const CopcKey& key : sample.keys) {
    const std::vector<LasPoint>& points = nodes[key];
    file.points.insert(file.points.end(), points.begin(), points.end());
    options.chunk_sizes.push_back(static_cast<std::uint32_t>(points.size()));
    sample.counts.push_back(static_cast<std::uint32_t>(points.size()));
  }
  file.records.push_back({"copc", 1, "", std::vector<std::uint8_t>(160)});
  file.extended_records.push_back({"copc", 1000, "", std::vector<std::uint8_t>(32 * sample.keys.size())});
  sample.bytes = build_laz(file, options);

  const auto put = [&sample](std::size_t offset, auto value) {
    std::memcpy(sample.bytes.data() + offset, &value, sizeof value);
  };
  sample.pages_offset = sample.bytes.size() - 32 * sample.keys.size();
  for (std::size_t axis = 0; axis < 3; ++axis) put(sample.info_offset + 8 * axis, file.offset[axis]);
  put(sample.info_offset + 24, k_copc_half_size);
  put(sample.info_offset + 32, 1.5);
  put(sample.info_offset + 40, std::uint64_t{sample.pages_offset});
  put(sample.info_offset + 48, std::uint64_t{32 * sample.keys.size()});
  InputFile input(sample.bytes, "memory");
  std::vector<std::string> warnings;
  const LasHeader header = read_las_header(input, warnings);
  std::string missing;
  const std::vector<LazChunk> chunks =
      *read_chunk_table(input, header, standard_laz_layout(7, 36, 0), missing);
  for (std::size_t i = 0; i < sample.keys.size(); ++i) {
    // Entries in the order of keys from the last, which is neither that of the file nor that of the tree.
    const std::size_t offset = sample.pages_offset + 32 * (sample.keys.size() - 1 - i);
    const CopcKey& key = sample.keys[i];
    put(offset, std::int32_t{key.level});
    put(offset + 4, key.x);
    put(offset + 8, key.y);
    put(offset + 12, key.z);
    put(offset + 16, chunks[i].offset);
    put(offset + 24, static_cast<std::int32_t>(chunks[i].byte_count));
    put(offset + 28, static_cast<std::int32_t>(chunks[i].point_count));
  }
  return sample;
}

}  // namespace alidade::test
