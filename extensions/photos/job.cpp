// SPDX-License-Identifier: MIT
#include "extensions/photos/job.h"

#include <fmt/format.h>

#include <functional>
#include <map>
#include <memory>
#include <span>

#include "base/error.h"
#include "camera/camera_json.h"
#include "camera/formats/e57.h"
#include "extensions/photos/photo_file.h"
#include "geo/gdal_library.h"
#include "geo/geopackage.h"
#include "image/read_image.h"
#include "jobs/camera_file.h"
#include "jobs/cloud_fields.h"
#include "jobs/large_clouds.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"
#include "jobs/visibility/observer_request.h"
#include "jobs/visibility/run_fingerprint.h"
#include "jobs/write_points.h"
#include "visibility/photo_frame.h"

namespace alidade::jobs {
namespace {

namespace fs = std::filesystem;

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
    std::vector<std::string> ignored;  // which run() warned of with the cameras
    std::map<std::string, E57Representation> representations;
    for (const camera::E57Photo& each : camera::e57_photos(file_.document(), ignored))
      representations.emplace(each.camera.name, each.representation);
    for (const camera::NamedCamera& camera : cameras) {
      const E57Representation& representation = representations.at(camera.name);
      photos_.push_back(
          {file.string() + "/" + camera.name + "." + representation.extension, representation.blob});
      check_size(photos_.back().name, image::photo_size(photos_.back().name, bytes_of(photos_.back())),
                 camera);
    }
  }

  image::PhotoPixels read(std::size_t photo) {
    return image::read_photo(photos_[photo].name, bytes_of(photos_[photo]));
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
    check_size(files[i], image::photo_size(files[i], {}), cameras[i]);
  return [files](std::size_t photo) { return image::read_photo(files[photo], {}); };
}

/// Reads each camera's photo in the E57 file that the cameras are from. Opens each photo; the reader keeps
/// the file's XML. Errors: those of E57File; a photo that cannot be read, or of another size than its camera;
/// at any time, a damaged page.
PhotoReader photos_in_e57(const fs::path& file, std::span<const camera::NamedCamera> cameras) {
  const auto photos = std::make_shared<E57Photos>(file, cameras);
  return [photos](std::size_t photo) { return photos->read(photo); };
}

/// The reader of photos; empty without --colorize.
PhotoReader find_photos(const PhotosRequest& request, std::span<const camera::NamedCamera> cameras) {
  if (!request.colorize) return {};
  return request.photos.empty() ? photos_in_e57(request.cameras.file, cameras)
                                : photos_in_folder(request.photos, cameras);
}

/// check_photos(), with the file of the cameras in its errors.
void check_cameras(const PhotosRequest& request, const Octree& octree,
                   std::span<const camera::NamedCamera> cameras) {
  with_file(request.cameras.file.string(),
            [&] { visibility::check_photos(octree, cameras, request.max_distance); });
}

/// All that answers depend on: cloud, positions, and lenses and poses as camera files write them.
Fingerprint fingerprint_of(const PhotosRequest& request, const VisibilityCloud& cloud,
                           std::span<const camera::NamedCamera> cameras,
                           std::span<const visibility::Observer> observers) {
  Fingerprint fingerprint = run_fingerprint(request.checkpoint, cloud, observers);
  std::string text;
  for (const camera::NamedCamera& each : cameras) text += camera::camera_json(each.camera);
  fingerprint.push_back({"cameras", fmt::format("{:016x}", checksum(std::as_bytes(std::span(text))))});
  return fingerprint;
}

/// Points that no photo sees keep the colour they have.
void keep_colors(const AttributeColumns& columns, visibility::PhotoVisibility& seen) {
  if (columns.colors.empty()) return;
  for (std::size_t id = 0; id < seen.colors.size(); ++id)
    if (seen.counts[id] == 0) seen.colors[id] = columns.colors[id];
}

/// Warns of photos that see no point.
void warn_of_blind_photos(std::span<const camera::NamedCamera> cameras,
                          const visibility::PhotoVisibility& seen, Listener& listener) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < seen.photos.size(); ++i)
    if (seen.photos[i].points == 0) names.push_back(cameras[i].name);
  if (names.empty()) return;
  listener.warn(
      fmt::format("{} of {} photos see no point: {}", names.size(), seen.photos.size(), some_names(names)));
}

void say_result(const PhotosRequest& request, const VisibilityCloud& cloud,
                std::span<const camera::NamedCamera> cameras, const visibility::PhotoVisibility& seen,
                Listener& listener) {
  const visibility::PhotoTotals totals = visibility::totals(seen);
  const auto part = [&](std::size_t count) {
    const std::uint64_t points = totals.points_by_count[count];
    return fmt::format("{} ({:.1f} %)", points,
                       100.0 * static_cast<double>(points) / static_cast<double>(seen.counts.size()));
  };
  listener.note(fmt::format("{} points: no photo sees {}, one {}, two {}, three or more {}",
                            seen.counts.size(), part(0), part(1), part(2), part(3)));
  const std::size_t photos = seen.photos.size();
  listener.note(fmt::format(
      "{} photo{}; median ground sampling distance {:.3g}{}", photos, photos == 1 ? "" : "s",
      totals.median_sampling,
      photos == 1 ? "" : fmt::format(", median overlap {:.0f} %", 100.0 * totals.median_overlap)));
  warn_of_blind_photos(cameras, seen, listener);
  if (!request.colorize) return;
  listener.note(fmt::format("{} points have colours of photos; {} {}",
                            seen.counts.size() - totals.points_by_count[0], totals.points_by_count[0],
                            cloud.columns.colors.empty() ? "are black" : "keep the colour they had"));
}

