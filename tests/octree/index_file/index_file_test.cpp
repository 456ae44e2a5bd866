// SPDX-License-Identifier: MIT
#include "octree/index_file/index_file.h"
#include "octree/index_file/index_header.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <filesystem>

#include "cloud/read_cloud.h"
#include "octree/index_file/save_index.h"
#include "octree/query.h"
#include "octree/spacing.h"
#include "octree/tree_walk.h"
#include "surface/point_surface.h"
#include "surface/surface_cloud.h"
#include "tests/cloud/las/las_builder.h"
#include "tests/octree/index_file/index_test_support.h"
#include "tests/support/point_families.h"
#include "tests/support/ray_families.h"
#include "tests/support/spacings.h"
#include "tests/surface/surface_cases.h"

namespace alidade {
namespace {

using test::error_of;
using test::PointFamily;

/// Both octrees, and the answers they give.
void expect_same_octree(const Octree& a, const Octree& b, const PointCloud& cloud, test::Random& random) {
  const TreeView &x = a.view(), &y = b.view();
  ASSERT_EQ(x.point_count, y.point_count);
  ASSERT_EQ(x.node_count, y.node_count);
  EXPECT_EQ(x.lattice, y.lattice);
  EXPECT_EQ(x.organisation, y.organisation);
  EXPECT_EQ(x.level_count, y.level_count);
  EXPECT_EQ(x.root_level, y.root_level);
  EXPECT_EQ(x.bounds.min, y.bounds.min);
  EXPECT_EQ(x.bounds.max, y.bounds.max);
  EXPECT_EQ(x.ids == nullptr, y.ids == nullptr);
  EXPECT_EQ(x.exact_count(), y.exact_count());
  if (x.point_count > 0) {
    EXPECT_EQ(std::memcmp(x.nodes, y.nodes, x.node_count * sizeof(Node)), 0);
  }
  EXPECT_TRUE(test::equal_bits(positions_in_order(x), positions_in_order(y)));
  for (const test::RayCase& ray_case : test::ray_cases(cloud, 60, random)) {
    EXPECT_EQ(closest(a, ray_case.ray, ray_case.query), closest(b, ray_case.ray, ray_case.query));
    EXPECT_EQ(occluded(a, ray_case.ray, ray_case.query), occluded(b, ray_case.ray, ray_case.query));
  }
}

/// Saves and opens, and expects to find everything again.
void expect_round_trip(const std::filesystem::path& path, const Octree& octree, const PointCloud& cloud,
                       const PointCloud& with_positions, test::Random& random) {
  save_index(path, octree, cloud, {.overwrite = true});
  const IndexFile index = open_index(path);
  EXPECT_NO_THROW(index.verify());
  expect_same_octree(octree, index.octree(), with_positions, random);
  test::expect_same_columns(columns_of(cloud), index.columns());
  const PointCloud& description = index.description();
  test::expect_same_facts(cloud, description);
  EXPECT_EQ(index.records(), cloud.records);
  EXPECT_EQ(description.warnings, cloud.warnings);
  ASSERT_EQ(description.files.size(), cloud.files.size());
  for (std::size_t i = 0; i < cloud.files.size(); ++i) {
    EXPECT_EQ(description.files[i].path, cloud.files[i].path);
    EXPECT_EQ(description.files[i].format, cloud.files[i].format);
    EXPECT_EQ(description.files[i].version, cloud.files[i].version);
    EXPECT_EQ(description.files[i].point_format, cloud.files[i].point_format);
    EXPECT_EQ(description.files[i].point_count, cloud.files[i].point_count);
    EXPECT_EQ(description.files[i].dropped_count, cloud.files[i].dropped_count);
  }
}

TEST(IndexFile, gives_back_octree_answers_attributes_and_facts_of_every_family) {
  test::Random random;
  const auto path = test::test_folder() / "site.alidade";
  for (PointFamily& family : test::point_families()) {
    SCOPED_TRACE(family.name);
    test::fill_everything(family.cloud, random);
    expect_round_trip(path, build(family.cloud), family.cloud, family.cloud, random);
  }
}

TEST(IndexFile, gives_back_the_spacings_of_every_family) {
  test::Random random;
  const auto path = test::test_folder() / "site.alidade";
  for (const PointFamily& family : test::point_families()) {
    SCOPED_TRACE(family.name);
    const Octree octree = with_spacings(build(family.cloud), 8);
    save_index(path, octree, family.cloud, {.overwrite = true});
    const IndexFile index = open_index(path);
    EXPECT_NO_THROW(index.verify());
    const Octree opened = index.octree();
    EXPECT_EQ(opened.layers().spacing_neighbours, octree.layers().spacing_neighbours);
    if (octree.size() == 0) continue;
    EXPECT_EQ(test::spacings_by_id(opened), test::spacings_by_id(octree));
    EXPECT_EQ(with_spacings(opened, 8).layers().spacings, opened.layers().spacings)
        << "nothing is measured again";
    const SurfaceCloud spheres = SurfaceCloud::of_spheres(octree),
                       opened_spheres = SurfaceCloud::of_spheres(opened);
    for (const auto& [ray, query] : test::ray_cases(family.cloud, 20, random)) {
      const SurfaceQuery own = test::with_own_radii(query, 1.0);
      EXPECT_EQ(closest(opened_spheres, ray, own), closest(spheres, ray, own));
    }
  }
}

TEST(IndexFile, gives_back_the_surfaces_of_every_family) {
  const auto path = test::test_folder() / "site.alidade";
  for (const PointFamily& family : test::point_families()) {
    SCOPED_TRACE(family.name);
    const Octree octree = with_surfaces(with_spacings(build(family.cloud), 8));
    save_index(path, octree, family.cloud, {.overwrite = true});
    const IndexFile index = open_index(path);
    EXPECT_NO_THROW(index.verify());
    const Octree opened = index.octree();
    EXPECT_EQ(opened.memory(), octree.memory());
    if (octree.size() == 0) continue;
    const PointLayers &found = opened.layers(), &expected = octree.layers();
    EXPECT_EQ(found.surface_unit, expected.surface_unit);
    EXPECT_TRUE(std::equal(expected.surfaces, expected.surfaces + octree.size(), found.surfaces));
    EXPECT_TRUE(std::equal(expected.sheet_edges, expected.sheet_edges + octree.size(), found.sheet_edges));
    EXPECT_EQ(with_surfaces(opened).layers().surfaces, found.surfaces) << "nothing is fitted again";
  }
}

TEST(IndexFile, stores_colors_of_8_bits_in_3_bytes) {
  const auto path = test::test_folder() / "shallow.alidade";
  PointCloud cloud = test::make_cloud({{1, 2, 3}, {2, 3, 4}, {4, 4, 4}}, {glm::dvec3(1), glm::dvec3(0)});
  cloud.colors = {{0, 257, 65535}, {514, 0, 0}, {257, 257, 65278}};
  const auto saved_bytes = [&] {
    save_index(path, build(cloud), cloud, {.overwrite = true});
    const IndexFile index = open_index(path);
    index.verify();
    test::expect_same_columns(columns_of(cloud), index.columns());
    EXPECT_EQ(read_cloud(test::clouds_of({path}), {}).colors, cloud.colors);
    // Once more from the columns of the file.
    const auto again = test::test_folder() / "again.alidade";
    save_index(again, index.octree(), index.description(), index.columns(), {.overwrite = true});
    test::expect_same_columns(columns_of(cloud), open_index(again).columns());
    return index.header().find(column_section(Attribute::color))->bytes;
  };
  EXPECT_EQ(saved_bytes(), 9u);
  // Many LAS files have 256 times the values of 8 bits.
  cloud.colors = {{0, 256, 65280}, {512, 0, 0}, {256, 256, 65024}};
  EXPECT_EQ(saved_bytes(), 9u);
  for (const Color16 deep : {Color16(1, 0, 0), Color16(0, 257, 0), Color16(0, 0, 65535)}) {
    cloud.colors[2] = deep;
    EXPECT_EQ(saved_bytes(), 18u);
  }
}

TEST(IndexFile, gives_back_octrees_in_stored_order_without_ids) {
  test::Random random;
  const auto path = test::test_folder() / "site.alidade";
  for (PointFamily& family : test::point_families()) {
    SCOPED_TRACE(family.name);
    test::fill_everything(family.cloud, random);
    PointCloud ordered = family.cloud;
    const Octree octree = build_in_stored_order(ordered);
    expect_round_trip(path, octree, ordered, family.cloud, random);
    EXPECT_EQ(open_index(path).header().find(IndexSection::ids), nullptr);
  }
}

TEST(IndexFile, is_read_as_a_cloud_whose_points_stand_in_their_rows) {
  test::Random random;
  const auto path = test::test_folder() / "no_matter_what_it_is_called.las";
  for (PointFamily& family : test::point_families()) {
    SCOPED_TRACE(family.name);
    test::fill_everything(family.cloud, random);
    save_index(path, build(family.cloud), family.cloud, {.overwrite = true});
    const PointCloud read = read_cloud(test::clouds_of({path}));
    EXPECT_TRUE(test::equal_bits(read.positions, family.cloud.positions));
    test::expect_same_facts(read, family.cloud);
    EXPECT_EQ(read.records, family.cloud.records);
    if (read.size() == 0) continue;
    test::expect_same_columns(columns_of(read), columns_of(family.cloud));
  }
}

class IndexOfLas : public ::testing::TestWithParam<int> {};

TEST_P(IndexOfLas, holds_what_the_las_file_held) {
  const auto folder = std::filesystem::temp_directory_path() / ("index_of_las_" + std::to_string(GetParam()));
  std::filesystem::create_directories(folder);
  for (int version = test::oldest_las_version(GetParam()); version <= 4; ++version) {
    SCOPED_TRACE(version);
    test::write_bytes(folder / "site.las", test::build_las(test::sample_las(version, GetParam(), 500)));
    const PointCloud cloud = read_cloud(folder / "site.las");
    save_index(folder / "site.alidade", build(cloud), cloud, {.overwrite = true});
    const PointCloud read = read_cloud(test::clouds_of({folder / "site.alidade"}));
    EXPECT_TRUE(test::equal_bits(read.positions, cloud.positions));
    test::expect_same_columns(columns_of(read), columns_of(cloud));
    test::expect_same_facts(read, cloud);
    EXPECT_EQ(read.records, cloud.records);
    EXPECT_EQ(read.warnings, cloud.warnings);
    // Beside another file it joins like the LAS itself.
    const std::filesystem::path of_las[] = {folder / "site.las", folder / "site.las"};
    const CloudInputs mixed = test::clouds_of({folder / "site.alidade", folder / "site.las"});
    const PointCloud twice = read_cloud(of_las), joined = read_cloud(mixed);
    EXPECT_TRUE(test::equal_bits(joined.positions, twice.positions));
    test::expect_same_columns(columns_of(joined), columns_of(twice));
    EXPECT_EQ(joined.crs, twice.crs);
    EXPECT_EQ(joined.records, twice.records);
  }
  std::filesystem::remove_all(folder);
}

INSTANTIATE_TEST_SUITE_P(EveryPointFormat, IndexOfLas, ::testing::Range(0, 11));

PointCloud small_cloud() {
  test::Random random("small cloud");
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 2000; ++i) positions.push_back(random.in_cube());
  PointCloud cloud = test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)});
  test::fill_everything(cloud, random);
  return cloud;
}

