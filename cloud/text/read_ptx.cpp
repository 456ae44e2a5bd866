// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/text_scanner.h"
#include "cloud/cloud_reader.h"
#include "cloud/table_reader.h"

namespace alidade {

namespace {

/// More points than any file has; keeps products within 64 bits.
constexpr std::uint64_t k_most_points = std::uint64_t{1} << 62;

/// Rows of the matrix that transforms a point of the scan, as a row vector (x, y, z, 1), to the world.
using Transform = std::array<std::array<double, 4>, 4>;
constexpr Transform k_identity{
    {{1.0, 0.0, 0.0, 0.0}, {0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, 1.0, 0.0}, {0.0, 0.0, 0.0, 1.0}}};

struct ScanHeader {
  std::uint64_t point_count = 0;  ///< columns times rows, including cells without a return
  Transform transform{};
  bool was_transposed = false;
};

/// PTX: for each scan ten lines of header (columns, rows, scanner position, its three axes, the 4 x 4
/// transform, whose last row is the translation), then a line "x y z [intensity [red green blue]]" for each
/// cell of the scan's grid, "0 0 0" without a return. Position and axes repeat the transform, so only their
/// syntax is checked. Programs write an identity transform if the position is unknown.
class PtxReader final : public TableReader {
 public:
  PtxReader(InputFile input, Damage damage)
      : TableReader(std::move(input), "PTX", damage,
                    {.reason_to_drop = "without a return", .intensities = IntensityScale::unit}) {
    TextScanner scanner(input_);
    while (scanner.next_words(words_)) {
      const ScanHeader header = read_scan_header(scanner);
      if (header.point_count == 0) continue;
      if (!scanner.next_words(words_)) fail_early(scanner);
      value_count_ = require_value_count(scanner);
      break;
    }
    std::vector<TableColumn> columns{{"x", ScalarType::float64, ColumnRole::x},
                                     {"y", ScalarType::float64, ColumnRole::y},
                                     {"z", ScalarType::float64, ColumnRole::z},
                                     {"intensity", ScalarType::float64, ColumnRole::intensity},
                                     {"red", ScalarType::float64, ColumnRole::red},
                                     {"green", ScalarType::float64, ColumnRole::green},
                                     {"blue", ScalarType::float64, ColumnRole::blue}};
    columns.resize(value_count_);
    set_columns(std::move(columns), "line 1");
    facts_.coordinate_types = {};  // the lines tell the resolution
  }

 protected:
  void visit_rows(const RowVisitor& visit, const Progress& progress) override {
    TextScanner scanner(input_);
    written_.emplace(columns());
    double scale = std::numeric_limits<double>::infinity();  // the smallest of the transforms
    scanners_.clear();
    while (scanner.next_words(words_)) {
      const ScanHeader header = read_scan_header(scanner);
      if (header.was_transposed && !warned_) {
        warn("the transform is stored by columns instead of rows; it was transposed");
        warned_ = true;
      }
      const auto& axis = header.transform[0];
      const auto& translation = header.transform[3];
      if (header.point_count > 0 && header.transform != k_identity)
        scanners_.push_back({.scan = {}, .position = {translation[0], translation[1], translation[2]}});
      scale = std::min(scale, std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]));
      written_->scale = std::isfinite(scale) && scale > 0.0 ? scale : 1.0;
      visit_points(header.point_count, scanner, visit, progress, [&](std::vector<Cell>& row) {
        if (!scanner.next_words(words_)) fail_early(scanner);
        parse_row(scanner, header.transform, row);
      });
    }
  }

 private:
  [[noreturn]] static void fail_early(const TextScanner& scanner) {
    scanner.fail("truncated file", "more lines of the scan", "the end of the file");
  }

  /// The numbers of the line in words_.
  template <std::size_t count>
  std::array<double, count> require_numbers(const TextScanner& scanner, const char* what) const {
    if (words_.size() != count)
      scanner.fail(std::string("invalid PTX header: missing ") + what, std::to_string(count) + " numbers",
                   std::to_string(words_.size()) + " words");
    std::array<double, count> numbers;
    for (std::size_t i = 0; i < count; ++i) {
      numbers[i] = require_cell(scanner, words_[i], ScalarType::float64).number;
      if (!std::isfinite(numbers[i])) scanner.fail("invalid value", "a finite number", quote(words_[i]));
    }
    return numbers;
  }

