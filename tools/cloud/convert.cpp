// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "base/error.h"
#include "base/progress.h"
#include "base/words.h"
#include "cloud/las/write_las.h"
#include "cloud/ply/write_ply.h"
#include "cloud/point_cloud.h"
#include "cloud/read_cloud.h"
#include "cloud/rows.h"
#include "cloud/scratch_cloud.h"
#include "cloud/select_points.h"
#include "cloud/text/write_text.h"
#include "database/parquet/write_parquet.h"
#include "octree/build.h"
#include "octree/point_surface.h"
#include "tools/cloud/index.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/image_module.h"
#include "tools/view_options.h"

namespace alidade::tools {
namespace {

struct ConvertCommand : CloudRequest {
  std::filesystem::path output;
  std::uint64_t every = 1;
  std::optional<double> spacing;
  ColorDepth color_depth = ColorDepth::automatic;
  bool normals = false;
  bool geometry = false;
  std::optional<std::uint32_t> group_points;
  bool overwrite = false;
  std::size_t memory = std::size_t{4} << 30;
};

bool is_parquet_name(const std::filesystem::path& name) {
  return has_extension(name, {".parquet"});
}

/// Leaves the points that were asked for.
void choose_points(PointCloud& cloud, const ConvertCommand& command) {
  if (command.every > 1) keep_every(cloud, command.every);
  if (command.spacing) {
    with_progress("thinning", "points", command.verbosity,
                  [&](const Progress& progress) { thin(cloud, *command.spacing, progress); });
  }
}

/// Gives every point the normal of the surface around it, on the side of the nearest scanner, or upwards where no
/// scanner is known; zero where there is no surface.
void add_normals(PointCloud& cloud, Verbosity verbosity) {
  const Octree octree = with_surfaces_shown(
      with_spacings_shown(build(std::as_const(cloud)), k_surface_neighbours, verbosity), verbosity);
  cloud.normals.assign(cloud.size(), glm::vec3(0.0f));
  tbb::parallel_for(std::size_t{0}, cloud.size(), [&](std::size_t row) {
    const PointSurface surface = surface_of(octree.view(), row);
    if (!surface.exists) return;
    const glm::dvec3 position = cloud.world(row);
    glm::dvec3 outwards(0.0, 0.0, 1.0);
    double nearest = std::numeric_limits<double>::infinity();
    for (const ScannerPosition& scanner : cloud.scanner_positions) {
      const glm::dvec3 towards = scanner.position - position;
      if (glm::dot(towards, towards) >= nearest) continue;
      nearest = glm::dot(towards, towards);
      outwards = towards;
    }
    cloud.normals[row] =
        glm::vec3(glm::dot(surface.normal, outwards) < 0.0 ? -surface.normal : surface.normal);
  });
}

database::ParquetOptions parquet_options(const ConvertCommand& command, const Progress& progress) {
  database::ParquetOptions options{.geometry = command.geometry,
                                   .overwrite = command.overwrite,
                                   .memory = command.memory,
                                   .projjson = [](const Crs& crs) { return image_module().projjson_of(crs); },
                                   .progress = progress};
  options.group_points = command.group_points.value_or(options.group_points);
  return options;
}

void write(const ConvertCommand& command, PointCloud& cloud) {
  if (has_extension(command.output, {".alidade"}))
    return write_index(command.output, cloud, {.overwrite = command.overwrite}, command.verbosity);
  with_progress("writing", "points", command.verbosity, [&](const Progress& progress) {
    if (has_extension(command.output, {".ply"}))
      write_ply(command.output, cloud, {.overwrite = command.overwrite, .progress = progress});
    else if (has_extension(command.output, {".csv", ".xyz"}))
      write_text(command.output, cloud,
                 {.coordinates_alone = has_extension(command.output, {".xyz"}),
                  .overwrite = command.overwrite,
                  .progress = progress});
    else if (is_parquet_name(command.output))
      database::write_parquet(command.output, cloud, parquet_options(command, progress));
    else
      write_las(command.output, cloud, {.overwrite = command.overwrite, .progress = progress});
  });
}

/// Whether the user wants other points than those that are selected while reading.
bool chooses_points(const ConvertCommand& command) {
  return command.every > 1 || command.spacing.has_value() || command.normals;
}

/// Whether nothing changes but how the points of one LAS file are packed.
bool only_packing_changes(const ConvertCommand& command) {
  const bool chooses = command.files.inputs.front().is_changed() || chooses_points(command);
  return has_extension(command.output, {".las", ".laz"}) && !is_copc_name(command.output) &&
         command.files.size() == 1 && !chooses && command.color_depth == ColorDepth::automatic &&
         !command.partial && can_repack(command.files.first_name());
}

ExitCode repack(const ConvertCommand& command) {
  const RepackedFile repacked =
      with_progress("converting", "B", command.verbosity, [&](const Progress& progress) {
        return repack_las(command.files.first_name(), command.output,
                          {.overwrite = command.overwrite, .progress = progress});
      });
  say_warnings(command.verbosity, repacked.warnings);
  say_note(command.verbosity, fmt::format("wrote all {} points to {}, with unchanged records",
                                          repacked.point_count, command.output.string()));
  return ExitCode::done;
}

/// `before`: points of the files that were selected.
void say_written(const ConvertCommand& command, std::uint64_t count, std::uint64_t before,
                 const std::vector<CloudFile>& files) {
  for (const CloudFile& file : files) before += file.left_out_count;
  say_note(command.verbosity,
           fmt::format("wrote {} of {} points to {}", count, before, command.output.string()));
}

/// Whether points need not be in memory at once, and are too many for it.
bool is_large(const ConvertCommand& command) {
  const bool is_streamed = has_extension(command.output, {".las", ".laz", ".ply", ".csv", ".xyz"}) ||
                           (has_extension(command.output, {".alidade"}) && command.every == 1);
  return is_streamed && !command.spacing && !command.normals &&
         stated_size(command.files).bytes() > command.memory;
}

/// Writes `count` points of a cloud, every N-th.
void write_in_pieces(const ConvertCommand& command, ScratchCloud& cloud, std::size_t count) {
  // A row takes up to 64 bytes, and the formats copy it.
  const std::size_t rows_at_once =
      std::clamp<std::size_t>(command.memory / 256, std::size_t{1} << 14, std::size_t{1} << 20);
  const auto every = static_cast<std::size_t>(command.every);
  PointCloud some;
  const PointPieces from = [&](std::size_t first) -> const PointCloud& {
    const std::size_t kept = std::min(std::max<std::size_t>(rows_at_once / every, 1), count - first);
    some = cloud.rows(first * every, kept > 0 ? (kept - 1) * every + 1 : 0);
    if (every > 1) keep_every(some, every);
    return some;
  };
  with_progress("writing", "points", command.verbosity, [&](const Progress& progress) {
    if (has_extension(command.output, {".ply"})) {
      write_ply(command.output, count, from, {.overwrite = command.overwrite, .progress = progress});
      return;
    }
    if (has_extension(command.output, {".csv", ".xyz"})) {
      write_text(command.output, count, from,
                 {.coordinates_alone = has_extension(command.output, {".xyz"}),
                  .overwrite = command.overwrite,
                  .progress = progress});
      return;
    }
    LasWriter writer(command.output, cloud.facts(), cloud.columns().attributes(),
                     {.overwrite = command.overwrite,
                      .progress = progress,
                      .expected_points = count,
                      .memory = command.memory / 2});
    for (std::size_t first = 0; first < count; first += some.size()) writer.write(from(first));
    writer.finish();
  });
}

ExitCode convert_large(const ConvertCommand& command) {
  const ScratchSpace scratch = *scratch_beside(command.output, command.memory / 2);
  say_note(command.verbosity, fmt::format("the points exceed --memory and lie in temporary files in {}",
                                          scratch.folder.string()));
  ScratchCloud cloud = with_progress("reading", "B", command.verbosity, [&](const Progress& progress) {
    return ScratchCloud(
        command.files, {.color_depth = command.color_depth, .partial = command.partial, .progress = progress},
        scratch);
  });
  say_warnings(command.verbosity, cloud.facts().warnings);
  const std::size_t size = cloud.size(), count = size / command.every + (size % command.every > 0 ? 1 : 0);
  if (has_extension(command.output, {".alidade"}))
    write_index(command.output, cloud, {.overwrite = command.overwrite}, scratch, command.verbosity);
  else
    write_in_pieces(command, cloud, count);
  say_written(command, count, size, cloud.facts().files);
  return ExitCode::done;
}

/// Points of a cloud that memory need not hold, since they are sorted in any case.
ExitCode convert_to_parquet(const ConvertCommand& command) {
  const database::StoredFiles stored = store_shown(
      command, command.color_depth, "writing", [&](const ReadOptions& reading, const Progress& progress) {
        return database::write_parquet(command.output, command.files, reading,
                                       parquet_options(command, progress));
      });
  say_written(command, stored.point_count, stored.point_count, stored.files);
  return ExitCode::done;
}

ExitCode run(const ConvertCommand& command) {
  if (!has_extension(command.output, {".las", ".laz", ".ply", ".csv", ".xyz", ".alidade", ".parquet"}))
    throw file_error(command.output, "unknown output format",
                     "the extension .las, .laz, .copc.laz, .ply, .csv, .xyz, .alidade or .parquet");
  if ((command.geometry || command.group_points) && !is_parquet_name(command.output)) {
    const std::string option = command.geometry ? "--geometry" : "--group-points";
    throw file_error(command.output, option + " requires Parquet", "the extension .parquet");
  }
  check_writable(command.output, command.overwrite, command.files.names());
  if (only_packing_changes(command)) return repack(command);
  if (is_parquet_name(command.output) && !chooses_points(command)) return convert_to_parquet(command);
  if (is_large(command)) return convert_large(command);
  PointCloud cloud = read_shown(command, {.color_depth = command.color_depth});
  const std::size_t before = cloud.size();
  choose_points(cloud, command);
  const std::size_t count = cloud.size();
  if (command.normals && count > 0) add_normals(cloud, command.verbosity);
  write(command, cloud);
  say_written(command, count, before, cloud.files);
  return ExitCode::done;
}

}  // namespace

Command add_convert(const Options& program) {
  auto command = std::make_shared<ConvertCommand>();
  const Options convert = program.command("convert", "Convert, join, crop and thin clouds");
  add_cloud_files(convert.required(), "files", "FILE...", k_files_help + ", or index files" + k_database_help,
                  command->files, add_view_options(convert));
  convert.required().file("-o,--output", "FILE.las|.laz|.copc.laz|.ply|.csv|.xyz|.alidade|.parquet",
                          "output file; the extension selects the format", command->output);
  convert.count("--every", "N", "keep the first point and every N-th after it", command->every, 1,
                UINT64_MAX);
  convert.length(
      "--spacing", "LENGTH",
      "keep one point per cube of this edge length, in the unit of the CRS, mostly metres: the point nearest "
      "to the mean of the cube's points, with the mean of their colours and intensities",
      command->spacing);
  convert.flag(
      "--normals",
      "give the points normals, of the planes through their neighbours: towards the nearest scanner where "
      "the file has scanner positions (E57, PTX, PCD), else upwards; zero for points without a surface",
      command->normals);
  convert.flag("--geometry",
               "Parquet: also write a column of WKB points and the metadata of GeoParquet 1.1, for GIS",
               command->geometry);
  convert.count(
      "--group-points", "N",
      "Parquet: points per row group, 1024 to 1048576 (default: 65536); fewer where these take more "
      "than 32 MiB",
      command->group_points, 1024, 1048576);
  convert.choice("--color-depth",
                 "bits in use of LAS colours (default: 8 if none exceeds 255); the output has 16",
                 command->color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  add_partial(convert, command->partial);
  convert.value(
      "--memory", "SIZE",
      "memory for points: bytes, or a number with k, M, G or T (default: 4G); those of a larger cloud "
      "use temporary files next to the output, except with --spacing and --normals",
      command->memory, parse_memory);
  convert.flag("--overwrite", "replace an existing output", command->overwrite);
  add_threads(convert, command->threads);
  add_verbosity(convert, command->verbosity);
  return command_of(convert, command, run);
}

}  // namespace alidade::tools
