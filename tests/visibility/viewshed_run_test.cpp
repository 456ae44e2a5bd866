// SPDX-License-Identifier: MIT
// How viewsheds are computed: memory, threads, interruption, invalid options.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <vector>

#include "base/checkpoint.h"
#include "base/error.h"
#include "tests/visibility/viewshed_place.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

TEST(ViewshedRunTest, a_map_too_large_for_the_memory_is_rejected_before_anything_is_laid_down) {
  Field field;
  const Observer eye = at(0, 0, 2);
  RasterGrid grid;
  grid.columns = 2'000'000'000;
  grid.rows = 1'000'000;
  EXPECT_THROW(viewshed(field.occluders(), field.ground(), {&eye, 1}, grid, {}), Error);
}

TEST(ViewshedRunTest, the_map_is_the_same_on_any_number_of_threads) {
  Field field(0.02);
  field.wall(0, -15, 15, 0, 3);
  const std::vector<Observer> eyes{at(-10, 0, 2), at(20, 10, 2)};
  for (const ViewshedMode mode : {ViewshedMode::count, ViewshedMode::height}) {
    const Viewshed many = field.seen(eyes, {.mode = mode});
    Viewshed one;
    tbb::task_arena(1).execute([&] { one = field.seen(eyes, {.mode = mode}); });
    EXPECT_EQ(many.values.values, one.values.values);
    EXPECT_EQ(many.line_count, one.line_count);
  }
}

/// A map that is stopped on one thread after half of the work, then resumed.
HugeVector<float> stopped_and_resumed(Field& field, std::span<const Observer> eyes, ViewshedOptions options,
                                      const RasterGrid& grid) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "viewshed.state";
  std::filesystem::remove(file);
  const Fingerprint fingerprint{{"command", "raster"}};
  {
    PartCheckpoint parts({.file = file, .interval = 1e-3}, fingerprint);
    ViewshedOptions cut = options;
    cut.parts = &parts;
    cut.progress = [](std::uint64_t done, std::uint64_t total) { return 2 * done < total; };
    tbb::task_arena(1).execute(
        [&] { EXPECT_THROW(viewshed(field.occluders(), field.ground(), eyes, grid, cut), Cancelled); });
  }
  PartCheckpoint parts({.file = file, .resume = true}, fingerprint);
  EXPECT_GT(parts.finished(), 0u);
  EXPECT_LT(parts.finished(), parts.count());
  options.parts = &parts;
  std::uint64_t last = 0, all = 1;
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_GE(done, last);
    last = done;
    all = total;
    return true;
  };
  const Viewshed seen = viewshed(field.occluders(), field.ground(), eyes, grid, options);
  EXPECT_EQ(last, all);
  parts.remove();
  return seen.values.values;
}

TEST(ViewshedRunTest, a_map_that_was_stopped_between_is_that_of_an_uninterrupted_run) {
  Field field;
  field.wall(3.0, -5.0, 5.0, 0.0, 2.0);
  const std::vector<Observer> eyes{at(-10, 0, 2), at(20, 10, 2)};
  // Three blocks beside each other.
  const RasterGrid grid{.north_west = {-26, 2}, .cell_size = 0.1, .columns = 520, .rows = 40};
  for (const ViewshedMode mode : {ViewshedMode::visible, ViewshedMode::count, ViewshedMode::height}) {
    const ViewshedOptions options{.mode = mode, .highest = 5.0};
    const HugeVector<float> whole =
        viewshed(field.occluders(), field.ground(), eyes, grid, options).values.values;
    const HugeVector<float> cut = stopped_and_resumed(field, eyes, options, grid);
    EXPECT_TRUE(std::ranges::equal(std::as_bytes(std::span(cut)), std::as_bytes(std::span(whole))))
        << static_cast<int>(mode);
  }
}

TEST(ViewshedRunTest, bad_wishes_are_errors_and_progress_can_stop_it) {
  Field field;
  const Observer eye = at(0, 0, 2);
  EXPECT_THROW(field.seen({}), Error);
  EXPECT_THROW(field.seen({&eye, 1}, {.target_height = -1.0}), Error);
  EXPECT_THROW(field.seen({&eye, 1}, {.target_height = std::numeric_limits<double>::quiet_NaN()}), Error);
  EXPECT_THROW(field.seen({&eye, 1}, {.mode = ViewshedMode::fraction, .positions_across = 0}), Error);
  EXPECT_THROW(field.seen({&eye, 1}, {.mode = ViewshedMode::height, .highest = 0.0}), Error);
  EXPECT_THROW(field.seen({&eye, 1}, {.progress = [](std::uint64_t, std::uint64_t) { return false; }}),
               Cancelled);
}

}  // namespace
}  // namespace alidade::test
