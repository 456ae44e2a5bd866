// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "octree/build.h"
#include "octree/index_file/save_index.h"
#include "tests/octree/index_file/index_test_support.h"
#include "tests/support/point_families.h"

// Index files read as docs/index_file.md describes them, by none of the library's code that reads them.

namespace alidade::test {

using Bytes = std::vector<std::byte>;

template <class T>
T at(const Bytes& file, std::uint64_t offset) {
  T value;
  EXPECT_LE(offset + sizeof(T), file.size());
  std::memcpy(&value, file.data() + offset, sizeof value);
  return value;
}

struct Section {
  std::uint32_t element;
  std::uint64_t offset, bytes, checksum;
};

inline std::map<std::uint32_t, Section> sections_of(const Bytes& file) {
  std::map<std::uint32_t, Section> sections;
  for (std::uint32_t i = 0; i < at<std::uint32_t>(file, 20); ++i) {
    const std::uint64_t row = 256 + 32 * std::uint64_t{i};
    sections[at<std::uint32_t>(file, row)] = {
        at<std::uint32_t>(file, row + 4), at<std::uint64_t>(file, row + 8), at<std::uint64_t>(file, row + 16),
        at<std::uint64_t>(file, row + 24)};
  }
  return sections;
}

inline Bytes saved(const Octree& octree, const PointCloud& cloud) {
  const auto path = test_folder() / "site.alidade";
  save_index(path, octree, cloud);
  return read_bytes(path);
}

/// The families, with all attributes, in each organisation.
template <class Check>
void for_each_file(const Check& check) {
  Random random;
  for (PointFamily& family : point_families()) {
    fill_everything(family.cloud, random);
    for (const Organisation organisation :
         {Organisation::adaptive, Organisation::fixed, Organisation::layered}) {
      SCOPED_TRACE(family.name + " " + std::to_string(static_cast<int>(organisation)));
      BuildOptions options;
      options.organisation = organisation;
      const Octree octree = build(family.cloud, options);
      check(saved(octree, family.cloud), family.cloud, octree);
    }
  }
}

}  // namespace alidade::test
