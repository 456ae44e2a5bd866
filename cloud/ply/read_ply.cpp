// SPDX-License-Identifier: MIT

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
#include "cloud/ply/ply_header.h"
#include "cloud/point_table.h"
#include "cloud/table_reader.h"

namespace alidade {

namespace {

class PlyReader final : public TableReader {
 public:
  PlyReader(InputFile input, PlyHeader header, Damage damage)
      : TableReader(std::move(input), "PLY", damage), header_(std::move(header)) {
    facts_.file.version = ply_version(header_.format);
    rules_.announced_rows = vertex().count;
    std::vector<TableColumn> columns;
    for (const PlyProperty& property : vertex().properties) {
      columns.push_back(
          {property.name, property.type, property.is_list ? ColumnRole::ignored : ColumnRole::extra});
    }
    assign_roles(columns, NameRules::point_format);
    take_splat_colors(columns);
    set_columns(std::move(columns), "line " + std::to_string(header_.line_count));
    if (rules_.colors)
      warn(
          "the points are Gaussian splats: their colours are those of f_dc; opacity, scales and rotations "
          "are not used, so that each of them is a point");
    if (header_.format != PlyFormat::ascii) check_end(header_.data_offset, data_end());
  }

 protected:
  void visit_rows(const RowVisitor& visit, const Progress& progress) override {
    return header_.format == PlyFormat::ascii ? visit_text(visit, progress) : visit_binary(visit, progress);
  }

 private:
  /// Makes f_dc_0, f_dc_1 and f_dc_2 the colours of a file without others.
  void take_splat_colors(std::vector<TableColumn>& columns) {
    std::vector<TableColumn*> found;
    for (const char* const name : {"f_dc_0", "f_dc_1", "f_dc_2"}) {
      const auto column = std::ranges::find(columns, name, &TableColumn::name);
      if (column == columns.end() || column->role != ColumnRole::extra || find_role(columns, ColumnRole::red))
        return;
      found.push_back(&*column);
    }
    // Source: Kerbl et al., 3D Gaussian Splatting, 2023:
    // colour = 0.5 + constant of the spherical harmonics * f_dc.
    constexpr double k_constant = 0.28209479177387814;
    rules_.colors =
        ValueScaling{.origin = -0.5 / k_constant, .factor = 65535.0 * k_constant, .assumption = {}};
    constexpr ColumnRole k_roles[] = {ColumnRole::red, ColumnRole::green, ColumnRole::blue};
    for (std::size_t i = 0; i < found.size(); ++i) found[i]->role = k_roles[i];
  }

  const PlyElement& vertex() const { return header_.elements[header_.vertex]; }

  /// The end of the last element; empty if it depends on lists, or lies behind the end of the file.
  std::optional<std::uint64_t> data_end() const {
    std::uint64_t end = header_.data_offset;
    for (const PlyElement& element : header_.elements) {
      const std::uint64_t size = std::max<std::uint64_t>(element.smallest_size(), 1);
      if (element.has_lists() || element.count > (input_.size() - end) / size) return std::nullopt;
      end += element.count * element.smallest_size();
    }
    return end;
  }

  void visit_binary(const RowVisitor& visit, const Progress& progress) {
    const std::endian order = byte_order(header_.format);
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
