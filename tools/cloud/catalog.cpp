// SPDX-License-Identifier: MIT
#include "cloud/catalog.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <algorithm>
#include <array>
#include <ctime>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/allowed_hosts.h"
#include "base/error.h"
#include "base/output_file.h"
#include "base/parallel.h"
#include "base/shown_text.h"
#include "base/words.h"
#include "cloud/cloud_reader.h"
#include "cloud/crs.h"
#include "geo/earth.h"
#include "geo/geopackage.h"
#include "geo/reproject.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"

namespace alidade::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct CatalogCommand : RunRequest {
  CloudInputs files;
  fs::path output;
  bool overwrite = false, measure = false;
};

/// What a catalog states of a file.
struct FileRow {
  std::string name;  ///< in the catalog: relative, or a URL
  bool is_url = false;
  std::string format;
  std::uint64_t point_count = 0, byte_count = 0;
  AttributeSet attributes;
  Bounds box;              ///< empty without points
  std::size_t system = 0;  ///< of Systems
  std::string created;     ///< "2019-05-02", or empty
  std::string modified;    ///< "2026-05-01T12:00:00Z"; empty of remote files
};

/// The reference systems of many files, each once.
class Systems {
 public:
  std::size_t number_of(const Crs& crs) {
    const std::lock_guard lock(mutex_);
    const auto known = std::ranges::find(all_, crs);
    if (known != all_.end()) return static_cast<std::size_t>(known - all_.begin());
    all_.push_back(crs);
    return all_.size() - 1;
  }
  const std::vector<Crs>& all() const { return all_; }

 private:
  std::mutex mutex_;
  std::vector<Crs> all_;
};

std::string time_text(std::time_t time) {
  std::tm parts{};
  ::gmtime_r(&time, &parts);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts)};
}

/// The name that a file gets in a catalog. Errors: a reader of the catalog would not find the file by a name.
std::string name_in_catalog(const fs::path& file, const fs::path& catalog) {
  const std::string name = file.string();
  if (name.starts_with("https://") || name.starts_with("http://")) return name;
  if (is_remote_name(name))
    throw file_error(name, "a catalog cannot list the file", "a local file, or https://");
  const auto relative_to = [&](const auto& full) {
    return full(file).lexically_relative(full(catalog).parent_path());
  };
  const auto leaves = [](const fs::path& path) { return path.empty() || *path.begin() == ".."; };
  fs::path relative = relative_to([](const fs::path& path) { return fs::absolute(path).lexically_normal(); });
  if (leaves(relative))
    relative = relative_to([](const fs::path& path) { return fs::weakly_canonical(path); });
  if (leaves(relative))
    throw file_error(name, "a catalog cannot list files outside of its folder",
                     "a catalog in the folder of its files or above", catalog.string());
  return relative.generic_string();
}

/// The box of the points themselves, and their number.
std::pair<Bounds, std::uint64_t> measured(CloudReader& reader) {
  if (!reader.lattice()) {
    const CoordinateSurvey survey =
        reader.survey([](std::uint64_t, std::uint64_t) { return !interrupted(); });
    return {survey.bounds, survey.finite_count};
  }
  constexpr std::uint64_t k_piece_bytes = std::uint64_t{64} << 20;
  std::pair<Bounds, std::uint64_t> all;
  PointCloud piece;
  piece.lattice = *reader.lattice();
  const CloudPieces pieces{.most_bytes = k_piece_bytes, .take = [&](PointCloud& part) {
                             all.first.grow(part.bounds());
                             all.second += part.size();
                             part.positions.clear();
                           }};
  reader.read_in_pieces(piece, AttributeSet(), pieces, {});
  pieces.take(piece);
  return all;
}

