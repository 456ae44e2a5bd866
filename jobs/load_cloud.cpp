// SPDX-License-Identifier: MIT
#include "jobs/load_cloud.h"

#include <fmt/format.h>
#include <algorithm>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/shown_text.h"
#include "octree/point_surface.h"
#include "octree/spacing.h"

namespace alidade::jobs {

PointCloud read_files(const CloudInputs& files, bool partial, ReadOptions options, Listener& listener) {
  options.partial = partial;
  PointCloud cloud = in_stage(listener, "reading", "B", [&](const Progress& progress) {
    options.progress = progress;
    return read_cloud(files, options);
  });
  warn_all(listener, cloud.warnings);
  return cloud;
}

IndexedCloud load_cloud(const CloudInputs& files, bool partial, IndexCloudOptions options,
                        Listener& listener) {
  options.read.partial = partial;
  IndexedCloud cloud = in_stage(listener, "loading cloud", "B", [&](const Progress& progress) {
    options.read.progress = progress;
    return load_indexed_cloud(files, options);
  });
  warn_all(listener, cloud.cloud.warnings);
  return cloud;
}

HeldCloud hold_cloud(const CloudInputs& files, ReadOptions options,
                     const std::optional<ScratchSpace>& scratch, Listener& listener,
                     ScratchCheckpoint* checkpoint) {
  return in_stage(listener, "reading", "B", [&](const Progress& progress) -> HeldCloud {
    options.progress = progress;
    if (scratch) return ScratchCloud(files, options, *scratch, checkpoint);
    return read_cloud(files, options);
  });
}

const PointCloud& facts_of(const HeldCloud& cloud) {
  const auto* const scratch = std::get_if<ScratchCloud>(&cloud);
  return scratch != nullptr ? scratch->facts() : std::get<PointCloud>(cloud);
}

PointColumns points_of(HeldCloud& cloud) {
  auto* const scratch = std::get_if<ScratchCloud>(&cloud);
  return scratch != nullptr ? scratch->points() : points_of(std::get<PointCloud>(cloud));
}

database::StoredFiles store_in_stages(const CloudInputs& files, ReadOptions options, std::uint64_t memory,
                                      const std::string& storing, const OpenStore& output,
                                      Listener& listener) {
  const std::unique_ptr<Listener::Stage> reading = listener.begin("reading", "B");
  options.progress = reading->callback();
  database::OrderedCloud cloud(output.folder, files, options, memory);
  reading->finish();
  in_stage(listener, storing, "points", [&](const Progress& progress) { output.store(cloud, progress); });
  warn_all(listener, cloud.whole.rest.warnings);
  return std::move(cloud).stored();
}

Field add_scratch_memory(const Fields& fields, std::optional<std::size_t>& memory) {
  return fields.value(
      "--memory", "SIZE",
      "for clouds larger than memory: hold the points in temporary files next to the output, without "
      "an output in the current folder, and sort them in so much memory, bytes or a number with k, M, G "
      "or T, at least 1M; the output is the same",
      memory, parse_memory);
}

std::optional<ScratchSpace> scratch_beside(const std::filesystem::path& output,
                                           std::optional<std::size_t> memory) {
  if (!memory) return std::nullopt;
  const std::filesystem::path folder = output.parent_path();
  return ScratchSpace{folder.empty() ? "." : folder, *memory};
}

bool knows_point_count(const CloudInputs& files, bool partial, const StatedSize& stated) {
  return !partial && stated.uncounted_bytes == 0 &&
         std::ranges::none_of(files.inputs, &CloudInput::is_changed);
}

void check_room(const std::filesystem::path& folder, std::uint64_t bytes, Listener& listener) {
  std::error_code error;
  const std::uintmax_t room = std::filesystem::space(folder, error).available;
  if (error) throw system_error(folder.string(), "cannot use this folder for temporary files", error.value());
  const std::string needed = quantity(static_cast<double>(bytes), "B"),
                    there = quantity(static_cast<double>(room), "B");
  if (bytes > room)
    throw file_error(folder, "not enough room for temporary files", needed + ", or another folder",
                     there + " free");
  listener.note(
      fmt::format("up to {} of temporary files in {}, where {} are free", needed, folder.string(), there));
}

Octree with_spacings(const Octree& octree, int neighbours, Listener& listener) {
  return in_stage(listener, "measuring spacings", "points", [&](const Progress& progress) {
    return alidade::with_spacings(octree, neighbours, progress);
  });
}

Octree with_surfaces(const Octree& octree, Listener& listener) {
  return in_stage(listener, "fitting surfaces", "points",
                  [&](const Progress& progress) { return alidade::with_surfaces(octree, progress); });
}

void check_map_unit(const Crs& crs, const CloudInputs& clouds) {
  if (!is_geographic(crs)) return;
  throw file_error(clouds.title(), "geographic coordinates (degrees) are not supported",
                   "a projected reference system: --reproject auto, or --reproject EPSG:n", crs_name(crs));
}

}  // namespace alidade::jobs
