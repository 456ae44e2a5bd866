// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <algorithm>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/words.h"
#include "cloud/axis_units.h"
#include "cloud/cloud_reader.h"
#include "cloud/las/repack_las.h"
#include "cloud/las/write_las.h"
#include "cloud/ply/write_ply.h"
#include "cloud/point_cloud.h"
#include "cloud/read_cloud.h"
#include "cloud/rows.h"
#include "cloud/scratch_cloud.h"
#include "cloud/select_points.h"
#include "cloud/text/write_text.h"
#include "database/parquet/write_parquet.h"
#include "geo/reproject.h"
#include "octree/build.h"
#include "octree/point_surface.h"
#include "tools/cloud/index.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"

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

/// Thins the cloud as --every and --spacing request.
template <class Cloud>
void choose_points(Cloud& cloud, const ConvertCommand& command) {
  if (command.every > 1) {
    if constexpr (std::is_same_v<Cloud, ScratchCloud>)
      with_progress("choosing", "points", command.verbosity,
                    [&](const Progress& progress) { keep_every(cloud, command.every, progress); });
    else
      keep_every(cloud, command.every);
  }
  if (command.spacing) {
    with_progress("thinning", "points", command.verbosity, [&](const Progress& progress) {
      with_file(command.files.title(), [&] { thin(cloud, *command.spacing, progress); });
    });
  }
}

/// Calls work(first, end) for pieces of so many rows, until the program is interrupted. Errors: Cancelled.
template <class Work>
void in_pieces(std::size_t rows, const Work& work) {
  constexpr std::size_t k_piece = std::size_t{1} << 20;
  for (std::size_t first = 0; first < rows; first += k_piece) {
    if (interrupted()) throw Cancelled();
    work(first, std::min(first + k_piece, rows));
  }
}

/// Gives every point the normal of the surface around it, towards the nearest scanner, or upwards where no
/// scanner is known; zero where there is no surface.
void measure_normals(const Octree& built, const PointColumns& points,
                     std::span<const ScannerPosition> scanners, std::span<glm::vec3> normals,
                     Verbosity verbosity) {
  Console console(verbosity);
  const Octree octree =
      jobs::with_surfaces(jobs::with_spacings(built, k_surface_neighbours, console), console);
  const auto measure = [&](std::size_t row) {
    const PointSurface surface = surface_of(octree.view(), row);
    normals[row] = glm::vec3(0.0f);
    if (!surface.exists) return;
    const glm::dvec3 position = points.world(row);
    glm::dvec3 outwards(0.0, 0.0, 1.0);
    double nearest = std::numeric_limits<double>::infinity();
    for (const ScannerPosition& scanner : scanners) {
      const glm::dvec3 towards = scanner.position - position;
      if (glm::dot(towards, towards) >= nearest) continue;
      nearest = glm::dot(towards, towards);
      outwards = towards;
    }
    normals[row] = glm::vec3(glm::dot(surface.normal, outwards) < 0.0 ? -surface.normal : surface.normal);
  };
  in_pieces(points.size(), [&](std::size_t first, std::size_t end) {
    in_parallel(end - first, 256, [&](std::size_t i) { measure(first + i); });
  });
}

Octree built_shown(Verbosity verbosity, const std::function<Octree(const BuildOptions&)>& build) {
  return with_progress("building", "points", verbosity,
                       [&](const Progress& progress) { return build({.progress = progress}); });
}

void add_normals(PointCloud& cloud, Verbosity verbosity) {
  const Octree octree = built_shown(
      verbosity, [&](const BuildOptions& options) { return build(std::as_const(cloud), options); });
  cloud.normals.resize(cloud.size());
  measure_normals(octree, points_of(cloud), cloud.scanner_positions, cloud.normals, verbosity);
}

void add_normals(ScratchCloud& cloud, const ScratchSpace& scratch, Verbosity verbosity) {
  HugeArray<LatticePosition> used_up(cloud.size(), scratch.folder);
  const std::span<const LatticePosition> positions = cloud.positions();
  in_pieces(positions.size(), [&](std::size_t first, std::size_t end) {
    std::ranges::copy(positions.subspan(first, end - first), used_up.data() + first);
  });
  const Octree octree = built_shown(verbosity, [&](const BuildOptions& options) {
    return build_in_scratch(cloud.facts().lattice, {used_up.data(), used_up.size()}, scratch, options);
  });
  used_up = {};
  cloud.add_normals();
  measure_normals(octree, cloud.points(), cloud.facts().scanner_positions,
                  cloud.column_of<glm::vec3>(Attribute::normal), verbosity);
}

