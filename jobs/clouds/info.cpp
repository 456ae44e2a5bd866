// SPDX-License-Identifier: MIT
#include "jobs/clouds/info.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <iterator>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.h"
#include "camera/formats/e57_images.h"
#include "cloud/axis_units.h"
#include "cloud/cloud_reader.h"
#include "cloud/copc/copc_file.h"
#include "cloud/crs.h"
#include "jobs/cloud_fields.h"
#include "jobs/large_clouds.h"
#include "jobs/load_cloud.h"
#include "octree/index_file/index_file.h"
#include "octree/index_file/index_header.h"

namespace alidade::jobs {
namespace {

using Json = nlohmann::ordered_json;

/// Into memory, or into temporary files if the points are too many.
HeldCloud read_points(const InfoRequest& request, Listener& listener) {
  // Colours are read to learn their depth, extra dimensions for their names; the rest comes from the headers.
  const AttributeSet wanted =
      request.stats ? AttributeSet::all() : Attribute::color | Attribute::extra_dimensions;
  std::optional<ScratchSpace> scratch;
  const std::size_t memory = request.memory.value_or(std::size_t{4} << 30);
  if (StatedSize size = stated_size(request.files); large_clouds() != nullptr && size.bytes() > memory) {
    scratch = ScratchSpace{temporary_folder(), memory};
    size.attributes.bits &= wanted.bits;
    if (knows_point_count(request.files, request.partial, size))
      check_room(scratch->folder, size.bytes(), listener);
  }
  return hold_cloud(request.files, {.attributes = wanted, .partial = request.partial}, scratch, listener);
}

std::vector<E57File> open_e57_files(const CloudInputs& clouds) {
  clouds.check_files();
  std::vector<E57File> files;
  for (const CloudInput& input : clouds.inputs) {
    if (!input.is(k_e57_format)) continue;
    files.emplace_back(input.file()).pages().rest();
  }
  return files;
}

void verify(const CloudInputs& files, Listener& listener) {
  for (const CloudInput& input : files.inputs) {
    // Opened first: of a missing file, the message is that it is missing.
    InputFile file = input.file();
    if (!input.is(k_index_format))
      throw file_error(file.name(), "no checksums to verify", "an index file (alidade index)");
    in_stage(listener, "verifying", "B", [&](const Progress& progress) { IndexFile(file).verify(progress); });
  }
}

IndexFacts index_facts(const IndexFile& index) {
  constexpr const char* k_names[] = {"adaptive", "fixed", "layered"};
  static_assert(std::size(k_names) == std::size_t(Organisation::layered) + 1);
  const IndexHeader& header = index.header();
  std::uint64_t octree_bytes = 0;
  for (const SectionEntry& section : header.sections)
    if (section.kind <= IndexSection::sheet_edges) octree_bytes += section.bytes;
  const std::uint32_t points = header.tree.point_count;
  const auto per_point = [&](std::uint64_t bytes) {
    return points > 0 ? static_cast<double>(bytes) / points : 0.0;
  };
  return {.name = index.name(),
          .organisation = k_names[static_cast<std::size_t>(header.tree.organisation)],
          .bytes = header.file_bytes,
          .bytes_per_point = per_point(header.file_bytes),
          .octree_bytes_per_point = per_point(octree_bytes),
          .levels = static_cast<std::uint32_t>(header.tree.level_count),
          .nodes = header.tree.node_count,
          .is_in_stored_order = points > 0 && header.find(IndexSection::ids) == nullptr,
          .spacing_neighbours = header.layers.spacing_neighbours,
          .has_surfaces = header.layers.surface_unit > 0.0};
}

/// Levels, nodes and spacing of the octree of a COPC file, or what is wrong with it.
std::string octree_text(const std::filesystem::path& file) {
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

void describe_files(const std::vector<CloudFile>& files, const PointColumns& points, InfoResult& info) {
  std::size_t first = 0;
  for (const CloudFile& file : files) {
    // The points of a file that states a box are consecutive rows here; index files state none.
    const std::size_t begin = std::min(first, points.size()),
                      end = std::min(first += file.point_count, points.size());
    info.file_bounds.push_back(file.stated_bounds
                                   ? bounds_of(points.lattice, points.positions.subspan(begin, end - begin))
                                   : Bounds());
    const bool is_copc = file.format == "COPC" && info.indexes.empty();
    info.octrees.push_back(is_copc ? octree_text(file.path) : "");
  }
}

/// The rounding by the lattice, or by the numbers in the files (FileFacts::resolution()), whichever is
/// larger; none if integers were preserved.
glm::dvec3 rounding_error(const PointCloud& facts, const glm::dvec3& resolution) {
  for (const CloudFile& file : facts.files)
    if (!is_las(file) || file.is_rounded) return glm::max(0.5 * facts.lattice.scale, resolution);
  return glm::dvec3(0.0);
}

/// The columns go, the facts stay.
PointCloud without_points(HeldCloud&& held) {
  if (const LargeCloud* const large = large_of(held)) return large->facts();
  PointCloud facts = std::move(std::get<PointCloud>(held));
  facts.positions = {};
  for_each_column(facts, [](Attribute, auto& column) { column = {}; });
  for (ExtraDimension& dimension : facts.extra_dimensions) dimension.values = {};
  return facts;
}

/// A single index file, without reading its points.
InfoResult describe_header(const IndexFile& index) {
  InfoResult info{.facts = index.description(),
                  .point_count = index.header().tree.point_count,
                  .attributes = index.attributes(),
                  .bounds = index.header().tree.bounds,
                  .indexes = {index_facts(index)}};
  describe_files(info.facts.files, {}, info);
  info.rounding_error = rounding_error(info.facts, glm::dvec3(0.0));
  return info;
}

InfoResult describe_points(const InfoRequest& request, Listener& listener) {
  InfoResult info;
  const Damage damage = request.partial ? Damage::read_over : Damage::reject;
  std::vector<FileFacts> rounding;  // of files that may have rounded their coordinates
  for (const CloudInput& input : request.files.inputs) {
    if (input.is(k_index_format)) info.indexes.push_back(index_facts(IndexFile(input.file())));
    const FileFacts facts = open_cloud(input, damage)->facts();
    info.attributes = info.attributes | facts.attributes;
    if (!facts.lattice) rounding.push_back(facts);
  }
  info.e57_files = open_e57_files(request.files);
  HeldCloud cloud = read_points(request, listener);
  const PointColumns points = points_of(cloud);
  info.point_count = points.size();
  info.bounds = bounds_of(points.lattice, points.positions);
  glm::dvec3 resolution(0.0);
  for (const FileFacts& facts : rounding) resolution = glm::max(resolution, facts.resolution(info.bounds));
  if (request.stats) {
    info.statistics = in_stage(listener, "counting", "columns", [&](const Progress& progress) {
      return database::statistics_of(points, progress);
    });
  }
  describe_files(facts_of(cloud).files, points, info);
  info.facts = without_points(std::move(cloud));
  info.rounding_error = rounding_error(info.facts, resolution);
  return info;
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

Json text_or_null(const std::string& text) {
  return text.empty() ? Json() : Json(text);
}

Json file_json(const CloudFile& file) {
  const std::optional<Bounds>& stated = file.stated_bounds;
  return {{"file", file.path.string()},
          {"format", file.format},
          {"version", file.version},
          {"point_format", file.point_format ? Json(*file.point_format) : Json()},
          {"points", file.point_count},
          {"dropped", file.dropped_count},
          {"lost", file.lost_count},
          {"header_box", stated ? Json{{"min", triple(stated->min)}, {"max", triple(stated->max)}} : Json()}};
}

Json index_json(const IndexFacts& index, bool verified) {
  return {{"file", index.name},
          {"version", k_index_version},
          {"bytes", index.bytes},
          {"bytes_per_point", index.bytes_per_point},
          {"octree_bytes_per_point", index.octree_bytes_per_point},
          {"organisation", index.organisation},
          {"levels", index.levels},
          {"nodes", index.nodes},
          {"stored_order", index.is_in_stored_order},
          {"spacing_neighbours", index.spacing_neighbours},
          {"surfaces", index.has_surfaces},
          {"verified", verified}};
}

/// A list of what `describe` makes of each item.
template <class Items, class Describe>
Json list_of(const Items& items, const Describe& describe) {
  Json list = Json::array();
  for (const auto& item : items) list.push_back(describe(item));
  return list;
}

Json position_json(const std::optional<E57Pose>& pose) {
  return pose ? triple(pose->translation) : Json();
}

Json picture_json(const E57Representation& picture) {
  return {{"projection", name_of(picture.projection)},
          {"format", picture.extension},
          {"width", picture.width},
          {"height", picture.height},
          {"bytes", picture.blob.length},
          {"mask", picture.mask.has_value()}};
}

Json scan_json(const E57Scan& scan) {
  return {{"name", scan.name},
          {"guid", scan.guid},
          {"records", scan.record_count},
          {"scanner", position_json(scan.pose)},
          {"fields", list_of(scan.fields, [](const E57Field& field) { return field.name; })}};
}

Json image_json(const E57Image& image) {
  return {{"name", image.name},
          {"guid", image.guid},
          {"scan_guid", image.scan_guid},
          {"camera", position_json(image.pose)},
          {"pictures", list_of(image.representations, picture_json)}};
}

Json e57_json(const E57File& file) {
  return {{"file", file.pages().name()},
          {"guid", file.document().guid},
          {"scans", list_of(file.document().scans, scan_json)},
          {"images", list_of(file.document().images, image_json)}};
}

Json statistics_json(const database::CloudStatistics& statistics) {
  Json columns = Json::object(), classes = Json::object(), returns = Json::array();
  for (const database::ColumnStatistics& column : statistics.columns) {
    columns[column.name] = {{"count", column.count},        {"missing", column.missing},
                            {"least", column.least},        {"most", column.most},
                            {"mean", column.mean},          {"deviation", column.deviation},
                            {"quantiles", column.quantiles}};
  }
  for (const auto& [kind, count] : statistics.classes) classes[std::to_string(kind)] = count;
  for (const auto& [numbers, count] : statistics.returns)
    returns.push_back({{"number", numbers.first}, {"of", numbers.second}, {"points", count}});
  Json json{
      {"columns", columns}, {"quantiles", database::k_quantiles}, {"classes", classes}, {"returns", returns}};
  for (std::size_t i = 0; statistics.flags && i < database::k_flag_names.size(); ++i)
    json["flags"][database::k_flag_names[i]] = (*statistics.flags)[i];
  if (const auto& coverage = statistics.coverage) {
    json["coverage"] = {{"density", coverage->density},
                        {"last_return_density", coverage->last_return_density},
                        {"spacing", coverage->spacing},
                        {"area", coverage->area},
                        {"cell", coverage->cell}};
  }
  return json;
}

}  // namespace

void add_info_fields(const Fields& fields, InfoRequest& request) {
  add_cloud_files(fields.required(), "files", "FILE...", k_files_help + database_help(), request.files,
                  add_view_fields(fields, {}, HeightUse::as_stored));
  fields.flag(
      "--stats",
      "also read all attributes: density, dates, histograms of classes, returns and flags, and the range, "
      "quantiles and mean of every column",
      request.stats);
  if (large_clouds() != nullptr)
    fields.value(
        "--memory", "SIZE",
        "memory for points: bytes, or a number with k, M, G or T (default: 4G); those of a larger cloud "
        "use temporary files in TMPDIR",
        request.memory, parse_memory);
  fields.flag("--verify",
              "read each index file completely, compare it with its checksums, and check that its octree "
              "contains every point once; errors name section and byte",
              request.verify);
  add_partial(fields, request.partial);
  const Field folder = fields.file("--extract-images", "FOLDER",
                                   "extract the images of E57 files to this folder, with camera files for "
                                   "'alidade render --camera' and metadata in images.json",
                                   request.image_folder);
  fields.needs(folder).flag("--overwrite", "replace existing images", request.overwrite);
}

InfoPlan plan(const InfoRequest& request) {
  return InfoPlan(request, {.clouds = request.files, .partial = request.partial});
}

InfoResult run(const InfoPlan& plan, Listener& listener) {
  const InfoRequest& request = plan.request();
  if (request.verify) verify(request.files, listener);
  if (!request.image_folder.empty()) {
    std::vector<E57File> files = open_e57_files(request.files);
    camera::extract_images(files, request.image_folder, request.overwrite);
  }
  const CloudInput* const index = request.files.only(k_index_format);
  InfoResult info = index != nullptr && !request.stats ? describe_header(IndexFile(index->file()))
                                                       : describe_points(request, listener);
  info.verified = request.verify;
  const Crs& crs = info.facts.crs;
  const AxisUnits units = axis_units(crs);
  info.states_height_unit = units.states_heights;
  info.plane_unit = is_geographic(crs) ? "deg" : units.plane ? short_name(*units.plane) : "";
  if (const std::optional<LengthUnit> unit = height_unit(crs)) info.height_unit = short_name(*unit);
  return info;
}

Json info_json(const InfoResult& info) {
  const PointCloud& facts = info.facts;
  const bool empty = info.bounds.empty();
  const auto name_of = [](const ExtraDimension& dimension) { return dimension.name; };
  const auto scanner_json = [](const ScannerPosition& scanner) {
    return Json{{"scan", scanner.scan},
                {"position", triple(scanner.position)},
                {"depth_camera", scanner.axes.has_value()}};
  };
  Json json = {
      {"points", info.point_count},
      {"files", list_of(facts.files, file_json)},
      {"bounds",
       {{"min", empty ? Json() : coordinates(info.bounds.min)},
        {"max", empty ? Json() : coordinates(info.bounds.max)}}},
      {"scale", triple(facts.lattice.scale)},
      {"offset", triple(facts.lattice.offset)},
      {"rounding_error", triple(info.rounding_error)},
      {"attributes", attribute_names(info.attributes)},
      {"extra_dimensions", list_of(facts.extra_dimensions, name_of)},
      {"crs", text_or_null(whole_wkt(facts.crs))},
      {"units",
       {{"x", text_or_null(info.plane_unit)},
        {"y", text_or_null(info.plane_unit)},
        {"z", text_or_null(info.height_unit)},
        {"z_is_stated", info.states_height_unit}}},
      {"geotiff_keys", facts.crs.geotiff_keys},
      {"epsg", epsg_codes(facts.crs)},
      {"scanner_positions", list_of(facts.scanner_positions, scanner_json)},
      {"indexes",
       list_of(info.indexes, [&](const IndexFacts& index) { return index_json(index, info.verified); })},
      {"e57", list_of(info.e57_files, e57_json)},
      {"warnings", facts.warnings}};
  if (info.statistics) json["statistics"] = statistics_json(*info.statistics);
  return json;
}

}  // namespace alidade::jobs
