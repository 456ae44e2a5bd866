// SPDX-License-Identifier: MIT
#include "jobs/clouds/catalog.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <chrono>
#include <mutex>
#include <set>
#include <tuple>
#include <utility>

#include "base/allowed_hosts.h"
#include "base/date_time.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/words.h"
#include "cloud/cloud_reader.h"
#include "cloud/crs.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"
#include "jobs/remote_files.h"

namespace alidade::jobs {
namespace {

namespace fs = std::filesystem;

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

/// Whole seconds.
std::string time_text(std::chrono::system_clock::time_point time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time - day);
  return date_time_text({day, static_cast<double>(seconds.count())});
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
std::pair<Bounds, std::uint64_t> measure_points(CloudReader& reader, const Listener& listener) {
  const std::optional<Lattice>& lattice = reader.facts().lattice;
  if (!lattice) {
    const CoordinateSurvey survey =
        reader.survey([&](std::uint64_t, std::uint64_t) { return !listener.stops(); });
    return {survey.bounds, survey.finite_count};
  }
  constexpr std::uint64_t k_piece_bytes = std::uint64_t{64} << 20;
  std::pair<Bounds, std::uint64_t> all;
  PointCloud piece;
  piece.lattice = *lattice;
  const CloudPieces pieces{.most_bytes = k_piece_bytes, .take = [&](PointCloud& part) {
                             all.first.grow(part.bounds());
                             all.second += part.size();
                             part.positions.clear();
                           }};
  reader.read(piece, AttributeSet(), pieces, {});
  pieces.take(piece);
  return all;
}

geo::CatalogFile row_of(const CloudInput& input, const CatalogRequest& request, Systems& systems,
                        const Listener& listener) {
  if (input.format != nullptr && input.format->is_named != nullptr)
    throw file_error(input.name, "a catalog cannot list the table of a database", "files");
  geo::CatalogFile row;
  row.name = name_in_catalog(input.name, request.output);
  row.is_url = is_remote_name(row.name);
  std::error_code error;
  const fs::file_time_type changed = fs::last_write_time(input.name, error);
  if (!row.is_url && !error) row.modified = time_text(std::chrono::file_clock::to_sys(changed));
  const std::unique_ptr<CloudReader> reader = open_cloud(input, Damage::reject);
  const FileFacts& facts = reader->facts();
  row.byte_count = facts.bytes;
  row.format = facts.file.format;
  const std::string& scanned = facts.file.created;
  row.date = !scanned.empty()       ? scanned + "T00:00:00Z"
             : row.modified.empty() ? time_text(std::chrono::system_clock::now())
                                    : row.modified;
  row.attributes = facts.attributes;
  row.system = systems.number_of(facts.crs);
  row.point_count = facts.point_count.value_or(0);
  if (request.measure || !facts.box || !facts.point_count)
    std::tie(row.box, row.point_count) = measure_points(*reader, listener);
  if (facts.box && row.point_count > 0) row.box.grow(*facts.box);
  return row;
}

std::vector<geo::CatalogFile> read_rows(const CatalogRequest& request, Systems& systems, Listener& listener) {
  std::vector<geo::CatalogFile> rows(request.files.size());
  in_stage(listener, "reading", "files", [&](const Progress& progress) {
    JoinedProgress joined(progress, rows.size());
    in_parallel(rows.size(), 1, k_most_files_at_once, [&](std::size_t i) {
      CloudInput input = request.files.inputs[i];
      input.stated = nullptr;  // of an earlier catalog
      rows[i] = row_of(input, request, systems, listener);
      joined.add(1);
    });
  });
  return rows;
}

bool is_geopackage(const fs::path& output) {
  return has_extension(output, {".gpkg"});
}

/// What the catalog has, and what it lacks.
void say_catalog(const CatalogRequest& request, const CatalogResult& catalog, Listener& listener) {
  std::uint64_t points = 0;
  std::size_t unknown = 0;
  std::set<std::string> hosts;
  for (const geo::CatalogFile& row : catalog.files) {
    points += row.point_count;
    if (catalog.systems[row.system].empty()) ++unknown;
    if (row.is_url && !is_geopackage(request.output)) hosts.insert(host_of(row.name));
  }
  if (unknown > 0)
    listener.warn(fmt::format("{} of {} files state no reference system; they have no position on the globe",
                              unknown, catalog.files.size()));
  listener.note(fmt::format("{} file{}, {} points in {}", catalog.files.size(),
                            catalog.files.size() == 1 ? "" : "s", points, request.output.string()));
  if (!hosts.empty())
    listener.note(
        fmt::format("reading the catalog requires --allow-host {}", fmt::join(hosts, " --allow-host ")));
}

}  // namespace

void add_catalog_fields(const Fields& fields, CatalogRequest& request) {
  add_remote_fields(fields);  // before the files, whose names are resolved as they are read
  fields.required().words(
      "cloud", "CLOUD...",
      "cloud files, folders or patterns such as 'tiles/*.copc.laz', or an earlier catalog",
      [&request](const std::vector<std::string>& words) {
        request.files = resolve_clouds(std::vector<fs::path>(words.begin(), words.end()), cloud_formats());
      });
  fields.required().file("-o,--output", "FILE",
                         "output file: .catalog.json, which is a cloud for all other commands, or .gpkg, a "
                         "map of the footprints",
                         request.output);
  fields.flag("--measure", "read the points of all files; otherwise plausible boxes in headers are believed",
              request.measure);
  fields.flag("--overwrite", "replace an existing file", request.overwrite);
}

CatalogPlan plan(const CatalogRequest& request) {
  if (!is_geopackage(request.output) && !lower_case(request.output.string()).ends_with(".catalog.json"))
    throw file_error(request.output, "unknown output format", "the extension .catalog.json or .gpkg");
  check_writable(request.output, request.overwrite);
  return CatalogPlan(request, {.clouds = request.files, .writes = {request.output}});
}

CatalogResult run(const CatalogPlan& plan, Listener& listener) {
  const CatalogRequest& request = plan.request();
  Systems systems;
  CatalogResult catalog{.files = read_rows(request, systems, listener), .systems = {}};
  catalog.systems = systems.all();
  if (is_geopackage(request.output))
    geo::write_footprints(request.output, catalog.files, catalog.systems, request.overwrite);
  else
    geo::write_catalog(request.output, catalog.files, catalog.systems, request.overwrite,
                       [&](std::uint64_t, std::uint64_t) { return !listener.stops(); });
  say_catalog(request, catalog, listener);
  return catalog;
}

}  // namespace alidade::jobs
