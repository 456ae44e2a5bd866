// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "camera/camera_json.h"
#include "camera/formats/e57.h"
#include "geo/gdal_library.h"
#include "geo/geopackage.h"
#include "jobs/write_points.h"
#include "tools/camera_file.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/image_module.h"
#include "tools/visibility/visibility_request.h"
#include "visibility/photos/photo_file.h"
#include "visibility/photos/photo_visibility.h"

namespace alidade::tools {
namespace {

namespace fs = std::filesystem;

struct PhotosCommand : VisibilityRequest {
  std::filesystem::path cameras, lens, photos, footprints;
  std::vector<std::string> names;
  bool original_world = false, colorize = false;
  double max_distance = std::numeric_limits<double>::infinity();
  std::optional<double> footprint_cell;
  CheckpointRequest checkpoint;
};

/// Errors that need no cloud.
void check_options(const PhotosCommand& command) {
  if (command.output.empty() && command.footprints.empty())
    throw input_error("missing output", "-o FILE for points, --footprints FILE.gpkg, or both");
  if (!command.output.empty()) check_points_name(command.output);
  if (!command.footprints.empty()) geo::check_geopackage_name(command.footprints);
  if (command.colorize && command.photos.empty() && !camera::is_e57(command.cameras)) {
    throw input_error("--colorize requires the photos",
                      "--photos FOLDER, or an E57 file with photos for --camera");
  }
  const std::vector<std::filesystem::path> inputs = command.inputs({command.cameras, command.lens});
  const std::filesystem::path outputs[] = {command.output, command.footprints};
  check_outputs(outputs, command.overwrite, inputs);
  check_checkpoint(command.checkpoint, command.overwrite, outputs, inputs);
}

camera::CameraSet read_photo_cameras(const PhotosCommand& command) {
  camera::CameraFileOptions options{.lens = {}, .original_world = command.original_world};
  if (!command.lens.empty()) options.lens = camera::read_camera(command.lens);
  camera::CameraSet set = read_camera_file(command.cameras, command.names, options);
  say_warnings(command.verbosity, set.warnings);
  return set;
}

/// Reads the photo of the camera of that index.
using PhotoReader = std::function<image::PhotoPixels(std::size_t photo)>;

/// Relative names under which a photo may be in the folder. They do not lead out of it.
std::vector<fs::path> names_of(const std::string& name) {
  std::vector<fs::path> names;
  const fs::path whole = fs::path(name).lexically_normal();
  if (!whole.is_absolute() && !whole.empty() && *whole.begin() != "..") names.push_back(whole);
  if (whole.has_filename()) names.push_back(whole.filename());
  const std::size_t count = names.size();
  for (std::size_t i = 0; i < count && !whole.has_extension(); ++i) {
    for (const char* const extension : {".jpg", ".JPG", ".jpeg", ".png", ".PNG", ".tif", ".tiff"})
      names.push_back(names[i].string() + extension);
  }
  return names;
}

/// The file of a photo; empty if it is missing.
fs::path photo_of(const fs::path& folder, const std::string& name) {
  std::error_code error;
  for (const fs::path& each : names_of(name))
    if (fs::is_regular_file(folder / each, error)) return folder / each;
  return {};
}

void check_size(const fs::path& file, const image::ImageSize& found, const camera::NamedCamera& photo) {
  const camera::Camera& camera = photo.camera;
  if (found == image::ImageSize{camera.width, camera.height}) return;
  const bool is_turned = found == image::ImageSize{camera.height, camera.width};
  throw file_error(file, fmt::format("the size of the photo differs from that of camera '{}'", photo.name),
                   fmt::format("{} x {} pixels{}", camera.width, camera.height,
                               is_turned ? ", not turned" : ": the photo that the camera was computed for"),
                   fmt::format("{} x {}", found.width, found.height));
}

/// The photos of some cameras inside an E57 file.
class E57Photos {
 public:
  E57Photos(const fs::path& file, std::span<const camera::NamedCamera> cameras) : file_(InputFile(file)) {
    std::vector<std::string> ignored;  // which were printed with the cameras
    std::map<std::string, E57Representation> representations;
    for (const camera::E57Photo& each : camera::e57_photos(file_.document(), ignored))
      representations.emplace(each.camera.name, each.representation);
    for (const camera::NamedCamera& camera : cameras) {
      const E57Representation& representation = representations.at(camera.name);
      photos_.push_back(
          {file.string() + "/" + camera.name + "." + representation.extension, representation.blob});
      check_size(photos_.back().name,
                 image_module().photo_size(photos_.back().name, bytes_of(photos_.back())), camera);
    }
  }

