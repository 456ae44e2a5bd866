// SPDX-License-Identifier: MIT
// Many files as one cloud: read at once, in pieces, or left unread outside a region.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "cloud/point_cloud.h"
#include "cloud/read_in_pieces.h"
#include "cloud/rows.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/las/las_builder.h"

namespace alidade {
namespace {

using test::build_las;
using test::error_of;
using test::LasFile;
using test::warns;
using Bytes = std::vector<std::byte>;

PointCloud join(const std::vector<Bytes>& tiles, const ReadOptions& options, int threads) {
  CloudInputs files;
  for (std::size_t i = 0; i < tiles.size(); ++i)
    files.inputs.push_back(cloud_in_memory(tiles[i], "tile_" + std::to_string(i)));
  PointCloud cloud;
  // The limit allows more threads than the machine has; the arena then starts them.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  arena.execute([&] { cloud = read_cloud(files, options); });
  return cloud;
}

Bytes text(const std::string& content) {
  const auto bytes = std::as_bytes(std::span(content));
  return {bytes.begin(), bytes.end()};
}

/// Tiles of every point format, of other columns, without points, and texts between them.
std::vector<Bytes> mixed_tiles() {
  std::vector<Bytes> tiles;
  for (int i = 0; i < 70; ++i) {
    const int format = i % 11;
    LasFile las = test::sample_las(4, format, i % 9 == 0 ? 0 : static_cast<std::size_t>(1 + i * 7 % 50),
                                   static_cast<std::uint64_t>(i));
    if (i % 4 == 0) las.records.resize(1);
    if (i % 4 == 0) las.records[0].data[8] = 'x';
    las.records.push_back({"tile", i % 5, "", {static_cast<std::uint8_t>(i % 3)}});
    las.global_encoding = i % 13 == 5 ? 1 : 0;
    tiles.push_back(build_las(las));
    if (i % 10 == 3)
      tiles.push_back(text("x,y,z,intensity,spare\n690000.25,5325000.5,500,3,4\n690000.5,5325001,nan,1,2\n"));
  }
  return tiles;
}

void expect_same(const PointCloud& a, const PointCloud& b) {
  EXPECT_TRUE(test::same_bits(a.positions, b.positions));
  EXPECT_EQ(a.attributes(), b.attributes());
  for_each_column(a, b, [](Attribute attribute, const auto& of_a, const auto& of_b) {
    EXPECT_TRUE(test::same_bits(of_a, of_b)) << static_cast<std::uint32_t>(attribute);
  });
  ASSERT_EQ(a.extra_dimensions.size(), b.extra_dimensions.size());
  for (std::size_t i = 0; i < a.extra_dimensions.size(); ++i) {
    EXPECT_EQ(a.extra_dimensions[i].name, b.extra_dimensions[i].name);
    EXPECT_EQ(a.extra_dimensions[i].values, b.extra_dimensions[i].values);
  }
  EXPECT_EQ(a.lattice, b.lattice);
  EXPECT_EQ(a.crs, b.crs);
  EXPECT_EQ(a.records, b.records);
  EXPECT_EQ(a.warnings, b.warnings);
  EXPECT_EQ(a.gps_time_is_standard, b.gps_time_is_standard);
  ASSERT_EQ(a.files.size(), b.files.size());
  for (std::size_t i = 0; i < a.files.size(); ++i) {
    EXPECT_EQ(a.files[i].path, b.files[i].path);
    EXPECT_EQ(a.files[i].point_count, b.files[i].point_count);
    EXPECT_EQ(a.files[i].dropped_count, b.files[i].dropped_count);
  }
}

TEST(TilesTest, the_result_is_the_same_for_any_number_of_threads) {
  const std::vector<Bytes> tiles = mixed_tiles();
  for (const AttributeSet wanted :
       {AttributeSet::all(), AttributeSet(), Attribute::color | Attribute::extra_dimensions}) {
    const PointCloud one = join(tiles, {.attributes = wanted}, 1);
    EXPECT_GT(one.size(), 1000u);
    EXPECT_GT(one.warnings.size(), 5u);
    for (const int threads : {2, 3, 8}) expect_same(one, join(tiles, {.attributes = wanted}, threads));
  }
}

/// The cloud that its pieces make.
template <class Join>
PointCloud put_together(std::uint64_t most_bytes, const Join& join_pieces, std::size_t& piece_count) {
  PointCloud cloud;
  const auto take = [&](PointCloud& piece) {
    ++piece_count;
    PointCloud points = piece;
    points.records.clear();
    points.warnings.clear();
    points.scanner_positions.clear();
    if (cloud.positions.empty()) cloud.lattice = piece.lattice;
    append_cloud(cloud, std::move(points));
    piece.resize(0);
  };
  PiecewiseCloud whole = join_pieces(CloudPieces{.most_bytes = most_bytes, .take = take});
  take(whole.rest);
  EXPECT_EQ(whole.point_count, cloud.size());
  EXPECT_EQ(whole.attributes.bits & ~whole.rest.attributes().bits & ~cloud.attributes().bits, 0u);
  EXPECT_EQ(whole.attributes, cloud.attributes());
  apply(whole.spread, cloud);
  whole.rest.positions.swap(cloud.positions);
  for_each_column(whole.rest, cloud, [](Attribute, auto& empty, auto& column) { empty.swap(column); });
  whole.rest.extra_dimensions.swap(cloud.extra_dimensions);
  return std::move(whole.rest);
}

TEST(PiecesTest, tiles_in_pieces_are_the_same_cloud) {
  const std::vector<Bytes> tiles = mixed_tiles();
  for (const std::uint64_t most_bytes : {1u, 400u, 3000u, 10'000'000u}) {
    std::size_t piece_count = 0;
    const PointCloud cloud = put_together(
        most_bytes,
        [&](const CloudPieces& pieces) {
          CloudInputs files;
          for (std::size_t i = 0; i < tiles.size(); ++i)
            files.inputs.push_back(cloud_in_memory(tiles[i], "tile_" + std::to_string(i)));
          return read_in_pieces(files, {}, pieces);
        },
        piece_count);
    expect_same(join(tiles, {}, 1), cloud);
    EXPECT_EQ(piece_count > 1, most_bytes < 1'000'000) << most_bytes;
    if (most_bytes == 1) {
      EXPECT_EQ(piece_count, cloud.size());
    }
  }
}

TEST(PiecesTest, files_of_every_format_in_pieces_are_the_same_cloud) {
  constexpr const char* k_names[] = {"lidar/extrabytes.las",
                                     "lidar/pdrf0_pennsylvania.las",
                                     "laz_vectors/micro1.laz",
                                     "laz_vectors/microz.laz",
                                     "lidar_rgb/autzen_trim.laz",
                                     "lidar_rgb/lion_takanawa.copc.laz",
                                     "ply/platonic_shelf_ascii.ply",
                                     "ply/platonic_shelf_big_endian.ply",
                                     "pcd/lamppost.pcd",
                                     "e57/ColouredCubeFloat.e57",
                                     "e57/tiny_spherical.e57",
                                     "text/1.2-with-color.ptx",
                                     "text/ripple.pts"};
  for (const char* const name : k_names) {
    SCOPED_TRACE(name);
    const std::filesystem::path file = test::shared_data(name);
    if (!std::filesystem::exists(file))
      GTEST_SKIP() << test::absent(std::string("../shared/data/") + name, std::size(k_names));
    const PointCloud whole = read_cloud(file);
    std::size_t piece_count = 0;
    expect_same(whole, put_together(
                           whole.size(),
                           [&](const CloudPieces& pieces) {
                             return read_in_pieces(resolve_clouds({&file, 1}), {}, pieces);
                           },
                           piece_count));
    // A chunk of LAZ stays together.
    if (file.extension() != ".laz") {
      EXPECT_GE(piece_count, std::min<std::size_t>(12, whole.size()));
    }
  }
}

TEST(TilesTest, columns_are_reserved_once_for_all_tiles) {
  const PointCloud cloud = join(mixed_tiles(), {}, 4);
  EXPECT_EQ(cloud.positions.capacity(), cloud.size());
  EXPECT_EQ(cloud.intensities.capacity(), cloud.size());
}

TEST(TilesTest, of_several_bad_files_the_first_is_named) {
  std::vector<Bytes> tiles = mixed_tiles();
  for (const std::size_t bad : {std::size_t{60}, std::size_t{17}, std::size_t{18}}) {
    // The second pass finds a point that is on no lattice of 32 bits; the header gives no sign of it.
    LasFile far;
    far.offset = {690000 + 1e7, 5325000, 500};
    far.points.emplace_back().x = 2147483647;
    tiles[bad] = build_las(far);
  }
  for (int i = 0; i < 20; ++i) {
    const std::string message = error_of([&] { join(tiles, {}, 4); });
    EXPECT_TRUE(message.starts_with("tile_17:")) << message;
  }
}

TEST(TilesTest, progress_is_reported_by_one_thread_at_a_time_and_never_decreases) {
  const std::vector<Bytes> tiles = mixed_tiles();
  std::atomic<int> inside = 0;
  std::uint64_t last = 0, whole = 0;
  ReadOptions options;
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_EQ(inside.fetch_add(1), 0);
    EXPECT_GE(done, last);
    EXPECT_LE(done, total);
    last = done;
    whole = total;
    std::this_thread::yield();
    inside.fetch_sub(1);
    return true;
  };
  join(tiles, options, 4);
  EXPECT_EQ(last, whole);
}

TEST(TilesTest, reading_stops_when_requested_without_further_calls) {
  const std::vector<Bytes> tiles = mixed_tiles();
  int calls = 0;
  ReadOptions options;
  options.progress = [&](std::uint64_t, std::uint64_t) { return ++calls < 20; };
  EXPECT_THROW(join(tiles, options, 4), Cancelled);
  EXPECT_EQ(calls, 20);
}

/// A tile of one point, with GPS time if its format has some.
Bytes timed_tile(int format, bool is_standard, std::size_t count = 1) {
  LasFile file;
  file.point_format = format;
  file.global_encoding = is_standard ? 1 : 0;
  file.points.resize(count);
  return build_las(file);
}

TEST(TilesTest, the_first_file_that_has_gps_times_decides_their_kind) {
  const Bytes none = timed_tile(0, false), empty = timed_tile(1, false, 0), standard = timed_tile(1, true),
              week = timed_tile(1, false), plain = text("690000.25 5325000.5 500\n"),
              untold = text("x,y,z,gps_time\n690000.25,5325000.5,500,3\n");
  for (const int threads : {1, 3}) {
    EXPECT_TRUE(join({none, standard}, {}, threads).gps_time_is_standard);
    EXPECT_TRUE(join({plain, empty, standard}, {}, threads).gps_time_is_standard);
    EXPECT_FALSE(join({timed_tile(0, true), week}, {}, threads).gps_time_is_standard);
    EXPECT_TRUE(join({timed_tile(0, true), none}, {}, threads).gps_time_is_standard) << "as the first file";
    const PointCloud texts = join({untold, standard, untold}, {}, threads);
    EXPECT_TRUE(texts.gps_time_is_standard) << "texts do not say";
    EXPECT_FALSE(texts.gps_times.empty());
    EXPECT_FALSE(warns(texts, "the coordinate reference system is described differently ("));
    const PointCloud both = join({none, standard, week}, {}, threads);
    EXPECT_TRUE(both.gps_time_is_standard);
    EXPECT_TRUE(warns(both, "tile_2: the GPS time system (week or standard) differs from that of tile_1"));
    EXPECT_FALSE(warns(join({none, standard, empty, none, standard}, {}, threads),
                       "the coordinate reference system is described differently ("));
    EXPECT_FALSE(warns(join({standard, week}, {.attributes = {}}, threads),
                       "the coordinate reference system is described differently ("))
        << "not wanted";
  }
}

TEST(TilesTest, what_is_missing_in_many_files_is_reported_once) {
  std::vector<Bytes> tiles = {timed_tile(1, true)};
  for (int i = 0; i < 5; ++i) tiles.push_back(timed_tile(0, true));
  tiles.push_back(timed_tile(0, true, 0));
  EXPECT_EQ(join(tiles, {}, 2).warnings,
            (std::vector<std::string>{"tile_1 and 4 more files: no gps_time; using 0"}));
}

/// A tile of points on a row from x = first to x = first + 9, y = z = 0, one per unit. Its header has the
/// bounds `low` and `high` in x.
Bytes tile_of_box(int first, int low, int high) {
  LasFile file;
  file.point_format = 0;
  file.offset = {0, 0, 0};
  for (int i = 0; i < 10; ++i) file.points.emplace_back().x = 100 * (first + i);
  Bytes bytes = build_las(file);
  const double box[] = {double(high), double(low), 0, 0, 0, 0};
  std::memcpy(bytes.data() + 179, box, sizeof box);
  return bytes;
}

std::vector<Bytes> row_of_tiles() {
  std::vector<Bytes> tiles;
  for (int i = 0; i < 6; ++i) tiles.push_back(tile_of_box(20 * i, 20 * i, 20 * i + 9));
  return tiles;
}

TEST(RegionTest, files_whose_box_does_not_meet_the_region_are_left_unread) {
  for (const int threads : {1, 3}) {
    const PointCloud cloud = join(row_of_tiles(), {.region = Bounds{{45, -1, -1}, {61, 1, 1}}}, threads);
    ASSERT_EQ(cloud.size(), 20u);
    EXPECT_EQ(cloud.world(0).x, 40);
    ASSERT_EQ(cloud.files.size(), 6u);
    EXPECT_EQ(cloud.files[1].skipped_count, 10u);
    EXPECT_EQ(cloud.files[1].point_count, 0u);
    EXPECT_EQ(cloud.files[2].skipped_count, 0u);
    EXPECT_EQ(cloud.files[2].point_count, 10u);
  }
}

TEST(RegionTest, faces_are_included_and_boxes_are_widened_by_what_headers_round) {
  const auto tiles_read = [](double low, double high) {
    return join(row_of_tiles(), {.region = Bounds{{low, 0, 0}, {high, 0, 0}}}, 1).size() / 10;
  };
  EXPECT_EQ(tiles_read(9, 20), 2u);
  EXPECT_EQ(tiles_read(9.079, 19.921), 2u) << "8 steps of 0.01";
  EXPECT_EQ(tiles_read(9.081, 19.919), 0u);
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(tiles_read(-inf, inf), 6u);
  EXPECT_EQ(tiles_read(50, inf), 3u);
}

TEST(RegionTest, rows_are_numbered_as_if_all_files_had_been_read) {
  const PointCloud all = join(row_of_tiles(), {}, 1);
  const PointCloud some = join(row_of_tiles(), {.region = Bounds{{25, 0, 0}, {25, 0, 0}}}, 1);
  const PointCloud others = join({row_of_tiles()[0], row_of_tiles()[5], row_of_tiles()[1]},
                                 {.region = Bounds{{-5, 0, 0}, {25, 0, 0}}}, 1);
  const RowIds ids(some.files), none(all.files), later(others.files);
  EXPECT_EQ(ids.skipped_files(), 5u);
  for (std::size_t row = 0; row < some.size(); ++row) EXPECT_EQ(some.world(row), all.world(ids(row)));
  EXPECT_EQ(none.skipped_files(), 0u);
  EXPECT_EQ(none(59), 59u);
  EXPECT_EQ(later(9), 9u);
  EXPECT_EQ(later(10), 20u);
}

TEST(RegionTest, boxes_that_cannot_be_true_are_ignored) {
  const Bounds far{{1000, 0, 0}, {1001, 0, 0}};
  const auto is_read = [&](int low, int high) {
    return join({tile_of_box(0, low, high)}, {.region = far}, 1).size() == 10;
  };
  EXPECT_FALSE(is_read(0, 9));
  EXPECT_TRUE(is_read(9, 0)) << "inverted";
  EXPECT_TRUE(is_read(0, 0)) << "ten points at one position";
  Bytes one = timed_tile(0, false);
  const double zeros[6] = {};
  std::memcpy(one.data() + 179, zeros, sizeof zeros);
  EXPECT_EQ(join({one}, {.region = far}, 1).size(), 1u) << "one point, and a box that nobody filled in";
  EXPECT_TRUE(is_read(0, 2000000000)) << "beyond 32 bits of steps";
  Bytes nan = tile_of_box(0, 0, 9);
  const double none = std::numeric_limits<double>::quiet_NaN();
  std::memcpy(nan.data() + 187, &none, sizeof none);
  EXPECT_EQ(join({nan}, {.region = far}, 1).size(), 10u);
}

TEST(RegionTest, a_region_is_ignored_for_damaged_files_and_for_texts) {
  const Bounds far{{1000, 0, 0}, {1001, 0, 0}};
  EXPECT_EQ(join(row_of_tiles(), {.partial = true, .region = far}, 1).size(), 60u);
  EXPECT_EQ(join({text("1 2 3\n4 5 6\n")}, {.region = far}, 1).size(), 2u);
}

TEST(RegionTest, the_lattice_is_that_of_all_files) {
  std::vector<Bytes> tiles = row_of_tiles();
  const double scale = 0.001;
  std::memcpy(tiles[4].data() + 131, &scale, sizeof scale);
  const PointCloud some = join(tiles, {.region = Bounds{{0, 0, 0}, {5, 0, 0}}}, 1), all = join(tiles, {}, 1);
  EXPECT_EQ(some.size(), 10u);
  EXPECT_EQ(some.lattice, all.lattice);
  EXPECT_EQ(some.lattice.scale.x, 0.001);
}

}  // namespace
}  // namespace alidade
