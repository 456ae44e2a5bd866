// SPDX-License-Identifier: MIT
#include "cloud/e57/e57_xml.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <unordered_set>

#include "base/bytes.h"
#include "base/text_scanner.h"

namespace alidade {
namespace {

template <class Integer>
std::optional<Integer> parse_integer(std::string_view text) {
  return parse_count<Integer>(text.substr(text.starts_with('+') ? 1 : 0));
}

std::string_view without_blanks(std::string_view text) {
  constexpr const char* k_blanks = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(k_blanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(k_blanks) - begin + 1);
}

/// Rotation by a unit quaternion in Hamilton's convention.
glm::dmat3 rotation_of(double w, double x, double y, double z) {
  return {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
          {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
          {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

constexpr std::uint64_t k_section_header_bytes = 32;
constexpr int k_deepest_prototype = 8;       ///< levels of structures
constexpr std::size_t k_longest_name = 256;  ///< bytes; names of fields include those of their structures

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
      node.fail("the minimum exceeds the maximum", fmt::format("at most {}", field.maximum),
                std::to_string(field.minimum));
    }
    if (type == "ScaledInteger") {
      field.scale = node.number_attribute("scale").value_or(1.0);
      field.offset = node.number_attribute("offset").value_or(0.0);
    }
    // No sensor has a finer resolution: wider ranges are limits of the type, not of the data.
    const int most_bits = field.kind == E57FieldKind::integer ? 30 : 62;
    if (minimum && maximum && field.bits() <= most_bits) {
      const double a = static_cast<double>(*minimum) * field.scale + field.offset;
      const double b = static_cast<double>(*maximum) * field.scale + field.offset;
      field.range = {{std::min(a, b), std::max(a, b)}};
    }
  } else if (type == "Float") {
    const std::string_view precision = node.element().attribute("precision").value();
    if (!precision.empty() && precision != "single" && precision != "double")
      node.fail("unknown precision", "single or double", quote(precision));
    field.kind = precision == "single" ? E57FieldKind::float32 : E57FieldKind::float64;
    // As above, larger values are limits of the type.
    constexpr double k_unlimited = 1e30;
    const auto minimum = parse_number(node.element().attribute("minimum").value());
    const auto maximum = parse_number(node.element().attribute("maximum").value());
    if (minimum && maximum && std::abs(*minimum) < k_unlimited && std::abs(*maximum) < k_unlimited)
      field.range = {{*minimum, *maximum}};
  } else if (type == "String") {
    field.kind = E57FieldKind::text;
  } else {
    node.fail("unsupported type", "Integer, ScaledInteger, Float or String", quote(type));
  }
  return field;
}

/// Appends the leaves of a prototype in document order. Each leaf is a field, stored in a stream of its own.
void read_fields(const E57Node& parent, const std::string& prefix, int depth, std::vector<E57Field>& fields) {
  if (depth > k_deepest_prototype) parent.fail("too many nested levels", "at most 8 levels");
  for (const pugi::xml_node& element : parent.element().children()) {
    if (element.type() != pugi::node_element) continue;
    const E57Node node = parent.descend(element);
    const std::string name = prefix + element.name();
    if (name.size() > k_longest_name) {
      node.fail("excessive path length", fmt::format("at most {} bytes", k_longest_name),
                std::to_string(name.size()));
    }
    if (std::string_view(element.attribute("type").value()) == "Structure") {
      read_fields(node, name + "/", depth + 1, fields);
      continue;
    }
    if (fields.size() == k_most_columns)
      parent.fail("too many fields", fmt::format("at most {}", k_most_columns));
    fields.push_back(read_field(node, name));
  }
}

E57Limits read_limits(const E57Node& parent, const std::string& name) {
  const E57Node low = parent.child((name + "Minimum").c_str());
  const E57Node high = parent.child((name + "Maximum").c_str());
  if (!low || !high) return std::nullopt;
  // An element without text has the default value of E57, 0.
  return {{low.number_or(0.0), high.number_or(0.0)}};
}

/// Sets the section of the scan's records and checks that it lies in the file and can hold them.
void locate_section(const E57Node& points, E57Pages& pages, E57Scan& scan) {
  const std::string& where = points.where();
  scan.begin = pages.offset_of(points.require_count_attribute("fileOffset"), where, "the section of points");
  if (k_section_header_bytes > pages.size() - scan.begin)
    pages.fail(where, "truncated file", "the header of the section of points");
  const std::span<const std::byte> header = pages.view(scan.begin, k_section_header_bytes);
  const auto id = load<std::uint8_t>(header.data());
  const auto length = load<std::uint64_t>(header.data() + 8), data = load<std::uint64_t>(header.data() + 16);
  if (id != 1) pages.fail(where, "wrong id of the section of points", "1", std::to_string(id));
  if (length < k_section_header_bytes || length > pages.size() - scan.begin) {
    pages.fail(where, "the section of points exceeds the file",
               fmt::format("32 to {} bytes", pages.size() - scan.begin), std::to_string(length));
  }
  scan.end = scan.begin + length;
  scan.first_packet = pages.offset_of(data, where, "the first packet");
  if (scan.first_packet < scan.begin + k_section_header_bytes || scan.first_packet > scan.end)
    pages.fail(where, "the first packet is outside the section of points",
               fmt::format("{} to {}", scan.begin + k_section_header_bytes, scan.end),
               std::to_string(scan.first_packet));

  // Records of constant fields take no bits. Counting one bit for them limits their number.
  std::uint64_t bits = 0;
  for (const E57Field& field : scan.fields) bits += static_cast<std::uint64_t>(field.bits());
  const std::uint64_t most = (scan.end - scan.begin) * 8 / std::max<std::uint64_t>(bits, 1);
  if (scan.record_count > most) {
    pages.fail(where, "the scan has more points than its section can hold", fmt::format("at most {}", most),
               std::to_string(scan.record_count));
  }
}

constexpr std::uint64_t k_blob_header_bytes = 16;

/// The contents of the binary section that `node` describes. Checks that they lie in the E57 file.
E57Blob locate_blob(const E57Node& node, E57Pages& pages) {
  const std::uint64_t length = node.require_count_attribute("length");
  const std::uint64_t begin =
      pages.offset_of(node.require_count_attribute("fileOffset"), node.where(), "the " + node.name());
  const std::uint64_t room = pages.size() - begin;
  if (room < k_blob_header_bytes || length > room - k_blob_header_bytes)
    node.fail("invalid length", fmt::format("at most {} bytes", room), std::to_string(length));
  const std::span<const std::byte> header = pages.view(begin, k_blob_header_bytes);
  const auto id = load<std::uint8_t>(header.data());
  const auto section = load<std::uint64_t>(header.data() + 8);
  if (id != 0) node.fail("wrong section id", "0", std::to_string(id));
  // Some writers include the header in the section's length, some do not.
  if (length > section)
    node.fail("invalid length", fmt::format("at most {} bytes", section), std::to_string(length));
  return {.offset = begin + k_blob_header_bytes, .length = length};
}

std::string extension_of(const E57Blob& blob, E57Pages& pages) {
  constexpr std::string_view k_png = "\x89PNG\r\n\x1a\n", k_jpeg = "\xFF\xD8\xFF";
  const std::size_t count = blob.length < k_png.size() ? static_cast<std::size_t>(blob.length) : k_png.size();
  const std::span<const std::byte> bytes = pages.view(blob.offset, count);
  const std::string_view start(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return start.starts_with(k_png) ? "png" : start.starts_with(k_jpeg) ? "jpg" : "bin";
}

/// Elements of an image, in the order of E57Projection.
constexpr const char* k_representations[] = {"visualReferenceRepresentation", "pinholeRepresentation",
                                             "sphericalRepresentation", "cylindricalRepresentation"};

/// Empty without an image file.
std::optional<E57Representation> read_representation(const E57Node& node, E57Projection projection,
                                                     E57Pages& pages) {
  const E57Node jpeg = node.child("jpegImage"), png = node.child("pngImage");
  if (!jpeg && !png) return std::nullopt;
  E57Representation representation;
  representation.projection = projection;
  representation.blob = locate_blob(jpeg ? jpeg : png, pages);
  representation.extension = extension_of(representation.blob, pages);
  if (const E57Node mask = node.child("imageMask")) representation.mask = locate_blob(mask, pages);
  representation.width = node.child("imageWidth").count();
  representation.height = node.child("imageHeight").count();
  representation.focal_length = node.child("focalLength").number_or(0.0);
  representation.pixel_width = node.child("pixelWidth").number_or(0.0);
  representation.pixel_height = node.child("pixelHeight").number_or(0.0);
  representation.principal_x = node.child("principalPointX").number_or(0.0);
  representation.principal_y = node.child("principalPointY").number_or(0.0);
  // One writer misspells "radius".
  representation.radius = node.child("radius").number_or(node.child("readius").number_or(0.0));
  if (projection == E57Projection::spherical && representation.width > 0 && representation.height > 0) {
    // Some writers omit the sizes of pixels of an image that covers the whole sphere.
    if (representation.pixel_width == 0.0)
      representation.pixel_width = 2.0 * std::numbers::pi / static_cast<double>(representation.width);
    if (representation.pixel_height == 0.0)
      representation.pixel_height = std::numbers::pi / static_cast<double>(representation.height);
  }
  return representation;
}

}  // namespace

std::string E57Node::text() const {
  std::string text;
  for (const pugi::xml_node& part : element_.children()) {
    if (part.type() == pugi::node_pcdata || part.type() == pugi::node_cdata) text += part.value();
  }
  return std::string(without_blanks(text));
}

std::optional<double> E57Node::number() const {
  const std::string word = text();
  if (word.empty()) return std::nullopt;
  auto value = parse_number(word);
  if (value && std::string_view(element_.attribute("type").value()) == "ScaledInteger")
    value = *value * number_attribute("scale").value_or(1.0) + number_attribute("offset").value_or(0.0);
  if (!value || !std::isfinite(*value)) fail("invalid value", "a finite number", quote(word));
  return value;
}

std::uint64_t E57Node::count() const {
  const std::string word = text();
  if (word.empty()) return 0;
  const auto value = parse_integer<std::uint64_t>(word);
  if (!value) fail("invalid value", "an integer, at least 0", quote(word));
  return *value;
}

std::optional<std::int64_t> E57Node::integer_attribute(const char* name) const {
  const pugi::xml_attribute attribute = element_.attribute(name);
  if (!attribute) return std::nullopt;
  const auto value = parse_integer<std::int64_t>(without_blanks(attribute.value()));
  if (!value) fail(fmt::format("invalid {}", name), "an integer", quote(attribute.value()));
  return value;
}

std::optional<double> E57Node::number_attribute(const char* name) const {
  const pugi::xml_attribute attribute = element_.attribute(name);
  if (!attribute) return std::nullopt;
  const auto value = parse_number(without_blanks(attribute.value()));
  if (!value || !std::isfinite(*value))
    fail(fmt::format("invalid {}", name), "a finite number", quote(attribute.value()));
  return value;
}

std::uint64_t E57Node::require_count_attribute(const char* name) const {
  const pugi::xml_attribute attribute = element_.attribute(name);
  const auto value = parse_integer<std::uint64_t>(without_blanks(attribute.value()));
  if (!value) {
    fail(fmt::format("invalid {}", name), "an integer, at least 0",
         attribute ? quote(attribute.value()) : "none");
  }
  return *value;
}

void E57Node::fail(std::string problem, std::string expected, std::string found) const {
  pages_->fail(where_, std::move(problem) + (element_ ? " of " + quote(element_.name()) : ""),
               std::move(expected), std::move(found));
}

std::optional<E57Pose> read_e57_pose(const E57Node& parent, E57Oddities& oddities) {
  const E57Node node = parent.child("pose");
  if (!node) return std::nullopt;
  E57Pose pose;
  if (const E57Node rotation = node.child("rotation")) {
    const double w = rotation.child("w").number_or(0.0), x = rotation.child("x").number_or(0.0),
                 y = rotation.child("y").number_or(0.0), z = rotation.child("z").number_or(0.0);
    const double length = std::hypot(std::hypot(w, x), std::hypot(y, z));
    if (!(length > 1e-100 && length < 1e100)) {
      rotation.fail("invalid value", "a unit quaternion", fmt::format("length {}", length));
    }
    if (std::abs(length - 1.0) > 1e-3) {
      oddities.add("quaternion", fmt::format("{}: the quaternion of the pose has length {}; normalized",
                                             parent.where(), length));
    }
    pose.is_rotated = x != 0.0 || y != 0.0 || z != 0.0;
    if (pose.is_rotated) pose.rotation = rotation_of(w / length, x / length, y / length, z / length);
  }
  if (const E57Node translation = node.child("translation")) {
    pose.translation = {translation.child("x").number_or(0.0), translation.child("y").number_or(0.0),
                        translation.child("z").number_or(0.0)};
  }
  return pose;
}

E57Scan read_e57_scan(const E57Node& parent, E57Pages& pages, E57Oddities& oddities) {
  E57Scan scan;
  scan.name = parent.child("name").text();
  scan.guid = parent.child("guid").text();
  const E57Node points = parent.child("points");
  if (!points) pages.fail(parent.where(), "missing element points");
  if (std::string_view(points.element().attribute("type").value()) != "CompressedVector")
    points.fail("wrong type", "CompressedVector", quote(points.element().attribute("type").value()));
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
    if (codec.type() == pugi::node_element) points.fail("unsupported compression", "none");
  }
  read_fields(points.child("prototype"), "", 1, scan.fields);
  std::unordered_set<std::string_view> names;
  for (const E57Field& field : scan.fields) {
    if (!names.insert(field.name).second)
      points.fail("duplicate field name", "unique names", quote(field.name));
  }
  // If a scan has no records, the offset of its section may be arbitrary.
  if (scan.record_count > 0) locate_section(points, pages, scan);
  return scan;
}

E57Image read_e57_image(const E57Node& parent, E57Pages& pages, E57Oddities& oddities) {
  E57Image image;
  image.name = parent.child("name").text();
  image.guid = parent.child("guid").text();
  image.scan_guid = parent.child("associatedData3DGuid").text();
  image.pose = read_e57_pose(parent, oddities);
  for (int i = 0; i < 4; ++i) {
    const E57Node node = parent.child(k_representations[i]);
    if (!node) continue;
    const auto representation = read_representation(node, static_cast<E57Projection>(i), pages);
    if (representation) image.representations.push_back(*representation);
  }
  if (image.representations.empty()) oddities.add("no image", parent.where() + " contains no image");
  return image;
}

}  // namespace alidade