TEST(IndexFile, keeps_only_wanted_attributes_when_read_as_a_cloud) {
  const auto path = test::test_folder() / "site.alidade";
  const PointCloud cloud = small_cloud();
  save_index(path, build(cloud), cloud);
  const PointCloud read = read_cloud(test::clouds_of({path}), {.attributes = Attribute::intensity});
  EXPECT_EQ(read.attributes(), AttributeSet(Attribute::intensity));
  EXPECT_EQ(open_index(path).attributes(), cloud.attributes());
}

TEST(IndexFile, has_the_same_bytes_on_any_number_of_threads) {
  const auto folder = test::test_folder();
  const PointCloud cloud = small_cloud();
  for (const std::size_t threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    save_index(folder / std::to_string(threads), build(cloud), cloud);
  }
  EXPECT_EQ(test::read_bytes(folder / "1"), test::read_bytes(folder / "2"));
  EXPECT_EQ(test::read_bytes(folder / "1"), test::read_bytes(folder / "4"));
}

TEST(IndexFile, an_octree_keeps_the_map_alive_and_a_replaced_file_does_not_change_it) {
  const auto path = test::test_folder() / "site.alidade";
  const PointCloud cloud = small_cloud();
  const Octree built = build(cloud);
  save_index(path, built, cloud);
  const Octree mapped = open_index(path).octree();
  PointCloud other = small_cloud();
  other.resize(10);
  save_index(path, build(other), other, {.overwrite = true});
  std::filesystem::remove(path);
  test::Random random;
  expect_same_octree(built, mapped, cloud, random);
}

