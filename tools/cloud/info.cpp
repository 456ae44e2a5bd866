// SPDX-License-Identifier: MIT
// The table of `alidade info`.
#include "jobs/clouds/info.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/shown_text.h"
#include "cloud/axis_units.h"
#include "cloud/crs.h"
#include "image/color_points.h"
#include "image/point_color.h"
#include "octree/index_file/index_header.h"
#include "tools/command.h"

namespace alidade::tools {
namespace {

using database::CloudStatistics;
using database::ColumnStatistics;
using jobs::InfoResult;

/// Beside the table, notes and rates are for those who request details.
class InfoConsole : public Console {
 public:
  explicit InfoConsole(Verbosity verbosity) : Console(verbosity), verbosity_(verbosity) {}

  void note(std::string_view text) override {
    if (verbosity_ == Verbosity::verbose) Console::note(text);
  }
  std::unique_ptr<Stage> begin(std::string task, std::string unit) override {
    if (verbosity_ == Verbosity::verbose) return Console::begin(std::move(task), std::move(unit));
    return std::make_unique<UnratedLine>(std::move(task), std::move(unit), verbosity_);
  }

 private:
  struct UnratedLine : ProgressLine {
    using ProgressLine::ProgressLine;
    void finish() override {}
  };
  Verbosity verbosity_;
};

std::string joined(const std::vector<std::string>& words, const std::string& otherwise) {
  return words.empty() ? otherwise : fmt::format("{}", fmt::join(words, ", "));
}

std::string row(const std::string& name, const std::string& value) {
  return fmt::format("{:<12}{}\n", name, line_text(value));
}

std::string row(const std::string& name, const std::array<std::string, 3>& words) {
  return row(name, fmt::format("{:>18} {:>18} {:>18}", words[0], words[1], words[2]));
}

/// Numbers as they are, zeros without a sign.
std::array<std::string, 3> plain(glm::dvec3 value) {
  value += 0.0;
  return {fmt::format("{}", value.x), fmt::format("{}", value.y), fmt::format("{}", value.z)};
}

/// Coordinates with the decimals of the lattice.
std::array<std::string, 3> on_lattice(const glm::dvec3& value, const Lattice& lattice) {
  std::array<std::string, 3> words;
  for (int axis = 0; axis < 3; ++axis) {
    const std::optional<int> decimals = shown_decimals(lattice, axis);
    words[static_cast<std::size_t>(axis)] =
        decimals ? fmt::format("{:.{}f}", value[axis], *decimals) : fmt::format("{}", value[axis]);
  }
  return words;
}

std::string index_rows(const jobs::IndexFacts& index, bool verified) {
  std::string measured = index.is_in_stored_order ? ", points in its order" : "";
  if (index.spacing_neighbours > 0)
    measured += fmt::format(", spacings to neighbour {}", index.spacing_neighbours);
  if (index.has_surfaces) measured += ", surfaces";
  return row("index", index.name) +
         row("", fmt::format("version {}, {} octree of {} nodes on {} levels{}", k_index_version,
                             index.organisation, index.nodes, index.levels, measured)) +
         row("", fmt::format("{} bytes, {:.2f} per point, {:.2f} of them octree{}", index.bytes,
                             index.bytes_per_point, index.octree_bytes_per_point,
                             verified ? "; verified: intact" : ""));
}

std::string position_text(const std::optional<E57Pose>& pose) {
  if (!pose) return "no pose";
  return fmt::format("at {} {} {}", pose->translation.x, pose->translation.y, pose->translation.z);
}

std::string scan_text(const E57Scan& scan) {
  return fmt::format("{} records, {}", scan.record_count, position_text(scan.pose));
}

std::string image_text(const E57Image& image) {
  std::vector<std::string> pictures;
  for (const E57Representation& one : image.representations) {
    pictures.push_back(fmt::format("{} {} {}x{}{}", name_of(one.projection), one.extension, one.width,
                                   one.height, one.mask ? " with mask" : ""));
  }
  return joined(pictures, "no image") + ", " + position_text(image.pose);
}

/// The first ten, unless verbose.
template <class Item>
std::string e57_rows(const std::vector<Item>& items, const char* kind, std::string (*describe)(const Item&),
                     bool is_verbose) {
  constexpr std::size_t k_first = 10;
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i == k_first && !is_verbose)
      return text + row("", fmt::format("and {} more {}s (-v lists all)", items.size() - i, kind));
    const std::string& name = items[i].name;
    text += row("", fmt::format("{} {}{}: {}", kind, i + 1, name.empty() ? "" : " '" + name + "'",
                                describe(items[i])));
  }
  return text;
}