FileRow row_of(const CloudInput& input, const CatalogCommand& command, Systems& systems) {
  InputFile file = input.file();
  if (input.format != nullptr && input.format->is_named != nullptr)
    throw file_error(input.name, "a catalog cannot list the table of a database", "files");
  FileRow row;
  row.name = name_in_catalog(input.name, command.output);
  row.byte_count = file.size();
  row.is_url = is_remote_name(row.name);
  struct stat status {};
  if (!row.is_url && ::stat(input.name.c_str(), &status) == 0) row.modified = time_text(status.st_mtime);
  const std::unique_ptr<CloudReader> reader = open_cloud(input, std::move(file), Damage::reject);
  const FileFacts facts = reader->facts();
  row.format = reader->file().format;
  row.created = reader->file().created;
  row.attributes = reader->attributes();
  row.system = systems.number_of(facts.crs);
  row.point_count = reader->point_count().value_or(0);
  if (command.measure || !facts.box || !reader->point_count())
    std::tie(row.box, row.point_count) = measured(*reader);
  if (facts.box && row.point_count > 0) row.box.grow(*facts.box);
  return row;
}

std::vector<FileRow> read_rows(const CatalogCommand& command, Systems& systems) {
  std::vector<FileRow> rows(command.files.size());
  with_progress("reading", "files", command.verbosity, [&](const Progress& progress) {
    JoinedProgress joined(progress, rows.size());
    in_parallel(rows.size(), 1, k_most_files_at_once, [&](std::size_t i) {
      CloudInput input = command.files.inputs[i];
      input.stated = nullptr;  // of an earlier catalog
      rows[i] = row_of(input, command, systems);
      joined.add(1);
    });
  });
  return rows;
}

/// The outline of a box on the ground, counterclockwise, with the middles of its sides: they bend on the
/// globe.
std::array<glm::dvec3, 8> outline(const Bounds& box) {
  const glm::dvec3 &low = box.min, &high = box.max, middle = box.center();
  return {{{low.x, low.y, 0},
           {middle.x, low.y, 0},
           {high.x, low.y, 0},
           {high.x, middle.y, 0},
           {high.x, high.y, 0},
           {middle.x, high.y, 0},
           {low.x, high.y, 0},
           {low.x, middle.y, 0}}};
}

/// Longitudes and latitudes of the outlines of all files; none where they are unknown.
std::vector<std::vector<glm::dvec3>> outlines_on_globe(const std::vector<FileRow>& rows,
                                                       const std::vector<Crs>& systems) {
  std::vector<std::vector<glm::dvec3>> outlines(rows.size());
  for (std::size_t system = 0; system < systems.size(); ++system) {
    if (systems[system].empty()) continue;
    std::vector<std::size_t> files;
    std::vector<glm::dvec3> positions;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].system != system || rows[i].box.empty()) continue;
      files.push_back(i);
      std::ranges::copy(outline(rows[i].box), std::back_inserter(positions));
    }
    // All at once: to set up the transformation takes longer than to apply it.
    const auto moved = geo::lon_lat(systems[system], positions);
    for (std::size_t i = 0; i < files.size(); ++i) {
      const std::span<const glm::dvec3> own = std::span<const glm::dvec3>(positions).subspan(8 * i, 8);
      const auto alone = moved ? std::nullopt : geo::lon_lat(systems[system], own);
      if (moved)
        outlines[files[i]].assign(moved->begin() + 8 * static_cast<std::ptrdiff_t>(i),
                                  moved->begin() + 8 * static_cast<std::ptrdiff_t>(i + 1));
      if (alone) outlines[files[i]] = *alone;
    }
  }
  return outlines;
}

/// The properties of the projection extension that name a system: its code, else its definition.
Json projection_of(const Crs& crs) {
  const Json parsed = Json::parse(geo::projjson_of(crs), nullptr, false);
  if (!parsed.is_object()) return {{"proj:code", nullptr}};
  if (const auto id = parsed.find("id"); id != parsed.end() && id->is_object() && id->contains("code")) {
    const Json& code = id->at("code");
    return {{"proj:code", id->value("authority", "EPSG") + ":" +
                              (code.is_string() ? code.get<std::string>() : code.dump())}};
  }
  return {{"proj:code", nullptr}, {"proj:projjson", parsed}};
}