  image::PhotoPixels read(std::size_t photo) {
    return image_module().read_photo(photos_[photo].name, bytes_of(photos_[photo]));
  }

 private:
  struct Photo {
    fs::path name;  ///< in messages, with the extension of its format
    E57Blob blob;
  };

  /// Valid until the next call.
  std::span<const std::byte> bytes_of(const Photo& photo) {
    bytes_.clear();
    file_.read_blob(photo.blob, [&](std::span<const std::byte> piece) {
      bytes_.insert(bytes_.end(), piece.begin(), piece.end());
    });
    return bytes_;
  }

  E57File file_;
  std::vector<Photo> photos_;
  std::vector<std::byte> bytes_;
};

/// Reads each camera's photo in a folder: the file with the camera's name, with its folders or without them;
/// a name without extension gets those of the usual formats of photos. Opens each photo. Errors: not a
/// folder; a photo is missing, with the number of those found; one that cannot be read, or of another size
/// than its camera.
PhotoReader photos_in_folder(const fs::path& folder, std::span<const camera::NamedCamera> cameras) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) throw file_error(folder, "not a folder", "the folder of the photos");
  std::vector<fs::path> files;
  std::vector<std::string> missing;
  for (const camera::NamedCamera& each : cameras) {
    files.push_back(photo_of(folder, each.name));
    if (files.back().empty()) missing.push_back(each.name);
  }
  if (!missing.empty()) {
    throw file_error(folder, fmt::format("the photo of camera '{}' is missing", missing.front()),
                     "a file of that name, or --camera-name to choose cameras",
                     fmt::format("{} of {} photos", cameras.size() - missing.size(), cameras.size()));
  }
  for (std::size_t i = 0; i < files.size(); ++i)
    check_size(files[i], image_module().photo_size(files[i], {}), cameras[i]);
  return [files](std::size_t photo) { return image_module().read_photo(files[photo], {}); };
}

/// Reads each camera's photo in the E57 file that the cameras are from. Opens each photo; the reader keeps
/// the file's XML. Errors: those of E57File; a photo that cannot be read, or of another size than its camera;
/// at any time, a damaged page.
PhotoReader photos_in_e57(const fs::path& file, std::span<const camera::NamedCamera> cameras) {
  const auto photos = std::make_shared<E57Photos>(file, cameras);
  return [photos](std::size_t photo) { return photos->read(photo); };
}

/// The reader of photos; empty without --colorize.
PhotoReader find_photos(const PhotosCommand& command, std::span<const camera::NamedCamera> cameras) {
  if (!command.colorize) return {};
  return command.photos.empty() ? photos_in_e57(command.cameras, cameras)
                                : photos_in_folder(command.photos, cameras);
}

/// check_photos(), with the file of the cameras in its errors.
void check_cameras(const PhotosCommand& command, const Octree& octree,
                   std::span<const camera::NamedCamera> cameras) {
  with_file(command.cameras.string(),
            [&] { visibility::check_photos(octree, cameras, command.max_distance); });
}

