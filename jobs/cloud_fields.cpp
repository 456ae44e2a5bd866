// SPDX-License-Identifier: MIT
#include "jobs/cloud_fields.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>
#include <algorithm>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/words.h"
#include "cloud/cloud_reader.h"
#include "database/sqlite/where_clause.h"
#include "geo/reproject.h"
#include "geo/vector_file.h"
#include "jobs/cloud_formats.h"
#include "jobs/load_cloud.h"
#include "jobs/remote_files.h"

namespace alidade::jobs {

/// The reference systems of a CloudView.
struct SystemChoice {
  std::string stated;               ///< --crs
  std::string wanted;               ///< --reproject; "auto": the zone
  std::string zone;                 ///< UTM zone of the first cloud; empty until a cloud is opened for "auto"
  std::optional<CloudInput> first;  ///< of the first apply(), without its view
  std::once_flag is_zone_chosen;
};

namespace {

/// Whether a text is a box; one with commas that names a file is not.
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
  const int axes = numbers.size() == 4 ? 2 : 3;
  Bounds box{glm::dvec3(std::numeric_limits<double>::lowest()),
             glm::dvec3(std::numeric_limits<double>::max())};
  for (int axis = 0; axis < axes; ++axis) {
    box.min[axis] = numbers[static_cast<std::size_t>(axis)];
    box.max[axis] = numbers[static_cast<std::size_t>(axes + axis)];
    if (box.min[axis] > box.max[axis]) {
      throw UsageError(
          fmt::format("limits out of order; expected the lower {0} first, found {0} from {1} to {2}",
                      "xyz"[axis], box.min[axis], box.max[axis]));
    }
  }
  return box;
}

/// Reads the polygons of a file once for each reference system of the clouds. Safe to use from many threads,
/// which open the clouds.
struct PolygonFile {
  std::filesystem::path file;
  std::string given_system;  ///< --crop-crs, as ObserverReference::given
  std::mutex mutex;          ///< of by_system
  std::vector<std::pair<Crs, std::vector<PlanePolygon>>> by_system;

