// SPDX-License-Identifier: MIT
#include "extensions/change/job.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>

#include "base/error.h"
#include "cloud/crs.h"
#include "jobs/cloud_fields.h"
#include "jobs/large_clouds.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"
#include "jobs/visibility/visibility_cloud.h"
#include "jobs/write_points.h"
#include "visibility/read_observers.h"

namespace alidade::jobs {
namespace {

using visibility::ChangeClass;
using visibility::ChangeSummary;

/// An epoch in memory. `columns` are of `cloud`, which therefore must not move.
struct EpochCloud {
  IndexedCloud cloud;
  AttributeColumns columns;
  std::vector<glm::dvec3> origins;
  std::optional<visibility::Occluders> occluders;  ///< empty until they are measured
};

void add_epoch(const Fields& fields, const char* operand, const CloudView& view, EpochRequest& epoch) {
  fields.required().value(
      operand, epoch.name,
      "the cloud of this epoch: a file, a folder, a quoted pattern such as 'tiles/*.las', an index file "
      "(.alidade)" +
          database_help(),
      [&epoch, view](const std::string& text) {
        epoch.files = view.apply(resolve_clouds(std::vector<std::filesystem::path>{text}, cloud_formats()));
      });
}

glm::dvec3 parse_position(const std::string& text) {
  const std::vector<std::string> words = split_list(text, 3, "X,Y,Z");
  return {parse_number(words[0]), parse_number(words[1]), parse_number(words[2])};
}

void add_origins(const Fields& fields, EpochRequest& epoch) {
  const Fields group = fields.group("Scanner positions");
  group.values(epoch.option, "X,Y,Z",
               fmt::format("position of a scanner of {}, in the coordinates of the cloud; repeatable "
                           "(default: the poses of an E57, PTX or PCD file)",
                           epoch.name),
               [&epoch](const std::string& text) { epoch.origins.push_back(parse_position(text)); });
  group.file(
      epoch.files_option, "FILE",
      fmt::format("scanner positions of {} from a file: CSV with the header x,y,z, or points of GeoJSON, "
                  "GeoPackage or Shapefile with z",
                  epoch.name),
      epoch.origins_file);
}

void add_distances(const Fields& fields, ChangeRequest& request) {
  const Fields group = fields.group("Distances");
  group.number("--registration-error", "LENGTH",
               "standard deviation of the offset between both clouds, in metres (default: 0)",
               request.options.registration_error, 0.0, 1e6);
  group.number(
      "--normal-radius", "LENGTH",
      "radius of the sphere whose points define the normal, in metres (default, and where it holds too few "
      "points: per point, 2.5 times the distance to its 8th neighbour, or less at edges)",
      request.options.normal_radius, 1e-6, 1e6);
  group.number(
      "--cylinder-radius", "LENGTH",
      "radius of the cylinder along the normal whose points are averaged, in metres; both clouds need 4 "
      "points in it (default: per point, twice the distance to the 8th neighbour in the sparser cloud)",
      request.options.cylinder_radius, 1e-6, 1e6);
  group.number(
      "--max-distance", "LENGTH",
      "half length of the cylinder, in metres: a surface farther along the normal is another one (default: "
      "3 radii of the cylinder)",
      request.options.max_distance, 1e-6, 1e6);
}

std::vector<glm::dvec3> origins_of(const EpochRequest& epoch, const PointCloud& cloud) {
  std::vector<glm::dvec3> origins = epoch.origins;
  if (!epoch.origins_file.empty()) {
    const geo::ObserverReference reference{
        .cloud = cloud.crs, .option = epoch.files_option, .whose = "scanner positions"};
    for (const visibility::GivenObserver& one : visibility::read_observers(epoch.origins_file, reference)) {
      if (!one.z) throw file_error(one.source, "a scanner position has no height", "x, y and z");
      origins.emplace_back(one.position, *one.z + one.height.value_or(0.0));
    }
  }
  if (origins.empty())
    for (const ScannerPosition& scanner : cloud.scanner_positions)
      if (!scanner.axes) origins.push_back(scanner.position);  // a depth camera has not seen all around it
  return origins;
}

std::unique_ptr<EpochCloud> load_epoch(const ChangeRequest& request, const EpochRequest& epoch,
                                       Listener& listener) {
  auto loaded = std::make_unique<EpochCloud>();
  loaded->cloud = load_cloud(epoch.files, request.partial,
                             {.scratch = scratch_beside(request.output, request.memory)}, listener);
  if (loaded->cloud.octree.size() == 0) throw file_error(epoch.files.first_name(), "the cloud has no points");
  check_map_unit(loaded->cloud.cloud.crs, epoch.files);
  loaded->columns = loaded->cloud.columns();
  loaded->origins = origins_of(epoch, loaded->cloud.cloud);
  if (loaded->origins.empty() && !request.no_sight) {
    throw file_error(
        epoch.files.first_name(),
        fmt::format("unknown scanner positions: what is {} cannot be distinguished from what was never seen",
                    &epoch == &request.before ? "new" : "gone"),
        fmt::format("{} X,Y,Z, {} FILE, an E57, PTX or PCD file with poses, or --no-sight", epoch.option,
                    epoch.files_option));
  }
  if (!loaded->origins.empty())
    listener.note(fmt::format("{}: {} points, {} scanner position(s)", epoch.name,
                              loaded->cloud.octree.size(), loaded->origins.size()));
  return loaded;
}

/// Errors: both systems are known and differ; only one is, and its heights are converted.
void check_systems(const ChangeRequest& request, const EpochCloud& before, const EpochCloud& after,
                   Listener& listener) {
  const Crs &old_crs = before.cloud.cloud.crs, &new_crs = after.cloud.cloud.crs;
  const EpochRequest& other = old_crs.empty() ? request.before : request.after;
  const EpochRequest& stated = old_crs.empty() ? request.after : request.before;
  if (old_crs == new_crs) return;
  if (old_crs.empty() || new_crs.empty()) {
    if (std::ranges::any_of(stated.files.inputs, &CloudInput::changes_heights))
      throw file_error(
          other.files.first_name(),
          fmt::format("no reference system, and the heights of {} are converted to the unit of x and y",
                      stated.name),
          "--crs EPSG:n, which states one");
    listener.warn(fmt::format(
        "only {} states a reference system; that of the other is assumed to be the same", stated.name));
    return;
  }
  check_same_system(
      {old_crs, "BEFORE"}, {new_crs, "AFTER"},
      file_error(other.files.first_name(), "AFTER is in another reference system than BEFORE",
                 crs_name(old_crs) + ": --reproject SYSTEM brings both to one", crs_name(new_crs)),
      listener);
}

void measure(const ChangeRequest& request, EpochCloud& epoch, Listener& listener) {
  epoch.occluders = measured_occluders(epoch.cloud.octree, epoch.columns.classifications,
                                       request.ignored_classes, {}, listener);
}

const ChangeSummary& summary_of(const EpochResult& found, ChangeClass kind) {
  return found.classes[static_cast<std::size_t>(kind)];
}

/// Warns of radii that are too small for a cloud.
void say_radii(const char* epoch, const EpochResult& found, Listener& listener) {
  const visibility::PointChanges& points = found.points;
  if (points.wider_normals > 0) {
    listener.warn(
        fmt::format("{}: --normal-radius holds too few points for a normal at {} of {} points; their normals "
                    "come from 2.5 times the distance to the 8th neighbour",
                    epoch, points.wider_normals, points.classes.size()));
  }
  const std::uint64_t count = summary_of(found, ChangeClass::not_measured).count;
  if (2 * count > points.classes.size()) {
    listener.warn(
        fmt::format("{}: {} of {} points are not measured: {} have no normal (--normal-radius), {} too few "
                    "points in their cylinder (--cylinder-radius, --max-distance)",
                    epoch, count, points.classes.size(), points.without_normal, points.too_few_points));
  }
}

/// Warns if most of what is compared has moved by more than its level of detection, without a registration
/// error.
void say_registration(double registration_error, const EpochResult& found, Listener& listener) {
  const ChangeSummary &same = summary_of(found, ChangeClass::same),
                      &moved = summary_of(found, ChangeClass::moved);
  if (registration_error > 0.0 || moved.count <= same.count) return;
  listener.warn(
      fmt::format("most surfaces have moved, half of them by less than {:.4f}; if that is the accuracy of "
                  "the registration, pass it as --registration-error",
                  *moved.median_absolute_distance));
}

}  // namespace

void add_change_fields(const Fields& fields, ChangeRequest& request,
                       const std::function<void()>& add_answers) {
  const CloudView view = add_view_fields(fields, {"--ignore-classes"});
  add_epoch(fields, "before", view, request.before);
  add_epoch(fields, "after", view, request.after);
  fields.required().file("-o,--output", "FILE.las|FILE.laz|FILE.ply",
                         "output: the points of both epochs, as LAS 1.4, LAZ or PLY, by the extension",
                         request.output);
  add_origins(fields, request.before);
  add_origins(fields, request.after);
  const Fields sight = fields.group("Scanner positions");
  sight.flag(
      "--no-sight",
      "accept unknown scanner positions: points without a counterpart in that epoch are unmatched, not gone, "
      "new or never seen",
      request.no_sight);
  sight.number(
      "--max-range", "LENGTH",
      "range of the scanners, in metres: lines of sight do not pass anything farther away (default: inf)",
      request.options.max_range, 1e-6, 1e9);
  add_distances(fields, request);
  add_ignored_classes(fields, "are not compared", request.ignored_classes);
  add_answers();
  fields.flag("--overwrite", "replace an existing output", request.overwrite);
  add_scratch_memory(fields, request.memory);
  add_partial(fields, request.partial);
}

ChangePlan plan(const ChangeRequest& request) {
  if (!request.output.empty()) check_points_name(request.output);
  PlannedWork work{.clouds = request.before.files,
                   .partial = request.partial,
                   .reads = {request.before.origins_file, request.after.origins_file},
                   .writes = {request.output},
                   .bytes_per_point = request.memory ? 0.0 : 45.0};
  const std::vector<CloudInput>& after = request.after.files.inputs;
  work.clouds.inputs.insert(work.clouds.inputs.end(), after.begin(), after.end());
  check_outputs(work, request.overwrite);
  return ChangePlan(request, std::move(work));
}

std::vector<ResultColumn> columns_of(const visibility::PointChanges& changes, std::uint8_t epoch) {
  std::vector<ResultColumn> columns;
  columns.push_back(result_column<std::uint8_t>("Epoch", "1: BEFORE, 2: AFTER", ScalarType::uint8,
                                                [epoch](std::size_t) { return epoch; }));
  columns.push_back(result_column<std::uint8_t>(
      "Change", "class, 0 same to 7 not measured", ScalarType::uint8,
      [&changes](std::size_t id) { return static_cast<std::uint8_t>(changes.classes[id]); }));
  columns.push_back(result_column<float>("M3C2Distance", "BEFORE to AFTER on the normal", ScalarType::float32,
                                         [&changes](std::size_t id) { return changes.distances[id]; }));
  columns.push_back(
      result_column<float>("LoD95", "level of detection, 95 %", ScalarType::float32,
                           [&changes](std::size_t id) { return changes.detection_levels[id]; }));
  return columns;
}

ChangeResult run(const ChangePlan& plan, Listener& listener) {
  const ChangeRequest& request = plan.request();
  const auto before = load_epoch(request, request.before, listener);
  const auto after = load_epoch(request, request.after, listener);
  check_systems(request, *before, *after, listener);
  visibility::check_overlap(before->cloud.octree, after->cloud.octree);
  measure(request, *before, listener);
  measure(request, *after, listener);
  visibility::ChangeOptions options = request.options;
  visibility::Changes changes = in_stage(listener, "comparing", "points", [&](const Progress& progress) {
    options.progress = progress;
    return visibility::find_changes({*before->occluders, before->origins},
                                    {*after->occluders, after->origins}, options);
  });
  ChangeResult result;
  result.before.classes = summaries_of(changes.before, *before->occluders);
  result.after.classes = summaries_of(changes.after, *after->occluders);
  result.before.crs = before->cloud.cloud.crs;
  result.after.crs = after->cloud.cloud.crs;
  result.before.points = std::move(changes.before);
  result.after.points = std::move(changes.after);
  if (!request.output.empty()) {
    const CloudResults results[] = {{before->cloud, columns_of(result.before.points, 1)},
                                    {after->cloud, columns_of(result.after.points, 2)}};
    write_points(request.output, results, request.overwrite, request.memory, listener);
  }
  say_radii("BEFORE", result.before, listener);
  say_radii("AFTER", result.after, listener);
  say_registration(request.options.registration_error, result.after, listener);
  return result;
}

}  // namespace alidade::jobs
