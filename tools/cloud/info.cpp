// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <iterator>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/shown_text.h"
#include "cloud/axis_units.h"
#include "cloud/cloud_reader.h"
#include "cloud/copc/copc_file.h"
#include "cloud/crs.h"
#include "cloud/point_cloud.h"
#include "cloud/read_cloud.h"
#include "cloud/scratch_cloud.h"
#include "octree/index_file/index_file.h"
#include "octree/index_file/index_header.h"
#include "tools/cloud/e57_images.h"
#include "tools/cloud/load_cloud.h"
#include "tools/cloud/statistics.h"
#include "tools/command.h"

namespace alidade::tools {
namespace {

using Json = nlohmann::ordered_json;

struct InfoOptions : CloudRequest {
  bool json = false, verify = false, stats = false, overwrite = false;
  std::size_t memory = std::size_t{4} << 30;
  std::filesystem::path image_folder;  ///< empty: no images are extracted
};

/// What `alidade info` prints about its files, taken together as one cloud.
struct Description {
  PointCloud cloud;                       ///< without points if memory does not hold them
  std::optional<ScratchCloud> scratch{};  ///< which then does
  PointColumns points{};                  ///< of either
  std::uint64_t point_count = 0;
  AttributeSet attributes;
  Bounds bounds;
  glm::dvec3 resolution{0.0};      ///< the coarsest of the files: CloudReader::resolution()
  std::vector<IndexFile> indexes;  ///< those of the files that are index files
  std::vector<E57File> e57_files;
  std::optional<CloudStatistics> statistics{};
};

/// The description of a single index file, without reading its points.
Description describe(const IndexFile& index) {
  return {.cloud = index.description(),
          .point_count = index.header().tree.point_count,
          .attributes = index.attributes(),
          .bounds = index.header().tree.bounds,
          .indexes = {index},
          .e57_files = {}};
}

/// Reads the points into memory, or into temporary files if they are too many.
void read_points(const InfoOptions& options, Description& description) {
  // Colours are read to learn their depth, extra dimensions for their names; the rest comes from the headers.
  const AttributeSet wanted =
      options.stats ? AttributeSet::all() : Attribute::color | Attribute::extra_dimensions;
  ProgressLine line("reading", "B", options.verbosity);
  const ReadOptions reading{.attributes = wanted, .partial = options.partial, .progress = line.callback()};
  StatedSize size = stated_size(options.files);
  if (size.bytes() > options.memory) {
    const ScratchSpace space{temporary_folder(), options.memory};
    size.attributes.bits &= wanted.bits;
    const bool selects = std::ranges::any_of(options.files.inputs, &CloudInput::is_changed);
    // The number of other points is not known beforehand.
    Console console(options.verbosity == Verbosity::verbose ? Verbosity::verbose : Verbosity::quiet);
    if (!selects && !options.partial && size.uncounted_bytes == 0)
      check_room(space.folder, size.bytes(), console);
    description.cloud = description.scratch.emplace(options.files, reading, space).facts();
    description.points = description.scratch->points();
  } else {
    description.cloud = read_cloud(options.files, reading);
    description.points = points_of(description.cloud);
  }
  if (options.verbosity == Verbosity::verbose) line.finish();
}

CloudInputs e57_files(CloudInputs clouds) {
  clouds.check_files();
  std::erase_if(clouds.inputs, [](const CloudInput& input) { return !input.is(k_e57_format); });
  return clouds;
}

Description describe(const InfoOptions& options) {
  const CloudInput* const index = options.files.only(k_index_format);
  if (index != nullptr && !options.stats) return describe(IndexFile(index->file()));
  Description description;
  const Damage damage = options.partial ? Damage::read_over : Damage::reject;
  std::vector<std::unique_ptr<CloudReader>> readers;  // of files that may have rounded their coordinates
  for (const CloudInput& input : options.files.inputs) {
    if (input.is(k_index_format)) description.indexes.emplace_back(input.file());
    std::unique_ptr<CloudReader> reader = open_cloud(input, damage);
    description.attributes = description.attributes | reader->attributes();
    if (reader->lattice()) continue;
    reader->rest();
    readers.push_back(std::move(reader));
  }
  for (const CloudInput& input : e57_files(options.files).inputs) {
    description.e57_files.emplace_back(input.file());
    description.e57_files.back().pages().rest();
  }
  read_points(options, description);
  description.point_count = description.points.size();
  description.bounds = bounds_of(description.points.lattice, description.points.positions);
  for (const auto& reader : readers)
    description.resolution = glm::max(description.resolution, reader->resolution(description.bounds));
  if (options.stats) {
    ProgressLine counting("counting", "columns", options.verbosity);
    description.statistics = statistics_of(description.points, counting.callback());
    if (options.verbosity == Verbosity::verbose) counting.finish();
  }
  return description;
}

void verify(const InfoOptions& options) {
  for (const CloudInput& input : options.files.inputs) {
    // Opened first: of a missing file, the message is that it is missing.
    InputFile file = input.file();
    if (!input.is(k_index_format))
      throw file_error(file.name(), "no checksums to verify", "an index file (alidade index)");
    ProgressLine line("verifying", "B", options.verbosity);
    IndexFile(file).verify(line.callback());
    if (options.verbosity == Verbosity::verbose) line.finish();
  }
}

const char* organisation_name(Organisation organisation) {
  constexpr const char* k_names[] = {"adaptive", "fixed", "layered"};
  static_assert(std::size(k_names) == std::size_t(Organisation::layered) + 1);
  return k_names[static_cast<std::size_t>(organisation)];
}

/// Bytes of a file, or of its octree alone, for each of its points.
double bytes_per_point(const IndexFile& index, std::uint64_t bytes) {
  const std::uint32_t points = index.header().tree.point_count;
  return points > 0 ? static_cast<double>(bytes) / points : 0.0;
}

std::uint64_t octree_bytes(const IndexFile& index) {
  std::uint64_t bytes = 0;
  for (const SectionEntry& section : index.header().sections) {
    if (section.kind <= IndexSection::sheet_edges) bytes += section.bytes;
  }
  return bytes;
}

bool is_in_stored_order(const IndexHeader& header) {
  return header.tree.point_count > 0 && header.find(IndexSection::ids) == nullptr;
}

std::string spacing_text(const IndexHeader& header) {
  const int neighbours = header.tree.spacing_neighbours;
  return (neighbours > 0 ? fmt::format(", spacings to neighbour {}", neighbours) : "") +
         (header.tree.surface_unit > 0.0 ? ", surfaces" : "");
}

/// What `alidade info --json` prints about an index file beside the facts of its points. `verified`: its
/// checksums were compared.
Json index_json(const IndexFile& index, bool verified) {
  const IndexHeader& header = index.header();
  return {{"file", index.name()},
          {"version", k_index_version},
          {"bytes", header.file_bytes},
          {"bytes_per_point", bytes_per_point(index, header.file_bytes)},
          {"octree_bytes_per_point", bytes_per_point(index, octree_bytes(index))},
          {"organisation", organisation_name(header.tree.organisation)},
          {"levels", header.tree.level_count},
          {"nodes", header.tree.node_count},
          {"stored_order", is_in_stored_order(header)},
          {"spacing_neighbours", header.tree.spacing_neighbours},
          {"surfaces", header.tree.surface_unit > 0.0},
          {"verified", verified}};
}

/// The facts of index_json() as lines for people.
std::vector<std::string> index_lines(const IndexFile& index, bool verified) {
  const IndexHeader& header = index.header();
  return {fmt::format("version {}, {} octree of {} nodes on {} levels{}", k_index_version,
                      organisation_name(header.tree.organisation), header.tree.node_count,
                      header.tree.level_count,
                      (is_in_stored_order(header) ? ", points in its order" : "") + spacing_text(header)),
          fmt::format("{} bytes, {:.2f} per point, {:.2f} of them octree{}", header.file_bytes,
                      bytes_per_point(index, header.file_bytes), bytes_per_point(index, octree_bytes(index)),
                      verified ? "; verified: intact" : "")};
}

/// How the box in a file's header differs from that of its points, in words for people: how far it lies
/// beyond them ("wider"), how far they lie beyond it ("leaves out"). Empty if no face is off by more than a
/// hundredth of a step of the lattice, or if there are no points. Half a step is common and reported, too:
/// cropping by the box loses points.
std::optional<std::string> header_box_text(const Bounds& stated, const Bounds& points,
                                           const Lattice& lattice) {
  if (points.empty()) return std::nullopt;
  double wider = 0.0, left_out = 0.0, finest = lattice.scale.x;
  for (int axis = 0; axis < 3; ++axis) {
    finest = std::min(finest, lattice.scale[axis]);
    for (const double beyond : {points.min[axis] - stated.min[axis], stated.max[axis] - points.max[axis]}) {
      if (std::fabs(beyond) <= 0.01 * lattice.scale[axis]) continue;
      wider = std::max(wider, beyond);
      left_out = std::max(left_out, -beyond);
    }
  }
  if (wider == 0.0 && left_out == 0.0) return std::nullopt;
  const int decimals = static_cast<int>(std::clamp(std::ceil(-std::log10(finest) - 1e-9) + 1.0, 0.0, 17.0));
  std::string text;
  if (wider > 0.0) text = fmt::format("up to {:.{}f} wider than the points", wider, decimals);
  if (left_out > 0.0)
    text += fmt::format("{}excludes points by up to {:.{}f}", text.empty() ? "" : "; ", left_out, decimals);
  return text;
}

/// Box of the rows [begin, end) that a cloud has. Cost: linear.
Bounds bounds_of_rows(const PointColumns& cloud, std::size_t begin, std::size_t end) {
  begin = std::min(begin, cloud.size()), end = std::min(end, cloud.size());
  return bounds_of(cloud.lattice, cloud.positions.subspan(begin, end - begin));
}

/// What `alidade info` prints about the octree of a COPC file: levels, nodes and spacing, or what is wrong
/// with it.
std::string copc_text(const std::filesystem::path& file) {
  try {
    const CopcFile copc{InputFile(file)};
    const auto& nodes = copc.hierarchy().nodes;
    const auto chunks =
        std::ranges::count_if(nodes, [](const CopcNode& node) { return node.chunk.point_count > 0; });
    return fmt::format("octree of {} levels, {} nodes with points, spacing {} in the root",
                       copc.hierarchy().levels(), chunks, copc.info().spacing);
  } catch (const Error& error) {
    return fmt::format("unusable octree: {}", error.parts().problem);
  }
}

/// Largest difference between a measured coordinate and the one in the cloud, per axis: the rounding by the
/// lattice or by the numbers in the files, whichever is larger.
glm::dvec3 rounding_error(const Description& description) {
  for (const CloudFile& file : description.cloud.files) {
    if (!is_las(file) || file.is_rounded)
      return glm::max(0.5 * description.cloud.lattice.scale, description.resolution);
  }
  return glm::dvec3(0.0);
}

Json triple(const glm::dvec3& value) {
  return {value.x, value.y, value.z};
}

/// Coordinates without the rounding errors of products and sums: 375.78 for 375.78000000000003.
Json coordinates(const glm::dvec3& position) {
  glm::dvec3 plain = position;
  for (int axis = 0; axis < 3; ++axis) {
    const double value = position[axis], shorter = std::stod(fmt::format("{:.15g}", value));
    const double step =
        std::nextafter(std::fabs(value), std::numeric_limits<double>::infinity()) - std::fabs(value);
    if (std::fabs(shorter - value) <= 2.0 * step) plain[axis] = shorter;
  }
  return triple(plain);
}

/// "m", "us-ft", "deg", or empty if it is unknown.
struct UnitNames {
  std::string plane, height;
  bool states_heights;