void write(const PhotosRequest& request, const VisibilityCloud& cloud,
           std::span<const camera::NamedCamera> cameras, const visibility::PhotoVisibility& seen,
           Listener& listener) {
  if (!request.footprints.empty())
    visibility::write_photos(seen, cameras, cloud.cloud.cloud.crs, request.footprints, request.overwrite);
  if (request.output.empty()) return;
  const CloudResults results{cloud.cloud, columns_of(seen), seen.colors};
  write_points(request.output, {&results, 1}, request.overwrite, request.memory, listener);
}

void add_photos(const Fields& fields, PhotosRequest& photos) {
  const Fields group = fields.group("Photos");
  group.required().file("--camera", "FILE|FOLDER", "cameras of the photos: " + k_camera_files,
                        photos.cameras.file);
  group.text("--camera-name", "NAME", "only this camera, by the name of its photo; repeatable (default: all)",
             photos.cameras.names);
  add_camera_reading(group, "", photos.cameras);
  group.file("--photos", "FOLDER",
             "folder of the photos, for --colorize (default: those inside the E57 file of --camera)",
             photos.photos);
  group.value("--max-distance,--md", "LENGTH", "no photo sees farther (default: inf)", photos.max_distance,
              parse_distance_limit);
}

void add_answers(const Fields& fields, PhotosRequest& photos) {
  const Fields group = fields.group("Answers");
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

std::vector<ResultColumn> columns_of(const visibility::PhotoVisibility& seen) {
  return {result_column<std::uint32_t>("PhotoCount", "photos that see the point", ScalarType::uint32,
                                       [&seen](std::size_t id) { return seen.counts[id]; }),
          result_column<std::uint32_t>("BestPhoto", "finest one, from 1; 0 none", ScalarType::uint32,
                                       [&seen](std::size_t id) { return seen.best[id]; }),
          result_column<float>("GroundSampling", "length per pixel in BestPhoto", ScalarType::float32,
                               [&seen](std::size_t id) { return seen.sampling[id]; })};
}

void add_photos_fields(const Fields& fields, PhotosRequest& request) {
  add_cloud(fields, request.files, {"--ignore-classes"});
  add_photos(fields, request);
  add_occluder_fields(fields, request.occluders);
  add_answers(fields, request);
  add_checkpoint_fields(fields.group("Long runs"), request.checkpoint);
  add_scratch_memory(fields, request.memory);
  add_partial(fields, request.partial);
}

PhotosPlan plan(const PhotosRequest& request) {
  if (!request.output.empty()) check_points_name(request.output);
  if (!request.footprints.empty()) geo::check_geopackage_name(request.footprints);
  if (request.colorize && request.photos.empty() && !camera::is_e57(request.cameras.file)) {
    throw input_error("--colorize requires the photos",
                      "--photos FOLDER, or an E57 file with photos for --camera");
  }
  PlannedWork work = request.work({request.cameras.file, request.cameras.lens}, {request.footprints});
  check_outputs(work, request.overwrite);
  check_checkpoint(request.checkpoint, request.overwrite, work);
  return PhotosPlan({request, read_camera_file(request.cameras)}, std::move(work));
}

PhotosResult run(const PhotosPlan& plan, Listener& listener) {
  const PhotosRequest& request = plan.request();
  const std::vector<camera::NamedCamera>& cameras = plan.request().camera_set.cameras;
  warn_all(listener, plan.request().camera_set.warnings);
  const PhotoReader read_photo = find_photos(request, cameras);
  if (!request.footprints.empty()) geo::load_gdal();
  const auto cloud = load_cloud_alone(
      request, request.output.empty() ? AttributeSet(Attribute::classification) : AttributeSet::all(),
      AcceptedInput::points, listener);
  check_cameras(request, cloud->octree(), cameras);
  const visibility::PhotoVisibilityOptions options{.max_distance = request.max_distance,
                                                   .read_photo = read_photo,
                                                   .footprint_cell = request.footprint_cell,
                                                   .with_footprints = !request.footprints.empty()};
  visibility::check_photo_memory(cloud->octree().size(), options);
  measure_occluders(*cloud, request.occluders, listener);
  const std::vector<visibility::Observer> observers =
      visibility::photo_observers(cameras, request.max_distance);
  say_observer_remarks(observers, *cloud, listener);
  LongRun long_run(
      request.checkpoint, [&] { return fingerprint_of(request, *cloud, cameras, observers); }, listener);
  visibility::PhotoVisibility seen = long_run.test_visibility(options, [&](const auto& all) {
    return visibility::photo_visibility(*cloud->occluders, cameras, all);
  });
  keep_colors(cloud->columns, seen);
  write(request, *cloud, cameras, seen, listener);
  long_run.finish();
  say_result(request, *cloud, cameras, seen, listener);
  return {cameras, cloud->cloud.cloud.crs, std::move(seen)};
}

}  // namespace alidade::jobs
