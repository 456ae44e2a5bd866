// SPDX-License-Identifier: MIT

#include <fmt/format.h>
#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "base/text_scanner.h"
#include "cloud/attributes.h"
#include "cloud/cloud_reader.h"
#include "cloud/damage.h"
#include "cloud/point_table.h"
#include "cloud/table_reader.h"

namespace alidade {

namespace {

enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };

struct PlyProperty {
  std::string name;
  ScalarType type = ScalarType::float32;
  bool is_list = false;
  ScalarType count_type = ScalarType::uint8;  ///< of the number that precedes a list's values
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /// Bytes one instance takes in a binary file, at least: lists count as empty ones.
  std::uint64_t smallest_size() const {
    std::uint64_t size = 0;
    for (const PlyProperty& property : properties)
      size += static_cast<std::uint64_t>(scalar_size(property.is_list ? property.count_type : property.type));
    return size;
  }
  bool has_lists() const { return std::ranges::any_of(properties, &PlyProperty::is_list); }
};

/// What stands between "ply" and "end_header".
struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::size_t vertex = 0;         ///< index of the element "vertex"
  std::uint64_t data_offset = 0;  ///< first byte after the header
  std::uint64_t line_count = 0;   ///< lines of the header
};

using Words = std::vector<std::string_view>;

/// "binary_little_endian 1.0" and the like.
std::string ply_version(PlyFormat format) {
  static constexpr const char* k_versions[] = {"ascii 1.0", "binary_little_endian 1.0",
                                               "binary_big_endian 1.0"};
  return k_versions[static_cast<std::size_t>(format)];
}

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

/// Reads and checks the header. Errors: anything that is not a PLY 1.0 header, no element "vertex" or two of
/// them, vertices without properties; more vertices than the file has room for are damage.
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

class PlyReader final : public TableReader {
 public:
  PlyReader(InputFile input, PlyHeader header, Damage damage)
      : TableReader(std::move(input), "PLY", damage), header_(std::move(header)) {
    description_.version = ply_version(header_.format);
    std::vector<TableColumn> columns;
    for (const PlyProperty& property : vertex().properties) {
      columns.push_back(
          {property.name, property.type, property.is_list ? ColumnRole::ignored : ColumnRole::extra});
    }
    assign_roles(columns, NameRules::point_format);
    set_columns(std::move(columns), "line " + std::to_string(header_.line_count));
  }

 protected:
  std::optional<std::uint64_t> announced_rows() const override { return vertex().count; }
  void visit_rows(const RowVisitor& visit, const Progress& progress) override {
    return header_.format == PlyFormat::ascii ? visit_text(visit, progress) : visit_binary(visit, progress);
  }

 private:
  const PlyElement& vertex() const { return header_.elements[header_.vertex]; }

  void visit_binary(const RowVisitor& visit, const Progress& progress) {
    const std::endian order =
        header_.format == PlyFormat::binary_big_endian ? std::endian::big : std::endian::little;
    ByteCursor cursor(input_, header_.data_offset);
    for (std::size_t i = 0; i < header_.vertex; ++i) skip_binary(header_.elements[i], cursor, order);

    const std::vector<PlyProperty>& properties = vertex().properties;
    visit_points(vertex().count, cursor, visit, progress, [&](std::vector<Cell>& row) {
      for (std::size_t i = 0; i < properties.size(); ++i) {
        if (properties[i].is_list) {
          skip_list(properties[i], cursor, order);
        } else {
          const std::size_t size = static_cast<std::size_t>(scalar_size(properties[i].type));
          row[i] = cell_from(cursor.take(size), properties[i].type, order);
        }
      }
    });
  }

  void skip_binary(const PlyElement& element, ByteCursor& cursor, std::endian order) const {
    const std::uint64_t size = element.smallest_size();
    if (size == 0 || element.count == 0) return;
    const std::uint64_t offset = cursor.offset();
    if (element.count > (input_.size() - offset) / size) {
      fail("byte " + std::to_string(offset),
           "truncated file: too short for its element " + quote(element.name),
           std::to_string(element.count) + " of at least " + std::to_string(size) + " bytes",
           std::to_string(input_.size() - offset) + " bytes");
    }
    if (!element.has_lists()) {
      cursor.skip(element.count * size);
      return;
    }
    for (std::uint64_t instance = 0; instance < element.count; ++instance) {
      for (const PlyProperty& property : element.properties) {
        if (property.is_list) {
          skip_list(property, cursor, order);
        } else {
          cursor.skip(static_cast<std::uint64_t>(scalar_size(property.type)));
        }
      }
    }
  }

  void skip_list(const PlyProperty& property, ByteCursor& cursor, std::endian order) const {
    const std::uint64_t offset = cursor.offset();
    const Cell count = cell_from(cursor.take(static_cast<std::size_t>(scalar_size(property.count_type))),
                                 property.count_type, order);
    const std::uint64_t size = static_cast<std::uint64_t>(scalar_size(property.type));
    const std::uint64_t left = input_.size() - cursor.offset();
    if (!(count.number >= 0.0 && count.number <= static_cast<double>(left / size))) {
      fail("byte " + std::to_string(offset), "invalid list length of " + quote(property.name),
           "0 to " + std::to_string(left / size),
           std::to_string(static_cast<std::int64_t>(std::clamp(count.number, -9e18, 9e18))));
    }
    cursor.skip(static_cast<std::uint64_t>(count.number) * size);
  }

  void visit_text(const RowVisitor& visit, const Progress& progress) {
    TextScanner scanner(input_, header_.data_offset, header_.line_count);
    written_.emplace(columns());
    for (std::size_t i = 0; i < header_.vertex; ++i) {
      const PlyElement& element = header_.elements[i];
      if (element.properties.empty()) continue;
      for (std::uint64_t instance = 0; instance < element.count; ++instance) next_words(scanner, element);
    }
    visit_points(vertex().count, scanner, visit, progress, [&](std::vector<Cell>& row) {
      next_words(scanner, vertex());
      parse_row(scanner, row);
    });
  }

  /// Fills words_ from the next line that is not empty.
  void next_words(TextScanner& scanner, const PlyElement& element) {
    if (!scanner.next_words(words_))
      scanner.fail("truncated file", "more lines of the element " + quote(element.name));
  }

  void parse_row(const TextScanner& scanner, std::vector<Cell>& row) {
    const std::vector<PlyProperty>& properties = vertex().properties;
    std::size_t word = 0;
    for (std::size_t i = 0; i < properties.size(); ++i) {
      if (word >= words_.size())
        scanner.fail("too few values", "a value for " + quote(properties[i].name),
                     std::to_string(words_.size()) + " values");
      const std::string_view text = words_[word++];
      if (properties[i].is_list) {
        const auto count = parse_count(text);
        if (!count || *count > words_.size() - word)
          scanner.fail("invalid list length", "0 to " + std::to_string(words_.size() - word), quote(text));
        word += static_cast<std::size_t>(*count);
        continue;
      }
      row[i] = require_cell(scanner, text, properties[i].type);
      written_->add(i, text);
    }
    if (word < words_.size())
      scanner.fail("too many values", std::to_string(word), std::to_string(words_.size()));
  }

  PlyHeader header_;
};

}  // namespace

std::unique_ptr<CloudReader> open_ply(InputFile file, Damage damage) {
  PlyHeader header = read_ply_header(file, damage);
  return std::make_unique<PlyReader>(std::move(file), std::move(header), damage);
}

}  // namespace alidade