  explicit UnitNames(const Crs& crs) {
    const AxisUnits units = axis_units(crs);
    states_heights = units.states_heights;
    plane = is_geographic(crs) ? "deg" : units.plane ? short_name(*units.plane) : "";
    const std::optional<LengthUnit> of_z = height_unit(crs);
    height = of_z ? short_name(*of_z) : "";
  }
};

Json to_json(const Description& description, bool verified) {
  const PointCloud& cloud = description.cloud;
  Json files = Json::array();
  for (const CloudFile& file : cloud.files) {
    const std::optional<Bounds>& stated = file.stated_bounds;
    files.push_back(
        {{"file", file.path.string()},
         {"format", file.format},
         {"version", file.version},
         {"point_format", file.point_format ? Json(*file.point_format) : Json()},
         {"points", file.point_count},
         {"dropped", file.dropped_count},
         {"lost", file.lost_count},
         {"header_box", stated ? Json{{"min", triple(stated->min)}, {"max", triple(stated->max)}} : Json()}});
  }
  Json extra_dimensions = Json::array();
  for (const ExtraDimension& dimension : cloud.extra_dimensions) extra_dimensions.push_back(dimension.name);
  Json indexes = Json::array();
  for (const IndexFile& index : description.indexes) indexes.push_back(index_json(index, verified));
  Json e57 = Json::array(), scanners = Json::array();
  for (const E57File& file : description.e57_files) e57.push_back(e57_json(file));
  for (const ScannerPosition& scanner : cloud.scanner_positions)
    scanners.push_back({{"scan", scanner.scan},
                        {"position", triple(scanner.position)},
                        {"depth_camera", scanner.axes.has_value()}});
  const bool empty = description.bounds.empty();
  const std::string wkt = whole_wkt(cloud.crs);
  const UnitNames units(cloud.crs);
  const auto unit = [](const std::string& name) { return name.empty() ? Json() : Json(name); };
  Json json = {{"points", description.point_count},
               {"files", files},
               {"bounds",
                {{"min", empty ? Json() : coordinates(description.bounds.min)},
                 {"max", empty ? Json() : coordinates(description.bounds.max)}}},
               {"scale", triple(cloud.lattice.scale)},
               {"offset", triple(cloud.lattice.offset)},
               {"rounding_error", triple(rounding_error(description))},
               {"attributes", attribute_names(description.attributes)},
               {"extra_dimensions", extra_dimensions},
               {"crs", wkt.empty() ? Json() : Json(wkt)},
               {"units",
                {{"x", unit(units.plane)},
                 {"y", unit(units.plane)},
                 {"z", unit(units.height)},
                 {"z_is_stated", units.states_heights}}},
               {"geotiff_keys", cloud.crs.geotiff_keys},
               {"epsg", epsg_codes(cloud.crs)},
               {"scanner_positions", scanners},
               {"indexes", indexes},
               {"e57", e57},
               {"warnings", cloud.warnings}};
  if (description.statistics) json["statistics"] = statistics_json(*description.statistics);
  return json;
}

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

std::string crs_text(const Crs& crs, Verbosity verbosity) {
  if (!crs.wkt.empty()) return verbosity == Verbosity::verbose ? crs.wkt : crs_name(crs);
  if (crs.geotiff_keys.empty()) return "none";
  const std::string codes = "GeoTIFF keys, " + joined(epsg_codes(crs), "no EPSG code"), wkt = whole_wkt(crs);
  if (wkt.empty()) return "unknown: " + codes;
  if (verbosity == Verbosity::verbose) return wkt;
  return fmt::format("{} ({})", crs_name(crs_of_wkt(wkt)), codes);
}

std::string units_text(const Crs& crs) {
  const UnitNames units(crs);
  const auto known = [](const std::string& name) { return name.empty() ? "unknown" : name; };
  return fmt::format("x, y {}; z {}{}", known(units.plane), known(units.height),
                     units.states_heights || units.height.empty() ? "" : " (not stated)");
}

std::string to_table(const Description& description, bool verified, Verbosity verbosity) {
  const PointCloud& cloud = description.cloud;
  std::string text;
  for (const IndexFile& index : description.indexes) {
    text += row("index", index.name());
    for (const std::string& line : index_lines(index, verified)) text += row("", line);
  }
  for (const E57File& file : description.e57_files) {
    text += row("E57", file.pages().name());
    for (const std::string& line : e57_lines(file, verbosity)) text += row("", line);
  }
  std::size_t first_row = 0;
  for (const CloudFile& file : cloud.files) {
    text += row("file", file.path.string());
    std::string format = file.format + (file.version.empty() ? "" : " " + file.version);
    if (file.point_format) format += fmt::format(", point format {}", *file.point_format);
    text += row("", fmt::format("{}, {} points", format, file.point_count));
    if (file.format == "COPC" && description.indexes.empty()) text += row("", copc_text(file.path));
    if (file.dropped_count > 0)
      text += row("", fmt::format("skipped {} points without a position", file.dropped_count));
    if (file.lost_count > 0) text += row("", fmt::format("{} points lost", file.lost_count));
    if (file.stated_bounds) {
      // The points of a file that states a box are consecutive rows here; index files state none.
      const Bounds points = bounds_of_rows(description.points, first_row, first_row + file.point_count);
      if (const auto box = header_box_text(*file.stated_bounds, points, cloud.lattice))
        text += row("", "header box " + *box);
    }
    first_row += file.point_count;
  }
  text += row("points", fmt::format("{}", description.point_count));
  if (!description.bounds.empty()) {
    text += row("min", on_lattice(description.bounds.min, cloud.lattice));
    text += row("max", on_lattice(description.bounds.max, cloud.lattice));
    text += row("size", on_lattice(description.bounds.size(), cloud.lattice));
  }
  text += row("scale", plain(cloud.lattice.scale));
  text += row("offset", plain(cloud.lattice.offset));
  const glm::dvec3 error = rounding_error(description);
  text +=
      row("rounding", error == glm::dvec3(0.0) ? "none: integers preserved"
                                               : fmt::format("at most {} {} {}", error.x, error.y, error.z));
  text += row("attributes", joined(attribute_names(description.attributes), "none"));
  std::vector<std::string> extra_dimensions;
  for (const ExtraDimension& dimension : cloud.extra_dimensions) extra_dimensions.push_back(dimension.name);
  if (!extra_dimensions.empty()) text += row("extra", joined(extra_dimensions, ""));
  text += scanner_rows(cloud.scanner_positions);
  text += row("CRS", crs_text(cloud.crs, verbosity));
  if (!cloud.crs.empty()) text += row("units", units_text(cloud.crs));
  if (description.statistics) text += statistics_text(*description.statistics, cloud);
  return text;
}

ExitCode run(const InfoOptions& options) {
  if (options.verify) verify(options);
  if (!options.image_folder.empty())
    extract_images(e57_files(options.files).names(), options.image_folder, options.overwrite);
  const Description description = describe(options);
  if (options.json) {
    write_to_stdout(json_text(to_json(description, options.verify), 2) + "\n");
    return ExitCode::done;
  }
  write_to_stdout(to_table(description, options.verify, options.verbosity));
  say_warnings(options.verbosity, description.cloud.warnings);
  return ExitCode::done;
}

}  // namespace

Command add_info(const Options& program) {
  auto options = std::make_shared<InfoOptions>();
  const Options command = program.command("info", "Describe cloud files");
  add_cloud_files(command.required(), "files", "FILE...", k_files_help + k_database_help, options->files,
                  add_view_fields(command, {}, HeightUse::as_stored));
  command.flag("--json", "print JSON instead of a table; the keys are below", options->json);
  command.flag(
      "--stats",
      "also read all attributes: density, dates, histograms of classes, returns and flags, and the range, "
      "quantiles and mean of every column",
      options->stats);
  command.value(
      "--memory", "SIZE",
      "memory for points: bytes, or a number with k, M, G or T (default: 4G); those of a larger cloud "
      "use temporary files in TMPDIR",
      options->memory, parse_memory);
  command.flag("--verify",
               "read each index file completely, compare it with its checksums, and check that its octree "
               "contains every point once; errors name section and byte",
               options->verify);
  add_partial(command, options->partial);
  const Field folder = command.file("--extract-images", "FOLDER",
                                    "extract the images of E57 files to this folder, with camera files for "
                                    "'alidade render --camera' and metadata in images.json",
                                    options->image_folder);
  command.needs(folder).flag("--overwrite", "replace existing images", options->overwrite);
  add_verbosity(command, options->verbosity);
  return command_of(command, options, run);
}

}  // namespace alidade::tools