TEST(IndexFile, an_existing_file_is_replaced_only_with_overwrite) {
  const auto path = test::test_folder() / "site.alidade";
  const PointCloud cloud = small_cloud();
  const Octree octree = build(cloud);
  test::write_bytes(path, {});
  EXPECT_NE(error_of([&] {
              save_index(path, octree, cloud);
            }).find("the file exists; expected another name, or --overwrite"),
            std::string::npos);
  EXPECT_EQ(std::filesystem::file_size(path), 0u);
  save_index(path, octree, cloud, {.overwrite = true});
  EXPECT_NO_THROW(verify_index(path));
}

TEST(IndexFile, a_cloud_that_does_not_belong_to_the_octree_is_an_error) {
  const auto path = test::test_folder() / "site.alidade";
  const PointCloud cloud = small_cloud();
  const Octree octree = build(cloud);
  PointCloud odd = cloud;
  odd.gps_times.pop_back();
  EXPECT_NE(error_of([&] { save_index(path, octree, odd); }).find("gps_time"), std::string::npos);
  odd = cloud;
  odd.extra_dimensions[1].values.pop_back();
  EXPECT_NE(error_of([&] { save_index(path, octree, odd); }).find("three bytes"), std::string::npos);
  odd = cloud;
  odd.lattice.scale.x = 0.002;
  EXPECT_NE(error_of([&] { save_index(path, octree, odd); }).find("lattice"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(IndexFile, a_progress_callback_that_says_stop_cancels_and_leaves_nothing) {
  const auto folder = test::test_folder();
  const PointCloud cloud = small_cloud();
  const Octree octree = build(cloud);
  const Progress stop = [](std::uint64_t, std::uint64_t) { return false; };
  EXPECT_THROW(save_index(folder / "site.alidade", octree, cloud, {.progress = stop}), Cancelled);
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  save_index(folder / "site.alidade", octree, cloud);
  const IndexFile index = open_index(folder / "site.alidade");
  EXPECT_THROW(index.octree(stop), Cancelled);
  EXPECT_THROW(index.verify(stop), Cancelled);
  EXPECT_EQ(index.octree().size(), octree.size());
}

TEST(IndexFile, progress_grows_up_to_its_total) {
  const auto path = test::test_folder() / "site.alidade";
  const PointCloud cloud = small_cloud();
  std::uint64_t last = 0, last_total = 0;
  const Progress watch = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_GE(done, last);
    EXPECT_LE(done, total);
    last = done;
    last_total = total;
    return true;
  };
  save_index(path, build(cloud), cloud, {.progress = watch});
  EXPECT_EQ(last, last_total);
  last = 0;
  const IndexFile index = open_index(path);
  index.octree(watch);
  EXPECT_EQ(last, last_total);
  last = 0;
  index.verify(watch);
  EXPECT_EQ(last, std::filesystem::file_size(path));
}

TEST(IndexFile, holds_what_files_held_that_nobody_here_made) {
  const std::filesystem::path data = test::shared_data("lidar");
  if (data.empty()) GTEST_SKIP() << test::absent("../shared/data/lidar", 6);
  const auto path = test::test_folder() / "site.alidade";
  int count = 0;
  for (const char* const name : {"lidar", "lidar_rgb", "ply", "pcd"}) {
    for (const auto& entry : std::filesystem::directory_iterator(test::shared_data(name))) {
      SCOPED_TRACE(entry.path());
      const std::string extension = entry.path().extension().string();
      if (extension != ".las" && extension != ".ply" && extension != ".pcd") continue;
      const PointCloud cloud = read_cloud(entry.path());
      save_index(path, build(cloud), cloud, {.overwrite = true});
      EXPECT_NO_THROW(verify_index(path));
      const PointCloud read = read_cloud(test::clouds_of({path}));
      EXPECT_TRUE(test::equal_bits(read.positions, cloud.positions));
      test::expect_same_columns(columns_of(read), columns_of(cloud));
      test::expect_same_facts(read, cloud);
      EXPECT_EQ(read.records, cloud.records);
      EXPECT_EQ(read.warnings, cloud.warnings);
      ++count;
    }
  }
  EXPECT_GT(count, 5);
}

TEST(IndexedCloud, comes_from_the_map_or_from_reading_and_building_with_the_same_answers) {
  const auto folder = test::test_folder();
  test::write_bytes(folder / "site.las", test::build_las(test::sample_las(4, 7, 500)));
  const std::filesystem::path las = folder / "site.las", alidade = folder / "site.alidade";
  const IndexedCloud built = load_indexed_cloud(test::clouds_of({las}));
  save_index(alidade, built.octree, built.cloud);
  const IndexedCloud mapped = load_indexed_cloud(test::clouds_of({alidade}));
  EXPECT_FALSE(built.index);
  ASSERT_TRUE(mapped.index);
  test::Random random;
  expect_same_octree(built.octree, mapped.octree, read_cloud(las), random);
  test::expect_same_columns(built.columns(), mapped.columns());
  EXPECT_EQ(built.cloud.crs, mapped.cloud.crs);
  ASSERT_EQ(mapped.cloud.files.size(), 1u);
  EXPECT_EQ(mapped.cloud.files[0].path, las);
}

TEST(IndexFile, is_told_by_its_content) {
  const auto folder = test::test_folder();
  const PointCloud cloud = small_cloud();
  save_index(folder / "a.las", build(cloud), cloud);
  test::write_bytes(folder / "b.alidade", std::as_bytes(std::span("0 0 0")));
  const CloudInputs clouds = test::clouds_of({folder / "a.las", folder / "b.alidade", folder / "absent"});
  EXPECT_TRUE(clouds.inputs[0].is(k_index_format));
  EXPECT_FALSE(clouds.inputs[1].is(k_index_format));
  EXPECT_EQ(clouds.inputs[2].format, nullptr);
}

}  // namespace
}  // namespace alidade
