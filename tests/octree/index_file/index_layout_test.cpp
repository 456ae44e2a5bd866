// SPDX-License-Identifier: MIT
// Header, sections, nodes and columns of an index file, as docs/index_file.md describes them.
#include <gtest/gtest.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>

#include "tests/octree/index_file/index_layout.h"

namespace alidade {
namespace {

using test::at;
using test::Bytes;
using test::for_each_file;
using test::saved;
using test::Section;
using test::sections_of;

TEST(IndexLayout, header_is_as_documented) {
  for_each_file([](const Bytes& file, const PointCloud& cloud, const Octree& octree) {
    EXPECT_EQ(std::memcmp(file.data(), "ALIDADE", 8), 0);
    EXPECT_EQ(at<std::uint32_t>(file, 8), 0x01020304u);
    EXPECT_EQ(at<std::uint32_t>(file, 12), 2u);
    EXPECT_EQ(at<std::uint32_t>(file, 16), 4096u);
    EXPECT_EQ(at<std::uint64_t>(file, 24), file.size());
    Bytes header(file.begin(), file.begin() + 4096);
    std::fill_n(header.begin() + 32, 8, std::byte{0});
    EXPECT_EQ(at<std::uint64_t>(file, 32), XXH3_64bits(header.data(), header.size()));
    EXPECT_EQ(at<std::uint64_t>(file, 40), cloud.size());
    EXPECT_EQ(at<std::uint64_t>(file, 48), octree.view().node_count);
    EXPECT_EQ(at<std::uint32_t>(file, 56), static_cast<std::uint32_t>(octree.view().root_level));
    EXPECT_EQ(at<std::uint32_t>(file, 60), static_cast<std::uint32_t>(octree.view().level_count));
    EXPECT_EQ(at<std::uint32_t>(file, 64), static_cast<std::uint32_t>(octree.view().organisation));
    EXPECT_EQ(at<std::uint32_t>(file, 68), 1u);
    EXPECT_EQ(at<glm::dvec3>(file, 72), cloud.lattice.scale);
    EXPECT_EQ(at<glm::dvec3>(file, 96), cloud.lattice.offset);
    EXPECT_EQ(at<std::uint32_t>(file, 132), cloud.size() - octree.view().exact_count());
    const Bounds bounds = cloud.bounds();
    EXPECT_EQ(at<glm::dvec3>(file, 136), cloud.size() ? bounds.min : glm::dvec3(0));
    EXPECT_EQ(at<glm::dvec3>(file, 160), cloud.size() ? bounds.max : glm::dvec3(0));
    EXPECT_EQ((at<std::array<std::uint8_t, 16>>(file, 184)), cloud.project_id);
    EXPECT_EQ(at<std::uint16_t>(file, 200), 513);
    const std::uint64_t table_end = 256 + 32 * std::uint64_t{at<std::uint32_t>(file, 20)};
    for (std::uint64_t offset = 202; offset < 4096; ++offset) {
      if (offset < 256 || offset >= table_end) {
        ASSERT_EQ(file[offset], std::byte{0}) << offset;
      }
    }
  });
}

TEST(IndexLayout, sections_are_at_their_offsets_with_their_checksums) {
  for_each_file([](const Bytes& file, const PointCloud& cloud, const Octree& octree) {
    const auto sections = sections_of(file);
    const std::uint64_t points = cloud.size();
    std::map<std::uint32_t, std::pair<std::uint32_t, std::uint64_t>> expected = {
        {1, {128, octree.view().node_count}}, {2, {2, 3 * points + 32}}};
    if (points > 0) {
      const std::uint32_t widths[] = {6, 2, 2, 1, 2, 1, 4, 1, 2, 8, 12};
      for (std::uint32_t column = 0; column < 11; ++column) expected[16 + column] = {widths[column], points};
      expected[3] = {4, points};
    }
    if (octree.view().exact_count() > 0) expected[4] = {12, octree.view().exact_count()};
    expected[27] = {1, points * (2 + 3 + 8 + 2)};
    for (const auto& [kind, element] : expected) {
      ASSERT_TRUE(sections.contains(kind)) << kind;
      EXPECT_EQ(sections.at(kind).element, element.first) << kind;
      EXPECT_EQ(sections.at(kind).bytes, element.first * element.second) << kind;
    }
    std::uint64_t end = 4096, checksum = sections.at(34).offset;
    for (const auto& [kind, section] : sections) {
      EXPECT_EQ(section.offset, (end + 4095) / 4096 * 4096) << kind;
      for (; end < section.offset; ++end) ASSERT_EQ(file[end], std::byte{0}) << end;
      end = section.offset + section.bytes;
      if (kind == 34) {
        EXPECT_EQ(XXH3_64bits(file.data() + section.offset, section.bytes), section.checksum);
        break;
      }
      const std::uint64_t run = checksum;
      for (std::uint64_t block = section.offset; block < end; block += 1048576, checksum += 8) {
        EXPECT_EQ(at<std::uint64_t>(file, checksum),
                  XXH3_64bits(file.data() + block, std::min<std::uint64_t>(1048576, end - block)));
      }
      EXPECT_EQ(XXH3_64bits(file.data() + run, checksum - run), section.checksum) << kind;
    }
    EXPECT_EQ(end, file.size());
    EXPECT_EQ(checksum, sections.at(34).offset + sections.at(34).bytes);
  });
}

TEST(IndexLayout, sections_longer_than_a_block_have_a_checksum_for_each) {
  test::Random random;
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 400000; ++i) positions.push_back(random.in_cube());
  const PointCloud cloud = test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)});
  const Bytes file = saved(build(cloud), cloud);
  const auto sections = sections_of(file);
  ASSERT_GT(sections.at(3).bytes, 1048576u);
  std::uint64_t blocks = 0;
  for (const auto& [kind, section] : sections) {
    if (kind == 34) break;
    if (kind == 3) {
      EXPECT_EQ(at<std::uint64_t>(file, sections.at(34).offset + 8 * (blocks + 1)),
                XXH3_64bits(file.data() + section.offset + 1048576, section.bytes - 1048576));
    }
    blocks += (section.bytes + 1048575) / 1048576;
  }
  EXPECT_EQ(sections.at(34).bytes, 8 * blocks);
}

