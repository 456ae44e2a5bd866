// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "base/bytes.h"
#include "cloud/copc/copc_file.h"
#include "cloud/copc/plan_copc.h"
#include "cloud/las/write_las.h"
#include "cloud/rows.h"
#include "tests/cloud/chosen_points.h"
#include "tests/cloud/cloud_test_support.h"

namespace alidade {
namespace {

/// Rows of two clouds by position, then by GPS time, with all that LAS keeps of them.
std::vector<std::size_t> sorted_rows(const PointCloud& cloud) {
  std::vector<std::size_t> rows(cloud.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  std::ranges::sort(rows, {}, [&](std::size_t row) {
    const LatticePosition& p = cloud.positions[row];
    return std::tuple(p.x, p.y, p.z, cloud.gps_times.empty() ? 0.0 : cloud.gps_times[row],
                      cloud.intensities.empty() ? 0 : cloud.intensities[row]);
  });
  return rows;
}

void expect_same_points(const PointCloud& a, const PointCloud& b) {
  ASSERT_EQ(a.size(), b.size());
  const std::vector<std::size_t> rows_a = sorted_rows(a), rows_b = sorted_rows(b);
  for (std::size_t i = 0; i < rows_a.size(); ++i) {
    ASSERT_EQ(a.positions[rows_a[i]], b.positions[rows_b[i]]);
    for_each_column(a, b, [&](Attribute, const auto& column_a, const auto& column_b) {
      if (!column_a.empty()) {
        ASSERT_EQ(column_a[rows_a[i]], column_b[rows_b[i]]);
      }
    });
  }
}

/// The cube of a node holds its points, as they were before rounding: exactly, since they are on the lattice.
void expect_points_in_cubes(const std::filesystem::path& path) {
  const CopcFile file{InputFile(path)};
  std::uint64_t sum = 0;
  for (std::uint32_t i = 0; i < file.hierarchy().nodes.size(); ++i) {
    const CopcNode& node = file.hierarchy().nodes[i];
    sum += node.chunk.point_count;
    if (node.chunk.point_count == 0) continue;
    const ChosenNodes chosen{&file, {i}};
    const PointCloud points = read_copc_nodes({&chosen, 1});
    ASSERT_EQ(points.size(), node.chunk.point_count);
    const Bounds cube = copc_cube(file.info(), node.key);
    for (std::size_t row = 0; row < points.size(); ++row)
      ASSERT_TRUE(cube.contains(points.world(row))) << node.key.name();
  }
  EXPECT_EQ(sum, file.header().point_count);
}

/// The plan of a cloud.
CopcPlan planned(const PointCloud& cloud, std::size_t most_points = 50000) {
  LatticeExtent extent;
  for (const LatticePosition& position : cloud.positions) extent.grow(position);
  ScratchFile file(test::test_folder());
  file.append(std::as_bytes(std::span(cloud.positions)));
  const std::span<std::byte> bytes = file.map();
  return plan_copc(cloud.lattice, extent, {reinterpret_cast<LatticePosition*>(bytes.data()), cloud.size()},
                   {test::test_folder(), 1 << 20}, most_points);
}

TEST(WriteCopc, all_points_and_attributes_come_back_from_a_tree_of_their_own) {
  const std::filesystem::path folder = test::test_folder();
  PointCloud cloud = test::full_cloud(150'000, 1 << 14, 3);
  for (ReturnNumbers& returns : cloud.returns)
    returns = {.number = 1, .count = std::uint8_t(returns.count % 16)};
  cloud.scan_angles.clear();  // which LAS rounds
  write_las(folder / "cloud.copc.laz", cloud);
  expect_points_in_cubes(folder / "cloud.copc.laz");
  const CopcFile file{InputFile(folder / "cloud.copc.laz")};
  EXPECT_GE(file.hierarchy().levels(), 2);
  EXPECT_NEAR(file.info().spacing, 2.0 * file.info().half_size / 128.0, 1e-12);
  const PointCloud again = read_cloud(folder / "cloud.copc.laz");
  EXPECT_EQ(again.files.at(0).format, "COPC");
  cloud.normals.clear();  // which LAS keeps as extra bytes
  expect_same_points(cloud, again);
  // Written once more it is the same file: nothing of the old tree is left.
  write_las(folder / "again.copc.laz", again);
  EXPECT_EQ(CopcFile{InputFile(folder / "again.copc.laz")}.hierarchy().nodes.size(),
            file.hierarchy().nodes.size());
}

TEST(WriteCopc, progress_counts_each_point_once) {
  const PointCloud cloud = test::full_cloud(20'000, 1 << 14, 5);
  std::uint64_t last = 0;
  const Progress progress = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_EQ(total, 20'000u);
    EXPECT_GE(done, last);
    last = done;
    return true;
  };
  write_las(test::test_folder() / "counted.copc.laz", cloud, {.progress = progress});
  EXPECT_EQ(last, 20'000u);
}

TEST(WriteCopc, bytes_depend_neither_on_memory_nor_on_pieces) {
  const std::filesystem::path folder = test::test_folder();
  PointCloud cloud = test::full_cloud(100'000, 1 << 14, 4);
  write_las(folder / "whole.copc.laz", cloud);
  LasWriter writer(folder / "pieces.copc.laz", cloud, cloud.attributes(), {.memory = 1 << 18});
  PointCloud rest = cloud;
  rest.resize(60'000);
  writer.write(rest);
  std::vector<std::uint8_t> marks(cloud.size());
  std::fill(marks.begin() + 60'000, marks.end(), std::uint8_t{1});
  keep_rows(cloud, marks);
  writer.write(cloud);
  writer.finish();
  EXPECT_TRUE(test::read_bytes(folder / "whole.copc.laz") == test::read_bytes(folder / "pieces.copc.laz"));
}

TEST(WriteCopc, upper_levels_are_a_thinned_cloud) {
  PointCloud cloud = test::full_cloud(200'000, 1 << 12, 5);
  const CopcPlan plan = planned(cloud);
  std::size_t row = 0;
  for (const CopcPlan::Node& node : plan.nodes) {
    const Bounds cube = copc_cube(plan.info, node.key);
    const double cell = cube.size().x / 128.0;
    const bool has_children = std::ranges::any_of(plan.nodes, [&](const CopcPlan::Node& other) {
      return other.key.level > 0 && other.key.parent() == node.key;
    });
    std::map<std::array<int, 3>, int> cells;
    for (std::size_t end = row + node.point_count; row < end; ++row) {
      const glm::dvec3 at = (cloud.world(plan.order[row]) - cube.min) / cell;
      ++cells[{static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z)}];
    }
    if (has_children) {
      EXPECT_EQ(cells.size(), node.point_count) << "one point of each cell: " << node.key.name();
    } else {
      EXPECT_LE(node.point_count, 50000u);
    }
  }
  EXPECT_EQ(row, cloud.size());
}

TEST(WriteCopc, a_node_takes_the_middle_point_of_each_cell) {
  // The root begins a step before the first point, so that a cell of its grid holds the points 4 n - 1 to
  // 4 n + 2.
  PointCloud cloud;
  for (int i = 0; i < 511; ++i) cloud.positions.emplace_back(i, 0, 0);
  const CopcPlan plan = planned(cloud, 20);
  ASSERT_EQ(plan.nodes.at(0).point_count, 128u);
  for (std::uint32_t i = 0; i < 128; ++i) EXPECT_EQ(plan.order[i], 4 * i + 1);
}

TEST(WriteCopc, coincident_points_and_no_points_are_files_too) {
  const std::filesystem::path folder = test::test_folder();
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.001), .offset = glm::dvec3(1000.0)};
  cloud.positions.assign(120'000, LatticePosition(7, 8, 9));
  write_las(folder / "one_place.copc.laz", cloud);
  expect_points_in_cubes(folder / "one_place.copc.laz");
  EXPECT_EQ(read_cloud(folder / "one_place.copc.laz").size(), 120'000u);
  cloud.positions.clear();
  write_las(folder / "empty.copc.laz", cloud);
  EXPECT_EQ(read_cloud(folder / "empty.copc.laz").size(), 0u);
}

TEST(WriteCopc, large_trees_have_pages_that_lead_to_every_node_once) {
  // Along a line a node has 128 points.
  PointCloud cloud;
  for (int i = 0; i < 300'000; ++i) cloud.positions.emplace_back(i, 0, 0);
  CopcPlan plan = planned(cloud, 20);
  ASSERT_GT(plan.nodes.size(), 2000u);
  std::vector<LazChunk> chunks;
  for (const CopcPlan::Node& node : plan.nodes)
    chunks.push_back(
        {.offset = 1000 + 10 * chunks.size(), .byte_count = 10, .point_count = node.point_count});
  constexpr std::uint64_t k_begin = 5'000'000;
  plan.info.root_page = k_begin;
  const std::vector<std::uint8_t> pages = copc_hierarchy_record(plan, chunks).data;
  EXPECT_LT(plan.info.root_page_size, pages.size());
  struct Page {
    std::uint64_t offset, size;
    int level;
  };
  std::map<CopcKey, std::uint64_t> offsets;
  std::vector<Page> open = {{k_begin, plan.info.root_page_size, 0}};
  std::uint64_t bytes = 0;
  while (!open.empty()) {
    const auto [offset, size, level] = open.back();
    open.pop_back();
    bytes += size;
    for (std::uint64_t at = offset - k_begin; at < offset - k_begin + size; at += 32) {
      const auto* const entry = reinterpret_cast<const std::byte*>(pages.data() + at);
      const CopcKey key{load<std::int32_t>(entry), load<std::int32_t>(entry + 4),
                        load<std::int32_t>(entry + 8), load<std::int32_t>(entry + 12)};
      const auto target = load<std::uint64_t>(entry + 16);
      const auto length = static_cast<std::uint64_t>(load<std::int32_t>(entry + 24));
      if (load<std::int32_t>(entry + 28) < 0) {
        EXPECT_EQ(key.level, level + 4) << "of the page of " << key.name();
        open.push_back({target, length, key.level});
      } else {
        EXPECT_TRUE(key.level >= level && key.level < level + 4) << key.name();
        EXPECT_TRUE(offsets.emplace(key, target).second) << key.name();
      }
    }
  }
  EXPECT_EQ(bytes, pages.size());
  ASSERT_EQ(offsets.size(), plan.nodes.size());
  for (std::size_t i = 0; i < plan.nodes.size(); ++i)
    EXPECT_EQ(offsets.at(plan.nodes[i].key), chunks[i].offset);
}

}  // namespace
}  // namespace alidade
