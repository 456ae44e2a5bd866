// SPDX-License-Identifier: MIT
#include "tools/cloud/load_cloud.h"

#include <fmt/format.h>

#include "base/error.h"
#include "database/server/server_clouds.h"
#include "database/sqlite/stored_cloud.h"
#include "octree/point_surface.h"
#include "octree/spacing.h"

namespace alidade::tools {

CloudFormats cloud_formats() {
  static const std::vector<const CloudFormat*> formats =
      with_file_formats({&database::k_server_format, &database::k_sqlite_format, &k_index_format});
  return formats;
}

PointCloud read_shown(const CloudRequest& request, ReadOptions options) {
  options.partial = request.partial;
  PointCloud cloud = with_progress("reading", "B", request.verbosity, [&](const Progress& progress) {
    options.progress = progress;
    return read_cloud(request.files, options);
  });
  say_warnings(request.verbosity, cloud.warnings);
  return cloud;
}

IndexedCloud load_shown(const CloudRequest& request, IndexCloudOptions options) {
  options.read.partial = request.partial;
  IndexedCloud cloud = with_progress("loading cloud", "B", request.verbosity, [&](const Progress& progress) {
    options.read.progress = progress;
    return load_indexed_cloud(request.files, options);
  });
  say_warnings(request.verbosity, cloud.cloud.warnings);
  return cloud;
}

Option add_scratch_memory(const Options& command, std::optional<std::size_t>& memory) {
  return command.value(
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

void check_room(const std::filesystem::path& folder, std::uint64_t bytes, Verbosity verbosity) {
  std::error_code error;
  const std::uintmax_t room = std::filesystem::space(folder, error).available;
  if (error) throw system_error(folder.string(), "cannot use this folder for temporary files", error.value());
  const std::string needed = quantity(static_cast<double>(bytes), "B"),
                    there = quantity(static_cast<double>(room), "B");
  if (bytes > room)
    throw file_error(folder, "not enough room for temporary files", needed + ", or another folder",
                     there + " free");
  say_note(verbosity, fmt::format("up to {} of temporary files in {}, where {} are free", needed,
                                  folder.string(), there));
}

database::StoredFiles store_shown(
    const RunRequest& request, ColorDepth color_depth, const std::string& storing,
    const std::function<database::StoredFiles(const ReadOptions& reading, const Progress& storing)>& work) {
  ProgressLine read_line("reading", "B", request.verbosity);
  std::optional<ProgressLine> store_line;
  Progress store_progress;
  const ReadOptions reading{
      .color_depth = color_depth, .partial = request.partial, .progress = read_line.callback()};
  database::StoredFiles stored = work(reading, [&](std::uint64_t done, std::uint64_t total) {
    if (!store_line) {
      read_line.finish();
      store_line.emplace(storing, "points", request.verbosity);
      store_progress = store_line->callback();
    }
    return store_progress(done, total);
  });
  if (store_line) store_line->finish();
  say_warnings(request.verbosity, stored.warnings);
  return stored;
}

Octree with_spacings_shown(const Octree& octree, int neighbours, Verbosity verbosity) {
  return with_progress("measuring spacings", "points", verbosity,
                       [&](const Progress& progress) { return with_spacings(octree, neighbours, progress); });
}

Octree with_surfaces_shown(const Octree& octree, Verbosity verbosity) {
  return with_progress("fitting surfaces", "points", verbosity,
                       [&](const Progress& progress) { return with_surfaces(octree, progress); });
}

bool has_parts(const CloudInput& input) {
  if (input.is_changed()) return false;
  const bool has_parts = input.is(database::k_server_format) ? database::has_server_parts(input.name.string())
                                                             : input.is(database::k_sqlite_format);
  return has_parts && !input.changes_heights();
}

void check_map_unit(const Crs& crs, const CloudInputs& clouds) {
  if (!is_geographic(crs)) return;
  throw file_error(clouds.title(), "geographic coordinates (degrees) are not supported",
                   "a projected reference system: --reproject auto, or --reproject EPSG:n", crs_name(crs));
}

const char* part_unit(const CloudInput& input) {
  return input.is(database::k_server_format) ? "points" : "chunks";
}

database::CloudPart read_database_part(const CloudInput& input, std::span<const database::PointFilter> any_of,
                                       AttributeSet attributes, const Progress& progress) {
  const auto read =
      input.is(database::k_server_format) ? database::read_server_part : database::read_cloud_part;
  return read(input.name.string(), any_of, attributes, progress);
}

std::string part_table(const database::CloudPart& part) {
  if (part.chunk_count == 0) return fmt::format("{:<22}{:>16}\n", "points read", part.ids.size());
  const double share = 100.0 * static_cast<double>(part.chunks_read) / static_cast<double>(part.chunk_count);
  return fmt::format("{:<22}{:>16}{:>15.2f}%\n", "chunks read", part.chunks_read, share);
}

}  // namespace alidade::tools