/// How the box in a file's header differs from that of its points, in words for people: how far it lies
/// beyond them ("wider"), how far they lie beyond it ("excludes"). Empty if no face is off by more than a
/// hundredth of a step of the lattice, or if there are no points. Half a step is common and reported, too:
/// cropping by the box loses points.
std::string header_box_text(const Bounds& stated, const Bounds& points, const Lattice& lattice) {
  double wider = 0.0, left_out = 0.0, finest = lattice.scale.x;
  for (int axis = 0; axis < 3 && !points.empty(); ++axis) {
    finest = std::min(finest, lattice.scale[axis]);
    for (const double beyond : {points.min[axis] - stated.min[axis], stated.max[axis] - points.max[axis]}) {
      if (std::fabs(beyond) <= 0.01 * lattice.scale[axis]) continue;
      wider = std::max(wider, beyond);
      left_out = std::max(left_out, -beyond);
    }
  }
  const int decimals = static_cast<int>(std::clamp(std::ceil(-std::log10(finest) - 1e-9) + 1.0, 0.0, 17.0));
  std::string text;
  if (wider > 0.0) text = fmt::format("up to {:.{}f} wider than the points", wider, decimals);
  if (left_out > 0.0)
    text += fmt::format("{}excludes points by up to {:.{}f}", text.empty() ? "" : "; ", left_out, decimals);
  return text;
}

/// `octree`: of a COPC file, else empty.
std::string file_rows(const CloudFile& file, const Bounds& points, const std::string& octree,
                      const Lattice& lattice) {
  std::string format = file.format + (file.version.empty() ? "" : " " + file.version);
  if (file.point_format) format += fmt::format(", point format {}", *file.point_format);
  std::string text =
      row("file", file.path.string()) + row("", fmt::format("{}, {} points", format, file.point_count));
  if (!octree.empty()) text += row("", octree);
  if (file.dropped_count > 0)
    text += row("", fmt::format("skipped {} points without a position", file.dropped_count));
  if (file.lost_count > 0) text += row("", fmt::format("{} points lost", file.lost_count));
  const std::string box =
      file.stated_bounds ? header_box_text(*file.stated_bounds, points, lattice) : std::string();
  return box.empty() ? text : text + row("", "header box " + box);
}

/// The first positions, and how many there are.
std::string scanner_rows(std::span<const ScannerPosition> scanners) {
  constexpr std::size_t k_most = 4;
  std::string text;
  for (const ScannerPosition& scanner : scanners.first(std::min(k_most, scanners.size()))) {
    const auto& [x, y, z] = plain(scanner.position);
    text += row(text.empty() ? "scanners" : "",
                fmt::format("{} at {} {} {}", scanner.axes ? "depth camera" : "scanner", x, y, z));
  }
  if (scanners.size() > k_most)
    text += row("", fmt::format("and {} more (--json)", scanners.size() - k_most));
  return text;
}

std::string crs_text(const Crs& crs, bool is_verbose) {
  if (!crs.wkt.empty()) return is_verbose ? crs.wkt : crs_name(crs);
  if (crs.geotiff_keys.empty()) return "none";
  const std::string codes = "GeoTIFF keys, " + joined(epsg_codes(crs), "no EPSG code"), wkt = whole_wkt(crs);
  if (wkt.empty()) return "unknown: " + codes;
  return is_verbose ? wkt : fmt::format("{} ({})", crs_name(crs_of_wkt(wkt)), codes);
}