  std::vector<PlanePolygon> polygons_in(const Crs& crs) {
    const std::scoped_lock lock(mutex);
    const auto found = std::ranges::find(by_system, crs, &std::pair<Crs, std::vector<PlanePolygon>>::first);
    if (found != by_system.end()) return found->second;
    by_system.emplace_back(
        crs, geo::read_polygons(
                 file, {.given = given_system, .cloud = crs, .option = "--crop-crs", .whose = "polygons"}));
    return by_system.back().second;
  }
};

void take_crop(const std::string& text, PointSelection& selection,
               const std::shared_ptr<PolygonFile>& polygons) {
  if (text.empty()) throw UsageError("missing value; expected a box or a file");
  selection.box = is_box(text) ? std::optional(parse_box(text)) : std::nullopt;
  selection.polygons = nullptr;
  if (selection.box) return;
  polygons->file = text;
  std::error_code error;
  if (!std::filesystem::is_regular_file(text, error))
    throw file_error(text, "not a file", "x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1 or a polygon file");
  selection.polygons = [polygons](const Crs& crs) { return polygons->polygons_in(crs); };
}

void add_crop(const Fields& group, PointSelection& selection) {
  const auto polygons = std::make_shared<PolygonFile>();
  const Field crop =
      group.value("--crop", "BOX|FILE",
                  "only points in the box x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1, in the cloud's unit, mostly "
                  "metres, or in the polygons of a GeoJSON, GeoPackage or Shapefile; the border is included",
                  [&selection, polygons](const std::string& text) { take_crop(text, selection, polygons); });
  group.needs(crop).value(
      "--crop-crs", "SYSTEM",
      "reference system of the polygons, such as EPSG:4326, overriding their file; 'cloud' for the cloud's",
      [&selection, polygons](const std::string& text) {
        if (selection.box) throw UsageError("requires a polygon file; expected --crop FILE, found a box");
        polygons->given_system = text;
      });
}

void take_condition(const std::string& text, const std::function<bool()>& stops, PointSelection& selection) {
  try {
    const auto clause = std::make_shared<database::WhereClause>(text);
    selection.condition = [clause, stops](const PointCloud& rows, std::span<std::uint8_t> marks) {
      clause->mark(rows, marks, stops);
    };
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
}

/// Sets the zone of UTM in which the middle of the first cloud lies. Errors: that location is unknown.
void choose_zone(SystemChoice& systems) {
  const CloudInput& cloud = *systems.first;
  const std::unique_ptr<CloudReader> reader = open_stored_cloud(cloud, Damage::read_over);
  const FileFacts& facts = reader->facts();
  Bounds box = facts.box.value_or(Bounds());
  if (box.empty() && !facts.lattice) box = reader->survey({}).bounds;
  if (box.empty())
    throw file_error(cloud.name, "cannot choose a zone of UTM: the file does not state its bounds",
                     "--reproject EPSG:n");
  const Crs crs = geo::change_reference({.stated = systems.stated}, cloud.name, facts).crs;
  systems.zone = geo::metric_system(crs, box.center(), cloud.name);
}

/// Declares --crs, --reproject and --vertical-unit.
void add_systems(const Fields& group, const CloudView& target, HeightUse height_use) {
  // The view holds the function: a shared pointer to it would keep it alive for ever.
  InputView* const view = target.view.get();
  const auto change_reference = [view, systems = target.systems](const std::filesystem::path& file,
                                                                 const FileFacts& facts) {
    const bool is_automatic = systems->wanted == "auto";
    // Isolated: a thread that waits inside must not start to open another file, which would wait for
    // call_once.
    if (is_automatic)
      tbb::this_task_arena::isolate(
          [&] { std::call_once(systems->is_zone_chosen, choose_zone, std::ref(*systems)); });
    return geo::change_reference({systems->stated, is_automatic ? systems->zone : systems->wanted,
                                  view->height_unit, view->has_one_unit},
                                 file, facts);
  };
  const auto take = [view, change_reference](std::string& system) {
    return [&system, view, change_reference](const std::string& text) {
      system = text;
      view->change_reference = change_reference;
    };
  };
  group.value(
      "--crs", "SYSTEM",
      "reference system of clouds that state none or a wrong one, such as EPSG:25832 or the name of a "
      "file with WKT",
      take(target.systems->stated));
  const Field reproject = group.value(
      "--reproject", "SYSTEM|auto",
      "bring the points to another reference system, such as EPSG:25832; auto: from degrees or "
      "geocentric coordinates to the zone of UTM of the first cloud; heights get the unit of the system",
      take(target.systems->wanted));
  (height_use == HeightUse::measured ? group : group.needs(reproject))
      .choice(
          "--vertical-unit",
          "unit of the heights of clouds that state none: metres, feet or US survey feet (default: that of x "
          "and y); heights are converted to the unit of x and y",
          view->height_unit, {{"m", k_metre}, {"ft", k_foot}, {"us-ft", k_survey_foot}});
}

}  // namespace

CloudInputs CloudView::apply(CloudInputs clouds) const {
  if (!systems->first && !clouds.empty()) systems->first = clouds.inputs.front();
  for (CloudInput& input : clouds.inputs) input.view = view;
  return clouds;
}

CloudView add_view_fields(const Fields& fields, std::initializer_list<std::string_view> own,
                          HeightUse height_use) {
  const CloudView target{std::make_shared<InputView>(), std::make_shared<SystemChoice>()};
  PointSelection& selection = target.view->selection;
  target.view->has_one_unit = height_use == HeightUse::measured;
  const auto is_own = [&](std::string_view name) { return std::ranges::find(own, name) != own.end(); };
  const Fields group = fields.group("Which points, in which reference system");
  const auto restrict_classes = [&selection](const std::bitset<256>& classes) {
    selection.classes = selection.classes.value_or(std::bitset<256>().set()) & classes;
  };
  if (!is_own("--classes"))
    group.value("--classes", "LIST", "only points of these classes, such as 2,6",
                [restrict_classes](const std::string& text) { restrict_classes(parse_classes(text)); });
  if (!is_own("--ignore-classes"))
    group.value("--ignore-classes", "LIST", "no points of these classes, such as 7,18 (noise)",
                [restrict_classes](const std::string& text) { restrict_classes(~parse_classes(text)); });
  group.value("--where", "CONDITION",
              "only points for which a condition of SQL holds, such as \"classification = 2 AND intensity > "
              "100\"; columns are x, y, z and those that 'alidade sql' has: see docs/convert.md",
              [&selection, stops = fields.stops()](const std::string& text) {
                take_condition(text, stops, selection);
              });
  add_crop(group, selection);
  group.value("--columns", "NAMES",
              "titles of the columns of text files that have none, such as x,y,z,intensity,gps_time or "
              "\"x [ft],y [ft],z [ft]\"; other names are extra dimensions",
              [view = target.view.get()](const std::string& text) { view->columns = split_list(text); });
  add_systems(group, target, height_use);
  add_remote_fields(fields);
  return target;
}

std::string database_help() {
  std::string help = "; or a table of a database: site.db?table=NAME";
  for (const AddedFormat& added : added_formats()) {
    if (added.format != nullptr && added.make_store != nullptr) help += " or " + added.make_store()->form();
  }
  return help;
}

Field add_cloud_files(const Fields& fields, const std::string& name, const std::string& kind,
                      const std::string& help, CloudInputs& clouds, const CloudView& view) {
  return fields.words(name, kind, help, [&clouds, view](const std::vector<std::string>& words) {
    clouds = view.apply(
        resolve_clouds(std::vector<std::filesystem::path>(words.begin(), words.end()), cloud_formats()));
  });
}

void add_cloud(const Fields& fields, CloudInputs& files, std::initializer_list<std::string_view> own) {
  const CloudView view = add_view_fields(fields, own);
  add_cloud_files(fields.required(), "cloud", "CLOUD...",
                  k_files_help + ", a catalog of files (.catalog.json), an index file (.alidade), " +
                      database_help().substr(2),
                  files, view);
}

Field add_partial(const Fields& fields, bool& partial) {
  return fields.flag(
      "--partial", "read the intact part of damaged files and report what is lost; otherwise they are errors",
      partial);
}

}  // namespace alidade::jobs
