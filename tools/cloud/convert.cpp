// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "base/bounds.h"
#include "base/error.h"
#include "base/progress.h"
#include "base/words.h"
#include "cloud/las/write_las.h"
#include "cloud/ply/write_ply.h"
#include "cloud/point_cloud.h"
#include "cloud/read_cloud.h"
#include "cloud/rows.h"
#include "cloud/select_points.h"
#include "geo/vector_file.h"
#include "tools/cloud/index.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/image_module.h"

namespace alidade::tools {
namespace {

/// --crop and --crop-crs: which part of a cloud is wanted.
struct CropOptions {
  std::string text;                ///< as it was given; empty = all of the cloud
  std::optional<Bounds> box;       ///< x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1
  std::filesystem::path polygons;  ///< or a file of polygons
  std::string reference;           ///< --crop-crs, as ObserverReference::given

  bool given() const { return !text.empty(); }
};

/// Whether a text is meant as a box. A file whose name holds commas comes first.
bool is_box(const std::string& text) {
  std::error_code error;
  return text.find(',') != std::string::npos && !std::filesystem::exists(text, error);
}

Bounds parse_box(const std::string& text) {
  std::vector<double> numbers;
  for (const std::string& word : split_list(text)) numbers.push_back(parse_number(word));
  if (numbers.size() != 4 && numbers.size() != 6)
    throw UsageError("invalid value; expected x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1 or a polygon file, found '" +
                     text + "'");
  const std::size_t axes = numbers.size() / 2;
  Bounds box{glm::dvec3(std::numeric_limits<double>::lowest()),
             glm::dvec3(std::numeric_limits<double>::max())};
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const auto position = static_cast<int>(axis);
    box.min[position] = numbers[axis];
    box.max[position] = numbers[axes + axis];
    if (box.min[position] > box.max[position]) {
      throw UsageError(
          fmt::format("limits out of order; expected the lower {0} first, found {0} from {1} to {2}",
                      "xyz"[axis], box.min[position], box.max[position]));
    }
  }
  return box;
}

/// Where points were, also those of files that were left unread; empty if there were none.
std::string whereabouts(const PointCloud& cloud) {
  Bounds box = cloud.bounds();
  std::uint64_t skipped = 0;
  for (const CloudFile& file : cloud.files) {
    skipped += file.skipped_count;
    if (file.skipped_count > 0 && file.stated_bounds) box.grow(*file.stated_bounds);
  }
  if (cloud.size() + skipped == 0) return "";
  return fmt::format("points from {}, {}, {} to {}, {}, {}", box.min.x, box.min.y, box.min.z, box.max.x,
                     box.max.y, box.max.z);
}

std::vector<PlanePolygon> read_polygons(const CropOptions& options, const Crs& crs) {
  return image_module().read_polygons(
      options.polygons,
      {.given = options.reference, .cloud = crs, .option = "--crop-crs", .whose = "polygons"});
}

void add_crop_options(const Options& command, CropOptions& options) {
  command.value("--crop", "BOX|FILE",
                "keep points in the box x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1, in the cloud's unit, mostly "
                "metres, or in the polygons of a GeoJSON, GeoPackage or Shapefile; the border is included",
                [&options](const std::string& text) {
                  if (text.empty()) throw UsageError("missing value; expected a box or a file");
                  options.text = text;
                  options.box = is_box(text) ? std::optional(parse_box(text)) : std::nullopt;
                  options.polygons = options.box ? "" : text;
                });
  command.value(
      "--crop-crs", "SYSTEM",
      "reference system of the polygons, such as EPSG:4326, overriding their file; 'cloud' for the cloud's",
      [&options](const std::string& text) { options.reference = text; });
}

/// Finds what is wrong before a cloud is read. Errors: no such file; --crop-crs without a file.
void check_crop(const CropOptions& options) {
  if (options.polygons.empty()) {
    if (!options.reference.empty()) throw input_error("--crop-crs requires a polygon file", "--crop FILE");
    return;
  }
  std::error_code error;
  if (!std::filesystem::is_regular_file(options.polygons, error))
    throw file_error(options.polygons, "not a file", "x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1 or a polygon file");
}

/// Crops a cloud, which may lack the files outside the box (ReadOptions::region). Errors: as read_polygons()
/// of geo/vector_file.h and image_module(); no point is left of a cloud that had some.
void crop(PointCloud& cloud, const CropOptions& options, const Progress& progress) {
  if (!options.given()) return;
  const std::string before = whereabouts(cloud);
  if (options.box) {
    crop(cloud, *options.box, progress);
  } else {
    crop(cloud, read_polygons(options, cloud.crs), progress);
  }
  if (cloud.size() == 0 && !before.empty()) {
    throw file_error(options.polygons,
                     options.box ? fmt::format("no points inside --crop {}", options.text)
                                 : "no points inside the polygons",
                     "a part of the cloud", before);
  }
}

struct ConvertCommand : CloudRequest {
  std::filesystem::path output;
  CropOptions crop;
  std::uint64_t every = 1;
  std::optional<double> spacing;
  ColorDepth color_depth = ColorDepth::automatic;
  bool overwrite = false;
};

/// Leaves the points that were asked for.
void choose_points(PointCloud& cloud, const ConvertCommand& command) {
  if (command.crop.given()) {
    with_progress("cropping", "points", command.verbosity,
                  [&](const Progress& progress) { crop(cloud, command.crop, progress); });
  }
  if (command.every > 1) keep_every(cloud, command.every);
  if (command.spacing) {
    with_progress("thinning", "points", command.verbosity,
                  [&](const Progress& progress) { thin(cloud, *command.spacing, progress); });
  }
}

void write(const ConvertCommand& command, PointCloud& cloud) {
  if (has_extension(command.output, {".alidade"}))
    return write_index(command.output, cloud, {.overwrite = command.overwrite}, command.verbosity);
  with_progress("writing", "points", command.verbosity, [&](const Progress& progress) {
    if (has_extension(command.output, {".ply"}))
      write_ply(command.output, cloud, {.overwrite = command.overwrite, .progress = progress});
    else
      write_las(command.output, cloud, {.overwrite = command.overwrite, .progress = progress});
  });
}

/// Whether nothing changes but how the points of one LAS file are packed.
bool only_packing_changes(const ConvertCommand& command) {
  const bool chooses = command.crop.given() || command.every > 1 || command.spacing.has_value();
  return has_extension(command.output, {".las", ".laz"}) && command.files.size() == 1 && !chooses &&
         command.color_depth == ColorDepth::automatic && !command.partial &&
         can_repack(command.files.first_name());
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

ExitCode run(const ConvertCommand& command) {
  if (!has_extension(command.output, {".las", ".laz", ".ply", ".alidade"}))
    throw file_error(command.output, "unknown output format", "the extension .las, .laz, .ply or .alidade");
  check_crop(command.crop);
  check_writable(command.output, command.overwrite, command.files.names());
  if (only_packing_changes(command)) return repack(command);
  PointCloud cloud = read_shown(command, {.color_depth = command.color_depth, .region = command.crop.box});
  std::uint64_t all = cloud.size();
  for (const CloudFile& file : cloud.files) all += file.skipped_count;
  choose_points(cloud, command);
  const std::size_t count = cloud.size();
  write(command, cloud);
  say_note(command.verbosity,
           fmt::format("wrote {} of {} points to {}", count, all, command.output.string()));
  return ExitCode::done;
}

}  // namespace

Command add_convert(const Options& program) {
  auto command = std::make_shared<ConvertCommand>();
  const Options convert = program.command("convert", "Convert, join, crop and thin clouds");
  add_cloud_files(convert.required(), "files", "FILE...", k_files_help + ", or index files" + k_database_help,
                  command->files);
  convert.required().file("-o,--output", "FILE.las|.laz|.ply|.alidade",
                          "output file; the extension selects the format", command->output);
  add_crop_options(convert, command->crop);
  convert.count("--every", "N", "keep the first point and every N-th after it", command->every, 1,
                UINT64_MAX);
  convert.length(
      "--spacing", "LENGTH",
      "keep one point per cube of this edge length, in the unit of the CRS, mostly metres: the point nearest "
      "to the mean of the cube's points, with the mean of their colours and intensities",
      command->spacing);
  convert.choice("--color-depth",
                 "bits in use of LAS colours (default: 8 if none exceeds 255); the output has 16",
                 command->color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  add_partial(convert, command->partial);
  convert.flag("--overwrite", "replace an existing output", command->overwrite);
  add_threads(convert, command->threads);
  add_verbosity(convert, command->verbosity);
  return command_of(convert, command, run);
}

}  // namespace alidade::tools
