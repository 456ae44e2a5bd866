// SPDX-License-Identifier: MIT
// First looks at COPC files: which nodes are chosen, and what is read of them.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <bit>
#include <set>

#include "camera/camera.h"
#include "cloud/cloud_reader.h"
#include "cloud/read_cloud.h"
#include "renderer/cloud_in_view.h"
#include "tests/cloud/copc/copc_builder.h"

namespace alidade {

using namespace image;
using namespace camera;
using namespace renderer;

namespace {

constexpr glm::dvec3 k_centre(690000, 5325000, 500);

/// Opened files in memory.
struct Files {
  std::vector<test::CopcSample> samples;  ///< whose bytes the files read
  std::vector<std::unique_ptr<CopcFile>> opened;

  const CopcFile& operator[](std::size_t number) const { return *opened[number]; }
  operator std::span<const std::unique_ptr<CopcFile>>() const { return opened; }
};

Files files_of(std::vector<test::CopcSample> samples) {
  Files files{std::move(samples), {}};
  for (const test::CopcSample& sample : files.samples)
    files.opened.push_back(
        std::make_unique<CopcFile>(InputFile(sample.bytes, "sample " + std::to_string(files.opened.size()))));
  return files;
}

PointCloud whole_cloud(const std::vector<test::CopcSample>& samples) {
  CloudInputs clouds;
  for (const test::CopcSample& sample : samples)
    clouds.inputs.push_back(cloud_in_memory(sample.bytes, "all"));
  return read_cloud(clouds);
}

/// Looks to the east from the west of the cube, whose half side is 64 m, narrow enough to miss most of it.
Camera view_from_west() {
  const glm::dvec3 eye = k_centre + glm::dvec3(-100, -50, 0);
  return pinhole_from_fov(200, 100, 10, look_at(eye, eye + glm::dvec3(1, 0, 0)));
}

TEST(NodesInView, all_levels_are_taken_from_the_top_without_a_camera) {
  const Files files = files_of({test::build_copc(3000)});
  const CopcFile& file = files[0];
  for (const std::uint64_t most : {0u, 100u, 500u, 1000u, 2999u, 3000u}) {
    const auto parts = nodes_in_view(files, nullptr, most);
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_EQ(parts[0].file, &file);
    EXPECT_EQ(parts[0].nodes.front(), 0u);
    EXPECT_LE(point_count(parts), std::max(most, file.hierarchy().nodes[0].chunk.point_count));
    // Whatever was left out would have been too many.
    EXPECT_GT(point_count(parts) + 40, std::min<std::uint64_t>(most, 2960)) << most;
    // What just fits is taken.
    if (most == 3000) EXPECT_EQ(point_count(parts), 3000u);
  }
}

TEST(NodesInView, nodes_that_a_camera_does_not_see_are_left_out) {
  const Files files = files_of({test::build_copc(3000)});
  const Camera camera = view_from_west();
  const auto parts = nodes_in_view(files, &camera, 3000);
  const std::set<std::uint32_t> chosen(parts.at(0).nodes.begin(), parts.at(0).nodes.end());
  const PointCloud all = whole_cloud({test::build_copc(3000)});
  std::size_t seen = 0;
  for (std::uint32_t number = 0; number < files[0].hierarchy().nodes.size(); ++number) {
    const CopcNode& node = files[0].hierarchy().nodes[number];
    bool is_seen = false;
    for (std::uint64_t row = node.first_row; row < node.first_row + node.chunk.point_count; ++row) {
      const auto film =
          project_to_film(camera, to_world(all.lattice, all.positions[static_cast<std::size_t>(row)]));
      is_seen |= film && film->x >= 0 && film->x <= 200 && film->y >= 0 && film->y <= 100;
    }
    EXPECT_TRUE(!is_seen || chosen.contains(number)) << node.key.name();
    seen += is_seen ? 1 : 0;
  }
  EXPECT_GT(seen, 5u);
  EXPECT_LT(chosen.size(), files[0].hierarchy().nodes.size() / 2);
}

TEST(NodesInView, near_nodes_come_before_far_ones) {
  const Files files = files_of({test::build_copc(3000)});
  const glm::dvec3 eye = k_centre + glm::dvec3(-70, 0, 0);
  const Camera camera = pinhole_from_fov(200, 100, 90, look_at(eye, k_centre));
  const auto deepest = [&](double east) {
    int level = 0;
    const auto parts = nodes_in_view(files, &camera, 1500);
    for (const std::uint32_t number : parts.at(0).nodes) {
      const CopcNode& node = files[0].hierarchy().nodes[number];
      const Bounds cube = files[0].bounds(node);
      if (cube.min.x <= k_centre.x + east && cube.max.x >= k_centre.x + east)
        level = std::max(level, node.key.level);
    }
    return level;
  };
  EXPECT_GT(deepest(-60), deepest(60));
}

TEST(NodesInView, the_roots_of_all_files_in_view_are_there) {
  const Files files = files_of({test::build_copc(300, 40, 1), test::build_copc(3000, 40, 2)});
  const auto parts = nodes_in_view(files, nullptr, 10);
  ASSERT_EQ(parts.size(), 2u);
  for (const ChosenNodes& part : parts) EXPECT_EQ(part.nodes, std::vector<std::uint32_t>{0});
  const glm::dvec3 eye = k_centre + glm::dvec3(500, 0, 0);
  const Camera away = pinhole_from_fov(200, 100, 40, look_at(eye, eye + glm::dvec3(1, 0, 0)));
  EXPECT_TRUE(nodes_in_view(files, &away, 10).empty());
}

TEST(ReadCopcNodes, gives_the_rows_of_the_whole_cloud) {
  const std::vector<test::CopcSample> samples = {test::build_copc(3000, 40, 1), test::build_copc(500, 40, 2)};
  const Files files = files_of(samples);
  const PointCloud all = whole_cloud(samples);
  const auto parts = nodes_in_view(files, nullptr, 900);
  ASSERT_EQ(parts.size(), 2u);
  const PointCloud some = read_copc_nodes(parts);
  std::size_t row = 0;
  for (const ChosenNodes& part : parts) {
    const std::size_t first = part.file == &files[0] ? 0 : 3000;
    for (const std::uint32_t number : part.nodes) {
      const CopcNode& node = part.file->hierarchy().nodes[number];
      for (std::uint64_t i = 0; i < node.chunk.point_count; ++i, ++row) {
        const std::size_t whole = first + static_cast<std::size_t>(node.first_row + i);
        ASSERT_EQ(some.positions[row], all.positions[whole]);
        ASSERT_EQ(some.colors[row], all.colors[whole]);
        ASSERT_EQ(std::bit_cast<std::uint64_t>(some.gps_times[row]),
                  std::bit_cast<std::uint64_t>(all.gps_times[whole]));
        ASSERT_EQ(some.classifications[row], all.classifications[whole]);
      }
    }
  }
  EXPECT_EQ(row, some.size());
  EXPECT_LT(row, 1000u);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(read_copc_nodes(parts).positions, some.positions);
}

TEST(ReadCopcNodes, keeps_only_what_is_wanted_and_can_be_stopped) {
  const Files files = files_of({test::build_copc(3000)});
  const auto parts = nodes_in_view(files, nullptr, 3000);
  const PointCloud bare = read_copc_nodes(parts, {.attributes = {}});
  EXPECT_EQ(bare.size(), 3000u);
  EXPECT_TRUE(bare.colors.empty());
  EXPECT_THROW(read_copc_nodes(parts, {.progress = [](std::uint64_t, std::uint64_t) { return false; }}),
               Cancelled);
}

TEST(ReadCopcNodes, a_damaged_chunk_is_an_error_that_names_its_node) {
  test::CopcSample sample = test::build_copc(3000);
  const Files whole = files_of({sample});
  const LazChunk& chunk = whole[0].hierarchy().nodes[1].chunk;
  // Sizes of layers, behind the first point and the count.
  for (std::size_t i = 0; i < 16; ++i)
    sample.bytes[static_cast<std::size_t>(chunk.offset) + 40 + i] = std::byte{0xff};
  const Files files = files_of({sample});
  const auto parts = nodes_in_view(files, nullptr, 3000);
  try {
    read_copc_nodes(parts);
    ADD_FAILURE() << "it was read";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("COPC node " + whole[0].hierarchy().nodes[1].key.name()),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace alidade