std::string units_text(const InfoResult& info) {
  const auto known = [](const std::string& name) { return name.empty() ? "unknown" : name; };
  return fmt::format("x, y {}; z {}{}", known(info.plane_unit), known(info.height_unit),
                     info.states_height_unit || info.height_unit.empty() ? "" : " (not stated)");
}

/// A number of a column as people write it.
std::string number_text(double value, bool is_whole) {
  if (is_whole) return fmt::format("{:.0f}", value);
  return std::fabs(value) >= 1e5 && std::fabs(value) < 1e15 ? fmt::format("{:.3f}", value)
                                                            : fmt::format("{:.6g}", value);
}

std::string share_row(const std::string& name, std::uint64_t count, std::uint64_t all) {
  return fmt::format(
      "  {:<30}{:>14}{:>9.2f} %\n", name, count,
      100.0 * static_cast<double>(count) / static_cast<double>(std::max<std::uint64_t>(all, 1)));
}

std::string coverage_text(const database::CoverageStatistics& coverage, const Crs& crs) {
  const std::string label = plane_unit_label(crs), unit = label.empty() ? "unit" : label;
  return fmt::format(
      "{0:.4g} points per {4}2, {1:.4g} of last returns; spacing {2:.3g} {4}; area {3:.6g} {4}2 (cells of "
      "{5:.3g} {4} with points)",
      coverage.density, coverage.last_return_density, coverage.spacing, coverage.area, unit, coverage.cell);
}

std::string time_text(const ColumnStatistics& times, bool is_standard) {
  if (!is_standard) {
    const auto first = image::gps_weekday(static_cast<std::int64_t>(times.least)),
               last = image::gps_weekday(static_cast<std::int64_t>(times.most));
    return first && last ? fmt::format("{} to {} (GPS time of an unknown week)", *first, *last)
                         : "GPS times are neither standard nor of a week";
  }
  const auto first = database::moment_of_gps_time(times.least),
             last = database::moment_of_gps_time(times.most);
  return first && last ? date_time_text(*first) + " to " + date_time_text(*last) : "GPS times before 1980";
}

/// Facts of headers that --stats adds.
std::string header_rows(const PointCloud& cloud) {
  std::string text;
  const std::vector<std::string> codes = epsg_codes(cloud.crs);
  if (!codes.empty()) text += row("EPSG", joined(codes, ""));
  std::set<std::string> said;
  for (const CloudFile& file : cloud.files) {
    std::vector<std::string> words{file.software.empty() ? "" : "by " + file.software, file.system_identifier,
                                   file.created};
    std::erase(words, "");
    if (!words.empty() && said.insert(joined(words, "")).second) text += row("written", joined(words, ""));
  }
  if (cloud.project_id != decltype(cloud.project_id){})
    text += row("project", fmt::format("{:02x}", fmt::join(cloud.project_id, "")));
  if (cloud.file_source_id != 0) text += row("source", fmt::format("{}", cloud.file_source_id));
  for (const VariableLengthRecord& record : cloud.records) {
    text +=
        row("record", fmt::format("{} {}, {} bytes{}{}", record.user_id, record.record_id, record.data.size(),
                                  record.description.empty() ? "" : ": ", record.description));
  }
  return text;
}

std::string column_row(const ColumnStatistics& column) {
  std::string text =
      fmt::format("{:<18}{:>14}", line_text(column.name), number_text(column.least, column.is_whole));
  for (const double quantile : column.quantiles)
    text += fmt::format("{:>14}", number_text(quantile, column.is_whole));
  text +=
      fmt::format("{:>14}{:>14}", number_text(column.most, column.is_whole), number_text(column.mean, false));
  if (column.missing > 0) text += fmt::format("  {} without value", column.missing);
  return text + "\n";
}