/// The dimensions of points, as the pointcloud extension lists them; extra dimensions are left out.
Json schemas_of(AttributeSet attributes) {
  struct Dimensions {
    AttributeSet attribute;
    std::vector<const char*> names;
    int size;
    const char* type;
  };
  static const std::vector<Dimensions> k_dimensions = {
      {{}, {"X", "Y", "Z"}, 8, "floating"},
      {Attribute::intensity, {"Intensity"}, 2, "unsigned"},
      {Attribute::returns, {"ReturnNumber", "NumberOfReturns"}, 1, "unsigned"},
      {Attribute::classification, {"Classification"}, 1, "unsigned"},
      {Attribute::scan_angle, {"ScanAngleRank"}, 4, "floating"},
      {Attribute::user_data, {"UserData"}, 1, "unsigned"},
      {Attribute::point_source_id, {"PointSourceId"}, 2, "unsigned"},
      {Attribute::gps_time, {"GpsTime"}, 8, "floating"},
      {Attribute::color, {"Red", "Green", "Blue"}, 2, "unsigned"},
      {Attribute::near_infrared, {"Infrared"}, 2, "unsigned"},
      {Attribute::normal, {"NormalX", "NormalY", "NormalZ"}, 4, "floating"}};
  Json schemas = Json::array();
  for (const Dimensions& dimensions : k_dimensions) {
    if ((dimensions.attribute.bits & ~attributes.bits) != 0) continue;
    for (const char* const name : dimensions.names)
      schemas.push_back({{"name", name}, {"size", dimensions.size}, {"type", dimensions.type}});
  }
  return schemas;
}

const char* media_type(const std::string& format) {
  if (format == "COPC") return "application/vnd.laszip+copc";
  if (format == "LAZ") return "application/vnd.laszip";
  return format == "LAS" ? "application/vnd.las" : "application/octet-stream";
}

Json item_of(const FileRow& row, std::span<const glm::dvec3> ring, const Json& projection) {
  Json item = {{"type", "Feature"},
               {"stac_version", "1.0.0"},
               {"stac_extensions",
                {"https://stac-extensions.github.io/pointcloud/v1.0.0/schema.json",
                 "https://stac-extensions.github.io/projection/v2.0.0/schema.json"}},
               {"id", row.name},
               {"geometry", nullptr}};
  if (!ring.empty()) {
    Bounds globe;
    Json corners = Json::array();
    for (const glm::dvec3& corner : ring) {
      globe.grow(corner);
      corners.push_back({corner.x, corner.y});
    }
    corners.push_back(corners.front());
    item["geometry"] = {{"type", "Polygon"}, {"coordinates", Json::array({corners})}};
    item["bbox"] = {globe.min.x, globe.min.y, globe.max.x, globe.max.y};
  }
  // STAC requires a date: the day of the scan if the file states one.
  const std::string date = row.created.empty() ? row.modified : row.created + "T00:00:00Z";
  Json properties = {{"datetime", date.empty() ? time_text(std::time(nullptr)) : date}};
  if (!row.modified.empty()) properties["updated"] = row.modified;
  properties.update({{"pc:count", row.point_count}, {"pc:type", "other"}, {"pc:encoding", row.format}});
  properties["pc:schemas"] = schemas_of(row.attributes);
  properties.update(projection);
  if (!row.box.empty()) {
    const glm::dvec3 &low = row.box.min, &high = row.box.max;
    properties["proj:bbox"] = {low.x, low.y, low.z, high.x, high.y, high.z};
  }
  item["properties"] = std::move(properties);
  item["links"] = Json::array();
  item["assets"]["data"] = {{"href", row.is_url ? row.name : href_of(row.name)},
                            {"type", media_type(row.format)},
                            {"roles", {"data"}},
                            {"file:size", row.byte_count}};
  return item;
}

void write_json(const CatalogCommand& command, const std::vector<FileRow>& rows,
                const std::vector<Crs>& systems) {
  const auto outlines = outlines_on_globe(rows, systems);
  std::vector<Json> projections;
  for (const Crs& crs : systems) projections.push_back(projection_of(crs));
  OutputFile file(command.output, command.overwrite);
  file.write("{\"type\":\"FeatureCollection\",\"features\":[");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (interrupted()) throw Cancelled();
    file.write(i == 0 ? "\n" : ",\n");
    file.write(json_text(item_of(rows[i], outlines[i], projections[rows[i].system])));
  }
  file.write("\n]}\n");
  file.commit();
}