  std::uint64_t require_grid_size(const TextScanner& scanner, const char* what) const {
    const auto count = words_.size() == 1 ? parse_count(words_[0]) : std::nullopt;
    if (!count)
      scanner.fail(std::string("invalid number of ") + what + " of a scan", "one integer",
                   words_.size() == 1 ? quote(words_[0]) : std::to_string(words_.size()) + " words");
    return *count;
  }

  /// Reads the ten lines; the first one is already in words_.
  ScanHeader read_scan_header(TextScanner& scanner) {
    const auto next = [&] {
      if (!scanner.next_words(words_)) fail_early(scanner);
    };
    const std::uint64_t width = require_grid_size(scanner, "columns");
    next();
    const std::uint64_t height = require_grid_size(scanner, "rows");
    // The shortest line is "0 0 0" and its end, which the last line may lack.
    const std::uint64_t room = (input_.size() - scanner.offset() + 1) / 6;
    if (height > 0 && width > (damage() == Damage::reject ? room : k_most_points) / height)
      throw DamagedFile({.file = input_.name(),
                         .location = fmt::format("line {}", scanner.line_number()),
                         .problem = "truncated file: too short for the points of the scan",
                         .expected = fmt::format("at most {}", room),
                         .found = fmt::format("{} times {}", width, height)});
    for (const char* what : {"the scanner's position", "its x axis", "its y axis", "its z axis"}) {
      next();
      require_numbers<3>(scanner, what);
    }
    ScanHeader header{.point_count = width * height};
    for (auto& line : header.transform) {
      next();
      line = require_numbers<4>(scanner, "the transform");
    }
    check_transform(scanner, header);
    return header;
  }

  /// Checks that the last column of the matrix is 0 0 0 1; transposes it if that is its last row instead.
  static void check_transform(const TextScanner& scanner, ScanHeader& header) {
    Transform& m = header.transform;
    if (m[0][3] == 0.0 && m[1][3] == 0.0 && m[2][3] == 0.0 && m[3][3] == 1.0) return;
    if (m[3] != std::array<double, 4>{0.0, 0.0, 0.0, 1.0})
      scanner.fail("the transform is not rigid", "0 0 0 1 as the last column");
    for (std::size_t row = 0; row < 4; ++row) {
      for (std::size_t column = 0; column < row; ++column) std::swap(m[row][column], m[column][row]);
    }
    header.was_transposed = true;
  }

  std::size_t require_value_count(const TextScanner& scanner) const {
    const std::size_t count = words_.size();
    if (count == 3 || count == 4 || count == 7) return count;
    scanner.fail("invalid point", "x y z, x y z intensity or x y z intensity red green blue",
                 std::to_string(count) + " words");
  }

  /// Scans of one file may differ in their values: missing ones are 0, those that the first scan lacks are
  /// left out.
  void parse_row(const TextScanner& scanner, const Transform& m, std::vector<Cell>& row) {
    const std::size_t count = std::min(require_value_count(scanner), row.size());
    std::ranges::fill(row, Cell{});
    for (std::size_t i = 0; i < count; ++i) row[i] = require_cell(scanner, words_[i], ScalarType::float64);
    const double x = row[0].number, y = row[1].number, z = row[2].number;
    const bool has_return = x != 0.0 || y != 0.0 || z != 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      row[axis].number = has_return ? x * m[0][axis] + y * m[1][axis] + z * m[2][axis] + m[3][axis]
                                    : std::numeric_limits<double>::quiet_NaN();
      if (has_return) written_->add(axis, words_[axis]);
    }
  }

  std::size_t value_count_ = 3;
  bool warned_ = false;
};

}  // namespace

std::unique_ptr<CloudReader> open_ptx(InputFile file, Damage damage) {
  return std::make_unique<PtxReader>(std::move(file), damage);
}

}  // namespace alidade