std::string statistics_rows(const CloudStatistics& statistics, const PointCloud& facts) {
  std::string text = header_rows(facts);
  if (statistics.coverage) text += row("density", coverage_text(*statistics.coverage, facts.crs));
  const auto times = std::ranges::find(statistics.columns, "gps_time", &ColumnStatistics::name);
  if (times != statistics.columns.end()) text += row("time", time_text(*times, facts.gps_time_is_standard));
  const std::uint64_t all = statistics.point_count;
  if (!statistics.classes.empty()) text += "classes\n";
  const auto styles = image::class_styles();
  for (const auto& [number, count] : statistics.classes)
    text +=
        share_row(fmt::format("{:>3} {}", number, styles[static_cast<std::size_t>(number)].name), count, all);
  if (!statistics.returns.empty()) text += "returns\n";
  for (const auto& [numbers, count] : statistics.returns)
    text += share_row(fmt::format("{:>3} of {}", numbers.first, numbers.second), count, all);
  if (statistics.flags) text += "flags\n";
  for (std::size_t i = 0; statistics.flags && i < database::k_flag_names.size(); ++i)
    text += share_row(std::string("    ") + database::k_flag_names[i], (*statistics.flags)[i], all);
  text += fmt::format("{:<18}{:>14}{:>14}{:>14}{:>14}{:>14}{:>14}{:>14}{:>14}\n", "column", "least", "1 %",
                      "25 %", "median", "75 %", "99 %", "most", "mean");
  for (const ColumnStatistics& column : statistics.columns) text += column_row(column);
  return text;
}

std::string table_of(const InfoResult& info, bool is_verbose) {
  const PointCloud& facts = info.facts;
  const Lattice& lattice = facts.lattice;
  std::string text;
  for (const jobs::IndexFacts& index : info.indexes) text += index_rows(index, info.verified);
  for (const E57File& file : info.e57_files) {
    text += row("E57", file.pages().name()) + e57_rows(file.document().scans, "scan", scan_text, is_verbose) +
            e57_rows(file.document().images, "image", image_text, is_verbose);
  }
  for (std::size_t i = 0; i < facts.files.size(); ++i)
    text += file_rows(facts.files[i], info.file_bounds[i], info.octrees[i], lattice);
  text += row("points", fmt::format("{}", info.point_count));
  if (!info.bounds.empty()) {
    text += row("min", on_lattice(info.bounds.min, lattice));
    text += row("max", on_lattice(info.bounds.max, lattice));
    text += row("size", on_lattice(info.bounds.size(), lattice));
  }
  text += row("scale", plain(lattice.scale)) + row("offset", plain(lattice.offset));
  const glm::dvec3& error = info.rounding_error;
  text +=
      row("rounding", error == glm::dvec3(0.0) ? "none: integers preserved"
                                               : fmt::format("at most {} {} {}", error.x, error.y, error.z));
  text += row("attributes", joined(attribute_names(info.attributes), "none"));
  std::vector<std::string> extra_dimensions;
  for (const ExtraDimension& dimension : facts.extra_dimensions) extra_dimensions.push_back(dimension.name);
  if (!extra_dimensions.empty()) text += row("extra", joined(extra_dimensions, ""));
  text += scanner_rows(facts.scanner_positions) + row("CRS", crs_text(facts.crs, is_verbose));
  if (!facts.crs.empty()) text += row("units", units_text(info));
  if (info.statistics) text += statistics_rows(*info.statistics, facts);
  return text;
}

struct InfoCommand : JobCommand<jobs::InfoRequest> {
  bool json = false;
};

ExitCode run_info(const InfoCommand& command) {
  InfoConsole console(command.verbosity);
  const InfoResult info = run(plan(command.request), console);
  if (command.json) {
    write_to_stdout(json_text(info_json(info), 2) + "\n");
    return ExitCode::done;
  }
  write_to_stdout(table_of(info, command.verbosity == Verbosity::verbose));
  warn_all(console, info.facts.warnings);
  return ExitCode::done;
}

}  // namespace

Command add_info(const Options& program) {
  const auto command = std::make_shared<InfoCommand>();
  const Options info = program.command("info", "Describe cloud files");
  add_info_fields(info, command->request);
  info.flag("--json", "print JSON instead of a table; the keys are below", command->json);
  add_verbosity(info, command->verbosity);
  return {info, [command](const CommandLine&) { return run_info(*command); }};
}

}  // namespace alidade::tools