/// Goes through the nodes by the rules of the page and collects the lattice position of every storage index.
class NodeReader {
 public:
  explicit NodeReader(const Bytes& file) : file_(file), sections_(sections_of(file)) {}

  std::map<std::uint32_t, glm::i64vec3> positions() {
    if (at<std::uint64_t>(file_, 48) > 0)
      visit(0, static_cast<int>(at<std::uint32_t>(file_, 56)), glm::i64vec3(0));
    return std::move(positions_);
  }

 private:
  void visit(std::uint32_t number, int level, const glm::i64vec3& corner) {
    const std::uint64_t node = sections_.at(1).offset + 128 * std::uint64_t{number};
    std::uint32_t child = at<std::uint32_t>(file_, node + 112), first = at<std::uint32_t>(file_, node + 116);
    for (int slot = 0; slot < 16; ++slot) {
      const int kind = at<std::uint8_t>(file_, node + 96 + slot);
      if (kind >= 128) {
        const int d = kind - 128;
        glm::i64vec3 inner = corner;
        for (int axis = 0; axis < 3; ++axis) {
          const std::int64_t low = at<std::uint8_t>(file_, node + 16 * axis + slot);
          inner[axis] += (low & ~((256 >> d) - 1)) << (level - 8);
        }
        visit(child++, level - d, inner);
      } else if (kind > 0) {
        read_leaf(node, slot, level, corner, first, static_cast<std::uint32_t>(kind));
        first += static_cast<std::uint32_t>(kind);
      }
    }
  }

  void read_leaf(std::uint64_t node, int slot, int level, const glm::i64vec3& corner, std::uint32_t first,
                 std::uint32_t count) {
    const glm::i64vec3 base(at<glm::ivec3>(file_, 120));
    const std::uint32_t exact = at<std::uint32_t>(file_, 132);
    for (std::uint32_t i = 0; i < count; ++i) {
      glm::i64vec3 steps;
      for (std::uint32_t axis = 0; axis < 3; ++axis)
        steps[axis] =
            at<std::uint16_t>(file_, sections_.at(2).offset + 2 * (3ull * first + axis * count + i));
      if (level > 16) {
        ASSERT_GE(first, exact);
        const glm::i64vec3 position(
            at<glm::ivec3>(file_, sections_.at(4).offset + 12 * (std::uint64_t{first} + i - exact)));
        for (int axis = 0; axis < 3; ++axis)
          EXPECT_EQ(steps[axis], (position[axis] - base[axis] - corner[axis]) >> (level - 16));
        steps = position - base - corner;
      }
      for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t grid = steps[axis] >> (level - 8);
        EXPECT_GE(grid, at<std::uint8_t>(file_, node + 16 * axis + slot));
        EXPECT_LE(grid, at<std::uint8_t>(file_, node + 48 + 16 * axis + slot));
      }
      EXPECT_TRUE(positions_.emplace(first + i, base + corner + steps).second) << "twice: " << first + i;
    }
  }

  const Bytes& file_;
  std::map<std::uint32_t, Section> sections_;
  std::map<std::uint32_t, glm::i64vec3> positions_;
};

TEST(IndexLayout, nodes_coordinates_and_ids_are_the_positions_of_the_cloud) {
  for_each_file([](const Bytes& file, const PointCloud& cloud, const Octree&) {
    const auto positions = NodeReader(file).positions();
    ASSERT_EQ(positions.size(), cloud.size());
    if (cloud.size() == 0) return;
    const std::uint64_t ids = sections_of(file).at(3).offset;
    for (const auto& [index, position] : positions) {
      const auto id = at<std::uint32_t>(file, ids + 4 * std::uint64_t{index});
      ASSERT_LT(id, cloud.size());
      ASSERT_EQ(position, glm::i64vec3(cloud.positions[id]));
    }
  });
}

TEST(IndexLayout, columns_are_the_attributes_by_row) {
  for_each_file([](const Bytes& file, const PointCloud& cloud, const Octree&) {
    if (cloud.size() == 0) return;
    const auto sections = sections_of(file);
    std::uint32_t kind = 16;
    for_each_column(cloud, cloud, [&](Attribute, const auto& column, const auto&) {
      const Section& section = sections.at(kind++);
      ASSERT_EQ(section.bytes, column.size() * sizeof column[0]);
      EXPECT_EQ(std::memcmp(file.data() + section.offset, column.data(), section.bytes), 0) << kind - 1;
    });
    std::uint64_t offset = sections.at(27).offset;
    for (const ExtraDimension& dimension : cloud.extra_dimensions) {
      EXPECT_EQ(std::memcmp(file.data() + offset, dimension.values.data(), dimension.values.size()), 0);
      offset += dimension.values.size();
    }
  });
}

}  // namespace
}  // namespace alidade