/// All that answers depend on: cloud, positions, and lenses and poses as camera files write them.
Fingerprint fingerprint_of(const PhotosCommand& command, const VisibilityCloud& cloud,
                           std::span<const camera::NamedCamera> cameras,
                           std::span<const visibility::Observer> observers) {
  Fingerprint fingerprint = run_fingerprint(command.checkpoint, cloud, observers);
  std::string text;
  for (const camera::NamedCamera& each : cameras) text += camera::camera_json(each.camera);
  fingerprint.push_back({"cameras", fmt::format("{:016x}", checksum(std::as_bytes(std::span(text))))});
  return fingerprint;
}

/// The columns of points; `seen` must outlive them.
std::vector<ResultColumn> columns_of(const visibility::PhotoVisibility& seen) {
  return {result_column<std::uint32_t>("PhotoCount", "photos that see the point", ScalarType::uint32,
                                       [&seen](std::size_t id) { return seen.counts[id]; }),
          result_column<std::uint32_t>("BestPhoto", "finest one, from 1; 0 none", ScalarType::uint32,
                                       [&seen](std::size_t id) { return seen.best[id]; }),
          result_column<float>("GroundSampling", "length per pixel in BestPhoto", ScalarType::float32,
                               [&seen](std::size_t id) { return seen.sampling[id]; })};
}

/// Points that no photo sees keep the colour they have.
void keep_colors(const AttributeColumns& columns, visibility::PhotoVisibility& seen) {
  if (columns.colors.empty()) return;
  for (std::size_t id = 0; id < seen.colors.size(); ++id)
    if (seen.counts[id] == 0) seen.colors[id] = columns.colors[id];
}

/// Prints the result. Returns ExitCode::no if no photo sees a point.
ExitCode say_result(const PhotosCommand& command, const VisibilityCloud& cloud,
                    std::span<const camera::NamedCamera> cameras, const visibility::PhotoVisibility& seen) {
  const visibility::PhotoTotals totals = visibility::totals(seen);
  const auto part = [&](std::size_t count) {
    const std::uint64_t points = totals.points_by_count[count];
    return fmt::format("{} ({:.1f} %)", points,
                       100.0 * static_cast<double>(points) / static_cast<double>(seen.counts.size()));
  };
  const Verbosity verbosity = command.verbosity;
  say_note(verbosity, fmt::format("{} points: no photo sees {}, one {}, two {}, three or more {}",
                                  seen.counts.size(), part(0), part(1), part(2), part(3)));
  const std::size_t photos = seen.photos.size();
  say_note(verbosity,
           fmt::format(
               "{} photo{}; median ground sampling distance {:.3g}{}", photos, photos == 1 ? "" : "s",
               totals.median_sampling,
               photos == 1 ? "" : fmt::format(", median overlap {:.0f} %", 100.0 * totals.median_overlap)));
  const ExitCode code = totals.photos_without_points == photos ? ExitCode::no : ExitCode::done;
  if (totals.photos_without_points > 0) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < photos; ++i)
      if (seen.photos[i].points == 0) names.push_back(cameras[i].name);
    say_warnings(verbosity, {fmt::format("{} of {} photos see no point: {}", totals.photos_without_points,
                                         photos, some_names(names))});
  }
  if (!command.colorize) return code;
  say_note(verbosity, fmt::format("{} points have colours of photos; {} {}",
                                  seen.counts.size() - totals.points_by_count[0], totals.points_by_count[0],
                                  cloud.columns.colors.empty() ? "are black" : "keep the colour they had"));
  return code;
}

void write(const PhotosCommand& command, const VisibilityCloud& cloud,
           std::span<const camera::NamedCamera> cameras, const visibility::PhotoVisibility& seen) {
  if (!command.footprints.empty())
    visibility::write_photos(seen, cameras, cloud.cloud.cloud.crs, command.footprints, command.overwrite);
  if (command.output.empty()) return;
  const CloudResults results{cloud.cloud, columns_of(seen), seen.colors};
  Console console(command.verbosity);
  write_points(command.output, {&results, 1}, command.overwrite, command.memory, console);
}