database::ParquetOptions parquet_options(const ConvertCommand& command, const Progress& progress) {
  database::ParquetOptions options{.geometry = command.geometry,
                                   .overwrite = command.overwrite,
                                   .memory = command.memory,
                                   .projjson = &geo::projjson_of,
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
      write_las(command.output, cloud,
                {.overwrite = command.overwrite, .progress = progress, .warn = [&](const std::string& text) {
                   say_warnings(command.verbosity, {text});
                 }});
  });
}

/// Whether points change after reading: some are dropped, or they get normals.
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

/// Whether the points, and measurements of them, are too large for memory.
bool is_large(const ConvertCommand& command) {
  constexpr std::uint64_t k_octree = 52, k_thinning = 17;  // bytes per point
  const StatedSize size = stated_size(command.files);
  // Files that do not state their number of points: coordinates rarely take less than those of a lattice.
  const std::uint64_t points = size.point_count + size.uncounted_bytes / sizeof(LatticePosition);
  const std::uint64_t beside = command.normals ? k_octree : command.spacing ? k_thinning : 0;
  return size.bytes() + beside * points > command.memory;
}

void write_in_pieces(const ConvertCommand& command, ScratchCloud& cloud) {
  // The formats copy rows, and Parquet sorts them.
  constexpr std::size_t k_sorting = 36, k_least_rows = std::size_t{1} << 14,
                        k_most_rows = std::size_t{1} << 20;
  const std::size_t row = 2 * bytes_per_point(cloud.facts(), cloud.columns().attributes()) + k_sorting;
  const std::size_t count = cloud.size();
  const std::size_t room = std::clamp<std::size_t>(command.memory / row, k_least_rows, UINT32_MAX);
  std::size_t rows_at_once = std::min(room, k_most_rows);
  PointCloud some;
  const PointPieces from = [&](std::size_t first) -> const PointCloud& {
    return some = cloud.rows(first, std::min(rows_at_once, count - first));
  };
  if (is_parquet_name(command.output)) {
    // Merging takes memory for each piece.
    rows_at_once = room;
    with_progress("writing", "points", command.verbosity, [&](const Progress& progress) {
      database::write_parquet(command.output, cloud.facts(), count, from, parquet_options(command, progress));
    });
    return;
  }
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
                      .memory = command.memory / 2,
                      .warn = [&](const std::string& text) { say_warnings(command.verbosity, {text}); }});
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
  const std::size_t before = cloud.size();
  choose_points(cloud, command);
  const std::size_t count = cloud.size();
  if (command.normals && count > 0) add_normals(cloud, scratch, command.verbosity);
  if (has_extension(command.output, {".alidade"}))
    write_index(command.output, cloud, {.overwrite = command.overwrite}, scratch, command.verbosity);
  else
    write_in_pieces(command, cloud);
  say_written(command, count, before, cloud.facts().files);
  return ExitCode::done;
}

/// Points of a cloud that memory need not hold, since they are sorted in any case.
ExitCode convert_to_parquet(const ConvertCommand& command) {
  Console console(command.verbosity);
  const database::StoredFiles stored =
      jobs::store_in_stages({.color_depth = command.color_depth, .partial = command.partial}, "writing",
                            console, [&](const ReadOptions& reading, const Progress& progress) {
                              return database::write_parquet(command.output, command.files, reading,
                                                             parquet_options(command, progress));
                            });
  say_written(command, stored.point_count, stored.point_count, stored.files);
  return ExitCode::done;
}

/// Errors: --spacing or --normals with different units of the axes. Warns of these units in Parquet.
void check_units(const ConvertCommand& command) {
  const bool measures = command.spacing || command.normals;
  if (command.files.empty() || (!measures && !is_parquet_name(command.output))) return;
  const CloudInput& first = command.files.inputs.front();
  if (first.format == nullptr) return;
  const Crs crs = open_cloud(first, command.partial ? Damage::read_over : Damage::reject)->facts().crs;
  const AxisUnits units = axis_units(crs);
  if (!units.plane || !units.heights || *units.plane == *units.heights) return;
  const std::string problem =
      fmt::format("the unit of x and y is {}, that of heights {}", units.plane->name, units.heights->name);
  const std::string way_out = "--reproject SYSTEM, which brings heights to the unit of x and y";
  if (measures) throw file_error(first.name, "--spacing and --normals measure: " + problem, way_out);
  say_warnings(command.verbosity,
               {fmt::format("{}: {}; distances need one unit: {}", first.name.string(), problem, way_out)});
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
  check_units(command);
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
                  command->files, add_view_fields(convert, {}, HeightUse::as_stored));
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
      "use temporary files next to the output; the output is the same",
      command->memory, parse_memory);
  convert.flag("--overwrite", "replace an existing output", command->overwrite);
  add_threads(convert, command->threads);
  add_verbosity(convert, command->verbosity);
  return command_of(convert, command, run);
}

}  // namespace alidade::tools
