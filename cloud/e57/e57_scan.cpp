// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string_view>
#include <unordered_set>

#include "base/bytes.h"
#include "base/text_scanner.h"
#include "cloud/e57/e57_xml.h"

namespace alidade {
namespace {

constexpr std::uint64_t k_section_header_bytes = 32;
constexpr int k_deepest_prototype = 8;
/// Fields carry the names of the structures they are in, which a file has once.
constexpr std::size_t k_longest_name = 256;

E57Field read_field(const E57Node& node, std::string name) {
  E57Field field;
  field.name = std::move(name);
  const std::string_view type = node.element().attribute("type").value();
  if (type == "Integer" || type == "ScaledInteger") {
    using Limits = std::numeric_limits<std::int64_t>;
    field.kind = type == "Integer" ? E57FieldKind::integer : E57FieldKind::scaled_integer;
    const auto minimum = node.integer_attribute("minimum"), maximum = node.integer_attribute("maximum");
    field.minimum = minimum.value_or(Limits::min());
    field.maximum = maximum.value_or(Limits::max());
    if (field.minimum > field.maximum) {
      node.fail("has a minimum above its maximum", fmt::format("at most {}", field.maximum),
                std::to_string(field.minimum));
    }
    if (type == "ScaledInteger") {
      field.scale = node.number_attribute("scale").value_or(1.0);
      field.offset = node.number_attribute("offset").value_or(0.0);
    }
    // Nothing is measured in more steps than this: wider ranges are those of a type.
    const int most_bits = field.kind == E57FieldKind::integer ? 30 : 62;
    if (minimum && maximum && field.bits() <= most_bits) {
      const double a = static_cast<double>(*minimum) * field.scale + field.offset;
      const double b = static_cast<double>(*maximum) * field.scale + field.offset;
      field.range = {{std::min(a, b), std::max(a, b)}};
    }
  } else if (type == "Float") {
    const std::string_view precision = node.element().attribute("precision").value();
    if (!precision.empty() && precision != "single" && precision != "double")
      node.fail("has an unknown precision", "single or double", quote(precision));
    field.kind = precision == "single" ? E57FieldKind::float32 : E57FieldKind::float64;
    // Likewise.
    constexpr double k_unlimited = 1e30;
    const auto minimum = parse_number(node.element().attribute("minimum").value());
    const auto maximum = parse_number(node.element().attribute("maximum").value());
    if (minimum && maximum && std::abs(*minimum) < k_unlimited && std::abs(*maximum) < k_unlimited)
      field.range = {{*minimum, *maximum}};
  } else if (type == "String") {
    field.kind = E57FieldKind::text;
  } else {
    node.fail("has a type that records cannot have", "Integer, ScaledInteger, Float or String", quote(type));
  }
  return field;
}

/// The leaves of a prototype in document order, each of which has a stream of bytes.
void read_fields(const E57Node& parent, const std::string& prefix, int depth, std::vector<E57Field>& fields) {
  if (depth > k_deepest_prototype) parent.fail("is nested too deeply", "8 levels at most");
  for (const pugi::xml_node& element : parent.element().children()) {
    if (element.type() != pugi::node_element) continue;
    const E57Node node = parent.descend(element);
    const std::string name = prefix + element.name();
    if (name.size() > k_longest_name) {
      parent.fail("has a field with too long a name", fmt::format("at most {} bytes", k_longest_name),
                  std::to_string(name.size()));
    }
    if (std::string_view(element.attribute("type").value()) == "Structure") {
      read_fields(node, name + "/", depth + 1, fields);
      continue;
    }
    if (fields.size() == k_most_columns)
      parent.fail("has too many fields", fmt::format("{} at most", k_most_columns));
    fields.push_back(read_field(node, name));
  }
}

E57Limits read_limits(const E57Node& parent, const std::string& name) {
  const E57Node low = parent.child((name + "Minimum").c_str());
  const E57Node high = parent.child((name + "Maximum").c_str());
  if (!low || !high) return std::nullopt;
  // An element without text is 0.
  return {{low.number_or(0.0), high.number_or(0.0)}};
}

/// Finds the section of the scan's records and checks that it could hold them.
void locate_section(const E57Node& points, E57Pages& pages, E57Scan& scan) {
  const std::string& where = points.where();
  scan.begin = pages.place_of(points.require_count_attribute("fileOffset"), where, "the section of points");
  if (k_section_header_bytes > pages.size() - scan.begin)
    pages.fail(where, "the file ends early", "the header of the section of points");
  const std::span<const std::byte> header = pages.view(scan.begin, k_section_header_bytes);
  const auto id = load<std::uint8_t>(header.data());
  const auto length = load<std::uint64_t>(header.data() + 8), data = load<std::uint64_t>(header.data() + 16);
  if (id != 1) pages.fail(where, "no section of points where one should begin", "1", std::to_string(id));
  if (length < k_section_header_bytes || length > pages.size() - scan.begin) {
    pages.fail(where, "the section of points does not fit into the file",
               fmt::format("32 to {} bytes", pages.size() - scan.begin), std::to_string(length));
  }
  scan.end = scan.begin + length;
  scan.first_packet = pages.place_of(data, where, "the first packet");
  if (scan.first_packet < scan.begin + k_section_header_bytes || scan.first_packet > scan.end)
    pages.fail(where, "the first packet lies outside the section of points",
               fmt::format("{} to {}", scan.begin + k_section_header_bytes, scan.end),
               std::to_string(scan.first_packet));

  // A scan of nothing but constants takes no room at all. Nobody means more of it than of one-bit fields.
  std::uint64_t bits = 0;
  for (const E57Field& field : scan.fields) bits += static_cast<std::uint64_t>(field.bits());
  const std::uint64_t most = (scan.end - scan.begin) * 8 / std::max<std::uint64_t>(bits, 1);
  if (scan.record_count > most) {
    pages.fail(where, "the section is too short for the points of the scan", fmt::format("at most {}", most),
               std::to_string(scan.record_count));
  }
}

}  // namespace

int E57Field::bits() const {
  switch (kind) {
    case E57FieldKind::float32:
      return 32;
    case E57FieldKind::float64:
      return 64;
    case E57FieldKind::text:
      return 8;
    default:
      return std::bit_width(static_cast<std::uint64_t>(maximum) - static_cast<std::uint64_t>(minimum));
  }
}

E57Scan read_e57_scan(const E57Node& parent, E57Pages& pages, E57Oddities& oddities) {
  E57Scan scan;
  scan.name = parent.child("name").text();
  scan.guid = parent.child("guid").text();
  const E57Node points = parent.child("points");
  if (!points) parent.fail("has no points", "points in every scan");
  if (std::string_view(points.element().attribute("type").value()) != "CompressedVector")
    points.fail("is of the wrong type", "CompressedVector",
                quote(points.element().attribute("type").value()));
  scan.record_count = points.require_count_attribute("recordCount");
  scan.pose = read_e57_pose(parent, oddities);
  scan.intensity_limits = read_limits(parent.child("intensityLimits"), "intensity");
  const E57Node colors = parent.child("colorLimits");
  scan.color_limits = {read_limits(colors, "colorRed"), read_limits(colors, "colorGreen"),
                       read_limits(colors, "colorBlue")};
  if (const auto start = parent.child("acquisitionStart").child("dateTimeValue").number();
      start && *start > 0)
    scan.start = start;
  for (const pugi::xml_node& codec : points.child("codecs").element().children()) {
    if (codec.type() == pugi::node_element)
      points.child("codecs").fail("names a compression nobody knows", "none");
  }
  read_fields(points.child("prototype"), "", 1, scan.fields);
  std::unordered_set<std::string_view> names;
  for (const E57Field& field : scan.fields) {
    if (!names.insert(field.name).second)
      points.fail("has two fields of one name", "names that differ", quote(field.name));
  }
  // Writers leave anything in the place of a section without records.
  if (scan.record_count > 0) locate_section(points, pages, scan);
  return scan;
}

}  // namespace alidade