ExitCode run(const PhotosCommand& command) {
  check_options(command);
  const Verbosity verbosity = command.verbosity;
  Console console(verbosity);
  const camera::CameraSet set = read_photo_cameras(command);
  const PhotoReader read_photo = find_photos(command, set.cameras);
  if (!command.footprints.empty()) geo::load_gdal();
  const auto cloud = load_cloud_alone(
      command, command.output.empty() ? AttributeSet(Attribute::classification) : AttributeSet::all(),
      AcceptedInput::points, console);
  check_cameras(command, cloud->octree(), set.cameras);
  visibility::PhotoVisibilityOptions options{.max_distance = command.max_distance,
                                             .read_photo = read_photo,
                                             .footprint_cell = command.footprint_cell,
                                             .with_footprints = !command.footprints.empty()};
  visibility::check_photo_memory(cloud->octree().size(), options);
  measure_occluders(*cloud, command.occluders, console);
  const std::vector<visibility::Observer> observers =
      visibility::photo_observers(set.cameras, command.max_distance);
  say_observer_remarks(observers, *cloud, console);
  LongRun long_run(
      command.checkpoint, [&] { return fingerprint_of(command, *cloud, set.cameras, observers); }, console);
  visibility::PhotoVisibility seen = long_run.work(
      "testing visibility", "lines of sight", [&](const Progress& progress, PartCheckpoint* parts) {
        options.progress = progress;
        options.parts = parts;
        return visibility::photo_visibility(*cloud->occluders, set.cameras, options);
      });
  keep_colors(cloud->columns, seen);
  write(command, *cloud, set.cameras, seen);
  long_run.finish();
  return say_result(command, *cloud, set.cameras, seen);
}

void add_photos(const Fields& command, PhotosCommand& photos) {
  const Fields group = command.group("Photos");
  group.required().file("--camera", "FILE|FOLDER", "cameras of the photos: " + k_camera_files,
                        photos.cameras);
  group.text("--camera-name", "NAME", "only this camera, by the name of its photo; repeatable (default: all)",
             photos.names);
  add_camera_reading(group, "", photos.lens, photos.original_world);
  group.file("--photos", "FOLDER",
             "folder of the photos, for --colorize (default: those inside the E57 file of --camera)",
             photos.photos);
  group.value("--max-distance,--md", "LENGTH", "no photo sees farther (default: inf)", photos.max_distance,
              parse_distance_limit);
}

void add_answers(const Fields& command, PhotosCommand& photos) {
  const Fields group = command.group("Answers");
  const Field output = group.file("-o,--output", "FILE.las|FILE.laz|FILE.ply",
                                  "output cloud: LAS 1.4, LAZ or PLY, by the extension", photos.output);
  group.needs(output).flag("--colorize", "colour the points of the output from --photos", photos.colorize);
  const Field footprints =
      group.file("--footprints", "FILE.gpkg",
                 "GeoPackage with the footprint of each photo, and the overlaps of pairs", photos.footprints);
  group.needs(footprints)
      .number("--footprint-cell", "LENGTH",
              "width of the cells that footprints consist of (default: twice the median distance to the 8th "
              "neighbour, rounded up)",
              photos.footprint_cell, 1e-6, 1e9);
  group.flag("--overwrite", "replace existing files", photos.overwrite);
}

}  // namespace

Command add_visibility_photos(const Options& visibility) {
  auto command = std::make_shared<PhotosCommand>();
  const Options photos = visibility.command(
      "photos", "Compute which photos see which points, their footprints, and colours of points");
  add_cloud(photos, command->files, {"--ignore-classes"});
  add_photos(photos, *command);
  add_occluder_fields(photos, command->occluders);
  add_answers(photos, *command);
  add_checkpoint_fields(photos.group("Long runs"), command->checkpoint);
  add_scratch_memory(photos, command->memory);
  add_run_options(photos, *command);
  return command_of(photos, command, run);
}

}  // namespace alidade::tools
