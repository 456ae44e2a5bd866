// SPDX-License-Identifier: MIT
#include "cloud/ply/ply_header.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/text_scanner.h"

namespace alidade {

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
  scanner.fail("unknown property type", "char, uchar, short, ushort, int, uint, float or double",
               quote(word));
}

PlyFormat require_format(const TextScanner& scanner, const Words& words) {
  std::string found;
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (i > 1) found += ' ';
    found += words[i];
  }
  for (const PlyFormat format :
       {PlyFormat::ascii, PlyFormat::binary_little_endian, PlyFormat::binary_big_endian}) {
    if (found == ply_version(format)) return format;
  }
  scanner.fail("unknown PLY format", "ascii, binary_little_endian or binary_big_endian, and version 1.0",
               quote(found));
}

PlyElement require_element(const TextScanner& scanner, const Words& words) {
  const auto count = words.size() == 3 ? parse_count(words[2]) : std::nullopt;
  if (!count) scanner.fail("the element line cannot be read", "element NAME COUNT");
  return {std::string(words[1]), *count, {}};
}

PlyProperty require_property(const TextScanner& scanner, const Words& words) {
  PlyProperty property;
  if (words.size() == 5 && words[1] == "list") {
    property.is_list = true;
    property.count_type = require_type(scanner, words[2]);
    if (property.count_type == ScalarType::float32 || property.count_type == ScalarType::float64)
      scanner.fail("a list cannot be counted by this type", "an integer type", quote(words[2]));
    property.type = require_type(scanner, words[3]);
  } else if (words.size() == 3) {
    property.type = require_type(scanner, words[1]);
  } else {
    scanner.fail("the property line cannot be read",
                 "property TYPE NAME or property list COUNT_TYPE TYPE NAME");
  }
  property.name = words.back();
  return property;
}

void find_vertex(const InputFile& input, PlyHeader& header) {
  const auto is_vertex = [](const PlyElement& element) { return element.name == "vertex"; };
  const auto found = std::ranges::find_if(header.elements, is_vertex);
  const std::string place = "line " + std::to_string(header.line_count);
  if (found == header.elements.end())
    throw Error({.file = input.name(),
                 .place = place,
                 .problem = "the header has no points",
                 .expected = "an element called vertex"});
  if (std::ranges::count_if(header.elements, is_vertex) > 1)
    throw Error({.file = input.name(),
                 .place = place,
                 .problem = "the header has several elements called vertex",
                 .expected = "one"});
  header.vertex = static_cast<std::size_t>(found - header.elements.begin());
}

void check_count(const InputFile& input, const PlyHeader& header, Damage damage) {
  const PlyElement& vertex = header.elements[header.vertex];
  // In text, a value takes two bytes with the blank after it; the very last one may lack that.
  const std::uint64_t room = header.format == PlyFormat::ascii ? (input.size() - header.data_place + 1) / 2
                                                               : input.size() - header.data_place;
  const std::uint64_t size =
      header.format == PlyFormat::ascii ? vertex.properties.size() : vertex.smallest_size();
  if (vertex.count == 0 || (size > 0 && vertex.count <= room / size)) return;
  if (size > 0 && damage == Damage::read_over) return;
  throw DamagedFile(
      {.file = input.name(),
       .place = "byte " + std::to_string(header.data_place),
       .problem = "the file is too short for its vertices",
       .expected = std::to_string(vertex.count) + " vertices",
       .found = size > 0 ? "room for " + std::to_string(room / size) : "vertices without properties"});
}

}  // namespace

std::uint64_t PlyElement::smallest_size() const {
  std::uint64_t size = 0;
  for (const PlyProperty& property : properties)
    size += static_cast<std::uint64_t>(scalar_size(property.is_list ? property.count_type : property.type));
  return size;
}

bool PlyElement::has_lists() const {
  return std::ranges::any_of(properties, &PlyProperty::is_list);
}

PlyHeader read_ply_header(InputFile& input, Damage damage) {
  TextScanner scanner(input);
  const std::string first(scanner.next_line().value_or(""));
  Words words;
  split_words(first, words);
  if (words.size() != 1 || words[0] != "ply")
    throw Error({.file = input.name(),
                 .place = "byte 0",
                 .problem = "not a PLY file",
                 .expected = "a first line \"ply\"",
                 .found = quote(first)});
  PlyHeader header;
  bool has_format = false;
  while (true) {
    const auto line = scanner.next_line();
    if (!line) scanner.fail("the header does not end", "end_header", "the end of the file");
    split_words(*line, words);
    const std::string_view keyword = words.empty() ? "comment" : words[0];
    if (keyword == "end_header") break;
    if (keyword == "comment" || keyword == "obj_info") continue;
    if (keyword == "format") {
      header.format = require_format(scanner, words);
      has_format = true;
    } else if (keyword == "element") {
      header.elements.push_back(require_element(scanner, words));
    } else if (keyword == "property") {
      if (header.elements.empty()) scanner.fail("a property stands before the first element");
      std::vector<PlyProperty>& properties = header.elements.back().properties;
      properties.push_back(require_property(scanner, words));
      require_few_columns(scanner, properties.size());
    } else {
      scanner.fail("unknown line in the header", "format, element, property, comment, obj_info or end_header",
                   quote(keyword));
    }
  }
  if (!has_format) scanner.fail("the header has no format line", "format ascii 1.0 or another");
  header.data_place = scanner.place();
  header.line_count = scanner.line_number();
  find_vertex(input, header);
  check_count(input, header, damage);
  return header;
}

std::string ply_version(PlyFormat format) {
  switch (format) {
    case PlyFormat::ascii:
      return "ascii 1.0";
    case PlyFormat::binary_little_endian:
      return "binary_little_endian 1.0";
    case PlyFormat::binary_big_endian:
      return "binary_big_endian 1.0";
  }
  return {};
}

}  // namespace alidade