void write_footprints(const CatalogCommand& command, const std::vector<FileRow>& rows,
                      const std::vector<Crs>& systems) {
  for (const FileRow& row : rows) {
    const Crs &first = systems[rows.front().system], &own = systems[row.system];
    if (!first.empty() && !own.empty() && compare_crs(first, own) == CrsAgreement::different)
      throw file_error(row.name, "a GeoPackage of files of different reference systems",
                       crs_name(first) + ", or a .catalog.json", crs_name(own));
  }
  using geo::ColumnType;
  geo::VectorLayer layer{.name = "footprints",
                         .description = "Boxes of point clouds",
                         .shape = geo::LayerShape::polygons,
                         .columns = {{"file", ColumnType::text},
                                     {"format", ColumnType::text},
                                     {"points", ColumnType::whole_number},
                                     {"z_min", ColumnType::number},
                                     {"z_max", ColumnType::number},
                                     {"bytes", ColumnType::whole_number},
                                     {"modified", ColumnType::text}},
                         .features = {}};
  for (const FileRow& row : rows) {
    std::vector<PlanePolygon> polygons;
    geo::VectorValue low, high;
    if (!row.box.empty()) {
      low = row.box.min.z;
      high = row.box.max.z;
      std::vector<glm::dvec2> ring;
      for (std::size_t i = 0; i < 8; i += 2) ring.emplace_back(outline(row.box)[i]);
      polygons.push_back({{ring}});
    }
    layer.features.push_back({polygons,
                              {row.name, row.format, static_cast<std::int64_t>(row.point_count), low, high,
                               static_cast<std::int64_t>(row.byte_count),
                               row.modified.empty() ? geo::VectorValue() : row.modified}});
  }
  geo::write_geopackage(command.output, {layer}, systems[rows.front().system], command.overwrite);
}

ExitCode run(const CatalogCommand& command) {
  const bool is_geopackage = has_extension(command.output, {".gpkg"});
  if (!is_geopackage && !lower_case(command.output.string()).ends_with(".catalog.json"))
    throw file_error(command.output, "unknown output format", "the extension .catalog.json or .gpkg");
  check_writable(command.output, command.overwrite);
  Systems systems;
  const std::vector<FileRow> rows = read_rows(command, systems);
  (is_geopackage ? write_footprints : write_json)(command, rows, systems.all());
  std::uint64_t points = 0;
  for (const FileRow& row : rows) points += row.point_count;
  const auto unknown =
      std::ranges::count_if(rows, [&](const FileRow& row) { return systems.all()[row.system].empty(); });
  if (unknown > 0 && command.verbosity != Verbosity::quiet)
    say_warning(fmt::format("{} of {} files state no reference system; they have no position on the globe",
                            unknown, rows.size()));
  say_note(command.verbosity, fmt::format("{} file{}, {} points in {}", rows.size(),
                                          rows.size() == 1 ? "" : "s", points, command.output.string()));
  std::set<std::string> hosts;
  for (const FileRow& row : rows)
    if (row.is_url && !is_geopackage) hosts.insert(host_of(row.name));
  if (!hosts.empty())
    say_note(command.verbosity,
             fmt::format("reading the catalog requires --allow-host {}", fmt::join(hosts, " --allow-host ")));
  return ExitCode::done;
}

}  // namespace

Command add_catalog(const Options& program) {
  auto command = std::make_shared<CatalogCommand>();
  const Options catalog =
      program.command("catalog", "List many clouds with their bounds, so that few need be opened");
  add_remote_fields(catalog);  // before the files, whose names are resolved as they are read
  catalog.required().words(
      "cloud", "CLOUD...",
      "cloud files, folders or patterns such as 'tiles/*.copc.laz', or an earlier catalog",
      [command](const std::vector<std::string>& words) {
        command->files = resolve_clouds(std::vector<fs::path>(words.begin(), words.end()), cloud_formats());
      });
  catalog.required().file("-o,--output", "FILE",
                          "output file: .catalog.json, which is a cloud for all other commands, or .gpkg, a "
                          "map of the footprints",
                          command->output);
  catalog.flag("--measure", "read the points of all files; otherwise plausible boxes in headers are believed",
               command->measure);
  catalog.flag("--overwrite", "replace an existing file", command->overwrite);
  add_threads(catalog, command->threads);
  add_verbosity(catalog, command->verbosity);
  return command_of(catalog, command, run);
}

}  // namespace alidade::tools
