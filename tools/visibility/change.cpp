// SPDX-License-Identifier: MIT
#include "visibility/change/change.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "jobs/write_points.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/view_options.h"
#include "tools/visibility/visibility_request.h"
#include "visibility/read_observers.h"

namespace alidade::tools {
namespace {

using nlohmann::json;
using visibility::ChangeClass;
using visibility::ChangeSummary;

/// The options of one of the two epochs.
struct EpochRequest {
  const char* name;          ///< "BEFORE"
  const char* option;        ///< "--origin-before"
  const char* files_option;  ///< "--origins-before"
  CloudInputs files;
  std::vector<glm::dvec3> origins;
  std::filesystem::path origins_file;
};

struct ChangeCommand : RunRequest {
  EpochRequest before{"BEFORE", "--origin-before", "--origins-before", {}, {}, {}};
  EpochRequest after{"AFTER", "--origin-after", "--origins-after", {}, {}, {}};
  visibility::ChangeOptions options;
  std::bitset<256> ignored_classes = std::bitset<256>{}.set(7).set(18);
  std::filesystem::path output;
  std::optional<std::size_t> memory;  ///< of scratch_beside() the output
  bool no_sight = false, overwrite = false, json = false;
};

/// An epoch in memory. `columns` are of `cloud`, which therefore must not move.
struct EpochCloud {
  IndexedCloud cloud;
  AttributeColumns columns;
  std::vector<glm::dvec3> origins;
  std::optional<visibility::Occluders> occluders;  ///< empty until they are measured
};

void check_options(const ChangeCommand& command) {
  check_points_name(command.output);
  std::vector<std::filesystem::path> inputs{command.before.origins_file, command.after.origins_file};
  for (const EpochRequest* epoch : {&command.before, &command.after}) {
    const std::vector<std::filesystem::path> names = epoch->files.names();
    inputs.insert(inputs.end(), names.begin(), names.end());
  }
  check_writable(command.output, command.overwrite, inputs);
}

glm::dvec3 parse_position(const std::string& text) {
  const std::vector<std::string> words = split_list(text, 3, "X,Y,Z");
  return {parse_number(words[0]), parse_number(words[1]), parse_number(words[2])};
}

std::vector<glm::dvec3> origins_of(const EpochRequest& request, const PointCloud& cloud) {
  std::vector<glm::dvec3> origins = request.origins;
  if (!request.origins_file.empty()) {
    const geo::ObserverReference reference{
        .cloud = cloud.crs, .option = request.files_option, .whose = "scanner positions"};
    for (const visibility::GivenObserver& one : visibility::read_observers(request.origins_file, reference)) {
      if (!one.z) throw file_error(one.source, "a scanner position has no height", "x, y and z");
      origins.emplace_back(one.position, *one.z + one.height.value_or(0.0));
    }
  }
  if (origins.empty())
    for (const ScannerPosition& scanner : cloud.scanner_positions)
      if (!scanner.axes) origins.push_back(scanner.position);  // a depth camera has not seen all around it
  return origins;
}

std::unique_ptr<EpochCloud> load_epoch(const ChangeCommand& command, const EpochRequest& request) {
  CloudRequest one;
  static_cast<RunRequest&>(one) = command;
  one.files = request.files;
  auto epoch = std::make_unique<EpochCloud>();
  epoch->cloud = load_shown(one, {.scratch = scratch_beside(command.output, command.memory)});
  if (epoch->cloud.octree.size() == 0)
    throw file_error(request.files.first_name(), "the cloud has no points");
  check_map_unit(epoch->cloud.cloud.crs, request.files);
  epoch->columns = epoch->cloud.columns();
  epoch->origins = origins_of(request, epoch->cloud.cloud);
  if (epoch->origins.empty() && !command.no_sight) {
    throw file_error(
        request.files.first_name(),
        fmt::format("unknown scanner positions: what is {} cannot be distinguished from what was never seen",
                    &request == &command.before ? "new" : "gone"),
        fmt::format("{} X,Y,Z, {} FILE, an E57, PTX or PCD file with poses, or --no-sight", request.option,
                    request.files_option));
  }
  if (!epoch->origins.empty())
    say_note(command.verbosity, fmt::format("{}: {} points, {} scanner position(s)", request.name,
                                            epoch->cloud.octree.size(), epoch->origins.size()));
  return epoch;
}

/// Errors: both systems are known and differ; only one is, and its heights are converted.
void check_same_system(const ChangeCommand& command, const EpochCloud& before, const EpochCloud& after) {
  const Crs &old_crs = before.cloud.cloud.crs, &new_crs = after.cloud.cloud.crs;
  const EpochRequest& other = old_crs.empty() ? command.before : command.after;
  const EpochRequest& stated = old_crs.empty() ? command.after : command.before;
  if (old_crs == new_crs) return;
  if (old_crs.empty() || new_crs.empty()) {
    if (std::ranges::any_of(stated.files.inputs, &CloudInput::changes_heights))
      throw file_error(
          other.files.first_name(),
          fmt::format("no reference system, and the heights of {} are converted to the unit of x and y",
                      stated.name),
          "--crs EPSG:n, which states one");
    say_warnings(
        command.verbosity,
        {fmt::format("only {} states a reference system; that of the other is assumed to be the same",
                     stated.name)});
    return;
  }
  const CrsAgreement agreement = compare_crs(old_crs, new_crs);
  if (agreement == CrsAgreement::different)
    throw file_error(other.files.first_name(), "AFTER is in another reference system than BEFORE",
                     crs_name(old_crs) + ": --reproject SYSTEM brings both to one", crs_name(new_crs));
  if (agreement == CrsAgreement::unknown)
    say_warnings(command.verbosity,
                 {fmt::format("BEFORE is in {}, AFTER in {}; both are assumed to be the same",
                              crs_name(old_crs), crs_name(new_crs))});
}

void measure(const ChangeCommand& command, EpochCloud& epoch, Console& console) {
  epoch.occluders = measured_occluders(epoch.cloud.octree, epoch.columns.classifications,
                                       command.ignored_classes, {}, console);
}

/// `changes` must outlive the columns.
std::vector<ResultColumn> columns_of(const visibility::PointChanges& changes, std::uint8_t number) {
  std::vector<ResultColumn> columns;
  columns.push_back(result_column<std::uint8_t>("Epoch", "1: BEFORE, 2: AFTER", ScalarType::uint8,
                                                [number](std::size_t) { return number; }));
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

/// One epoch, for the table.
struct Summaries {
  const visibility::PointChanges& changes;
  std::vector<ChangeSummary> classes;

  Summaries(const visibility::PointChanges& found, const EpochCloud& epoch)
      : changes(found), classes(summaries_of(found, *epoch.occluders)) {}

  const ChangeSummary& of(ChangeClass kind) const { return classes[static_cast<std::size_t>(kind)]; }
  std::uint64_t points() const { return changes.classes.size(); }
};

std::string table_of(const char* epoch, const Summaries& all) {
  const auto length = [](const std::optional<double>& value) {
    const std::string text = value ? fmt::format("{:.4f}", *value) : "-";
    return text == "-0.0000" ? text.substr(1) : text;
  };
  std::string text =
      fmt::format("{:<18}{:>12}{:>9}{:>14}{:>16}{:>18}{:>20}{:>16}\n", epoch, "points", "share", "area",
                  "with distance", "median distance", "median |distance|", "median LoD95");
  for (std::size_t kind = 0; kind < all.classes.size(); ++kind) {
    const ChangeSummary& one = all.classes[kind];
    if (one.count == 0) continue;
    const double share = 100.0 * static_cast<double>(one.count) / static_cast<double>(all.points());
    text += fmt::format("{:<18}{:>12}{:>8.2f}%{:>14.2f}{:>16}{:>18}{:>20}{:>16}\n",
                        name_of(static_cast<ChangeClass>(kind)), one.count, share, one.area, one.measured,
                        length(one.median_distance), length(one.median_absolute_distance),
                        length(one.median_detection_level));
  }
  const auto reason = [&](const char* name, std::uint64_t count) {
    if (count > 0) text += fmt::format("  {:<16}{:>12}\n", name, count);
  };
  reason("no normal", all.changes.without_normal);
  reason("too few points", all.changes.too_few_points);
  return text;
}

json json_of(const Summaries& all) {
  const auto length = [](const std::optional<double>& value) { return value ? json(*value) : json(); };
  json classes = json::object();
  for (std::size_t kind = 0; kind < all.classes.size(); ++kind) {
    const ChangeSummary& one = all.classes[kind];
    classes[name_of(static_cast<ChangeClass>(kind))] = {
        {"code", kind},
        {"points", one.count},
        {"area", one.area},
        {"with_distance", one.measured},
        {"median_distance", length(one.median_distance)},
        {"median_absolute_distance", length(one.median_absolute_distance)},
        {"median_lod95", length(one.median_detection_level)}};
  }
  json& unmeasured = classes[name_of(ChangeClass::not_measured)];
  unmeasured["no_normal"] = all.changes.without_normal;
  unmeasured["too_few_points"] = all.changes.too_few_points;
  return {{"points", all.points()}, {"classes", classes}};
}

/// Warns of radii that are too small for a cloud.
void say_radii(const ChangeCommand& command, const char* epoch, const Summaries& all) {
  std::vector<std::string> warnings;
  if (all.changes.wider_normals > 0) {
    warnings.push_back(
        fmt::format("{}: --normal-radius holds too few points for a normal at {} of {} points; their normals "
                    "come from 2.5 times the distance to the 8th neighbour",
                    epoch, all.changes.wider_normals, all.points()));
  }
  if (const std::uint64_t count = all.of(ChangeClass::not_measured).count; 2 * count > all.points()) {
    warnings.push_back(
        fmt::format("{}: {} of {} points are not measured: {} have no normal (--normal-radius), {} too few "
                    "points in their cylinder (--cylinder-radius, --max-distance)",
                    epoch, count, all.points(), all.changes.without_normal, all.changes.too_few_points));
  }
  say_warnings(command.verbosity, warnings);
}

/// Warns if most of what is compared has moved by more than its level of detection, without a registration
/// error.
void say_registration(const ChangeCommand& command, const Summaries& all) {
  const ChangeSummary &same = all.of(ChangeClass::same), &moved = all.of(ChangeClass::moved);
  if (command.options.registration_error > 0.0 || moved.count <= same.count) return;
  say_warnings(
      command.verbosity,
      {fmt::format("most surfaces have moved, half of them by less than {:.4f}; if that is the accuracy of "
                   "the registration, pass it as --registration-error",
                   *moved.median_absolute_distance)});
}

ExitCode run(const ChangeCommand& command) {
  check_options(command);
  const auto before = load_epoch(command, command.before);
  const auto after = load_epoch(command, command.after);
  check_same_system(command, *before, *after);
  visibility::check_overlap(before->cloud.octree, after->cloud.octree);
  Console console(command.verbosity);
  measure(command, *before, console);
  measure(command, *after, console);
  visibility::ChangeOptions options = command.options;
  const visibility::Changes changes =
      with_progress("comparing", "points", command.verbosity, [&](const Progress& progress) {
        options.progress = progress;
        return visibility::find_changes({*before->occluders, before->origins},
                                        {*after->occluders, after->origins}, options);
      });
  const Summaries old_classes(changes.before, *before), new_classes(changes.after, *after);
  const CloudResults results[] = {{before->cloud, columns_of(changes.before, 1)},
                                  {after->cloud, columns_of(changes.after, 2)}};
  write_points(command.output, results, command.overwrite, command.memory, console);
  write_to_stdout(command.json
                      ? json{{"before", json_of(old_classes)}, {"after", json_of(new_classes)}}.dump(2) + "\n"
                      : table_of("BEFORE", old_classes) + "\n" + table_of("AFTER", new_classes));
  say_radii(command, "BEFORE", old_classes);
  say_radii(command, "AFTER", new_classes);
  say_registration(command, new_classes);
  return ExitCode::done;
}

void add_epoch(const Fields& change, const char* operand, EpochRequest& epoch,
               const std::shared_ptr<ViewRequest>& view) {
  change.required().value(
      operand, epoch.name,
      std::string(
          "the cloud of this epoch: a file, a folder, a quoted pattern such as 'tiles/*.las', an index file "
          "(.alidade)") +
          k_database_help,
      [&epoch, view](const std::string& text) {
        epoch.files = view->apply(resolve_clouds(std::vector<std::filesystem::path>{text}, cloud_formats()));
      });
}

void add_origins(const Fields& change, EpochRequest& epoch) {
  const Fields group = change.group("Scanner positions");
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

void add_distances(const Fields& change, ChangeCommand& command) {
  const Fields group = change.group("Distances");
  group.number("--registration-error", "LENGTH",
               "standard deviation of the offset between both clouds, in metres (default: 0)",
               command.options.registration_error, 0.0, 1e6);
  group.number(
      "--normal-radius", "LENGTH",
      "radius of the sphere whose points define the normal, in metres (default, and where it holds too few "
      "points: per point, 2.5 times the distance to its 8th neighbour, or less at edges)",
      command.options.normal_radius, 1e-6, 1e6);
  group.number(
      "--cylinder-radius", "LENGTH",
      "radius of the cylinder along the normal whose points are averaged, in metres; both clouds need 4 "
      "points in it (default: per point, twice the distance to the 8th neighbour in the sparser cloud)",
      command.options.cylinder_radius, 1e-6, 1e6);
  group.number(
      "--max-distance", "LENGTH",
      "half length of the cylinder, in metres: a surface farther along the normal is another one (default: "
      "3 radii of the cylinder)",
      command.options.max_distance, 1e-6, 1e6);
}

}  // namespace

Command add_change(const Options& program) {
  auto command = std::make_shared<ChangeCommand>();
  const Options change =
      program.command("change", "Find what has moved, gone or come between two scans, or was never seen");
  const auto view = add_view_options(change, {"--ignore-classes"});
  add_epoch(change, "before", command->before, view);
  add_epoch(change, "after", command->after, view);
  change.required().file("-o,--output", "FILE.las|FILE.laz|FILE.ply",
                         "output: the points of both epochs, as LAS 1.4, LAZ or PLY, by the extension",
                         command->output);
  add_origins(change, command->before);
  add_origins(change, command->after);
  const Fields sight = change.group("Scanner positions");
  sight.flag(
      "--no-sight",
      "accept unknown scanner positions: points without a counterpart in that epoch are unmatched, not gone, "
      "new or never seen",
      command->no_sight);
  sight.number(
      "--max-range", "LENGTH",
      "range of the scanners, in metres: lines of sight do not pass anything farther away (default: inf)",
      command->options.max_range, 1e-6, 1e9);
  add_distances(change, *command);
  add_ignored_classes(change, "are not compared", command->ignored_classes);
  change.flag("--json", "print JSON instead of a table; the keys are below", command->json);
  change.flag("--overwrite", "replace an existing output", command->overwrite);
  add_scratch_memory(change, command->memory);
  add_run_options(change, *command);
  return command_of(change, command, run);
}

}  // namespace alidade::tools
