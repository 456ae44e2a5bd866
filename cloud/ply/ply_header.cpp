// SPDX-License-Identifier: MIT
#include "cloud/ply/ply_header.h"

#include <fmt/format.h>

#include <optional>
#include <string_view>
#include <utility>

#include "base/text_scanner.h"
#include "cloud/table_reader.h"

namespace alidade {

std::string ply_version(PlyFormat format) {
  static constexpr const char* k_versions[] = {"ascii 1.0", "binary_little_endian 1.0",
                                               "binary_big_endian 1.0"};
  return k_versions[static_cast<std::size_t>(format)];
}

namespace {

using Words = std::vector<std::string_view>;

std::optional<ScalarType> scalar_type(std::string_view name) {
  static constexpr std::pair<std::string_view, ScalarType> k_names[] = {
      {"char", ScalarType::int8},       {"int8", ScalarType::int8},       {"uchar", ScalarType::uint8},
      {"uint8", ScalarType::uint8},     {"short", ScalarType::int16},     {"int16", ScalarType::int16},
      {"ushort", ScalarType::uint16},   {"uint16", ScalarType::uint16},   {"int", ScalarType::int32},
      {"int32", ScalarType::int32},     {"uint", ScalarType::uint32},     {"uint32", ScalarType::uint32},
      {"float", ScalarType::float32},   {"float32", ScalarType::float32}, {"double", ScalarType::float64},
      {"float64", ScalarType::float64}, {"int64", ScalarType::int64},     {"uint64", ScalarType::uint64},
  };
  for (const auto& [text, type] : k_names) {
    if (name == text) return type;
  }
  return std::nullopt;
}

ScalarType require_type(const TextScanner& scanner, std::string_view word) {
  if (const auto type = scalar_type(word)) return *type;
  scanner.fail("unsupported property type", "char, uchar, short, ushort, int, uint, float or double",
               quote(word));
}

PlyFormat require_ply_format(const TextScanner& scanner, const Words& words) {
  const std::string found = fmt::format("{}", fmt::join(words.begin() + 1, words.end(), " "));
  for (const PlyFormat format :
       {PlyFormat::ascii, PlyFormat::binary_little_endian, PlyFormat::binary_big_endian}) {
    if (found == ply_version(format)) return format;
  }
  scanner.fail("unsupported PLY format", "ascii, binary_little_endian or binary_big_endian, and version 1.0",
               quote(found));
}

PlyProperty require_property(const TextScanner& scanner, const Words& words) {
  PlyProperty property;
  if (words.size() == 5 && words[1] == "list") {
    property.is_list = true;
    property.count_type = require_type(scanner, words[2]);
    if (property.count_type == ScalarType::float32 || property.count_type == ScalarType::float64)
      scanner.fail("invalid list count type", "an integer type", quote(words[2]));
    property.type = require_type(scanner, words[3]);
  } else if (words.size() == 3) {
    property.type = require_type(scanner, words[1]);
  } else {
    scanner.fail("invalid property line", "property TYPE NAME or property list COUNT_TYPE TYPE NAME");
  }
  property.name = words.back();
  return property;
}

void find_vertex(const TextScanner& scanner, PlyHeader& header) {
  const auto is_vertex = [](const PlyElement& element) { return element.name == "vertex"; };
  const auto found = std::ranges::find_if(header.elements, is_vertex);
  if (found == header.elements.end()) scanner.fail("missing points", "an element named vertex");
  if (std::ranges::count_if(header.elements, is_vertex) > 1) scanner.fail("duplicate element vertex", "one");
  header.vertex = static_cast<std::size_t>(found - header.elements.begin());
}

}  // namespace

PlyHeader read_ply_header(InputFile& input, Damage damage) {
  TextScanner scanner(input);
  const std::string first(scanner.next_line().value_or(""));
  Words words;
  split_words(first, words);
  if (words.size() != 1 || words[0] != "ply")
    fail_at_byte(input.name(), 0, "not a PLY file", "\"ply\" as the first line", quote(first));
  PlyHeader header;
  bool has_format = false;
  while (true) {
    const auto line = scanner.next_line();
    if (!line) scanner.fail("truncated header", "end_header", "the end of the file");
    split_words(*line, words);
    const std::string_view keyword = words.empty() ? "comment" : words[0];
    if (keyword == "end_header") break;
    if (keyword == "comment" || keyword == "obj_info") continue;
    if (keyword == "format") {
      header.format = require_ply_format(scanner, words);
      has_format = true;
    } else if (keyword == "element") {
      const auto count = words.size() == 3 ? parse_count(words[2]) : std::nullopt;
      if (!count) scanner.fail("invalid element line", "element NAME COUNT");
      header.elements.push_back({std::string(words[1]), *count, {}});
    } else if (keyword == "property") {
      if (header.elements.empty()) scanner.fail("property before the first element");
      std::vector<PlyProperty>& properties = header.elements.back().properties;
      properties.push_back(require_property(scanner, words));
      require_few_columns(scanner, properties.size());
    } else {
      scanner.fail("unknown header line", "format, element, property, comment, obj_info or end_header",
                   quote(keyword));
    }
  }
  if (!has_format) scanner.fail("missing format line", "a line such as \"format ascii 1.0\"");
  header.data_offset = scanner.offset();
  header.line_count = scanner.line_number();
  find_vertex(scanner, header);
  const PlyElement& vertex = header.elements[header.vertex];
  const bool is_text = header.format == PlyFormat::ascii;
  check_room(input,
             {.offset = header.data_offset,
              .count = vertex.count,
              .smallest_row = is_text ? vertex.properties.size() : vertex.smallest_size(),
              .is_text = is_text,
              .name = "vertices",
              .value_name = "properties"},
             damage);
  return header;
}

}  // namespace alidade
