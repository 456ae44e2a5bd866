// SPDX-License-Identifier: MIT
#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "base/input_file.h"
#include "base/ray.h"
#include "base/text_scanner.h"
#include "cloud/cloud_reader.h"
#include "cloud/pcd/pcd_file.h"
#include "cloud/point_table.h"
#include "cloud/table_reader.h"

namespace alidade {

namespace {

constexpr std::uint64_t k_rows_per_report = 1 << 16;

/// A packed colour from text: the bits of a float, or an integer.
std::uint64_t packed_color_from(const Cell& cell, bool is_float) {
  if (is_float) {
    const bool fits = std::abs(cell.number) <= 3.4028234663852886e38;
    return fits ? std::bit_cast<std::uint32_t>(static_cast<float>(cell.number)) : 0;
  }
  if (!std::isfinite(cell.number)) return 0;
  return static_cast<std::uint64_t>(std::clamp(cell.number, -2147483648.0, 4294967295.0) + 4294967296.0) &
         0xffffffff;
}

/// How closely pairs of numbers lie on a rising line.
class Correlation {
 public:
  void add(double x, double y) {
    ++count_;
    x_ += x, y_ += y;
    xx_ += x * x, yy_ += y * y, xy_ += x * y;
  }

  /// From -1 to 1; 0 for numbers that are all equal.
  double value() const {
    const double of_x = count_ * xx_ - x_ * x_, of_y = count_ * yy_ - y_ * y_;
    return of_x > 0.0 && of_y > 0.0 ? (count_ * xy_ - x_ * y_) / std::sqrt(of_x * of_y) : 0.0;
  }

  double count() const { return count_; }

 private:
  double count_ = 0.0, x_ = 0.0, y_ = 0.0, xx_ = 0.0, yy_ = 0.0, xy_ = 0.0;
};

/// Whether the cells of a grid are the pixels of a camera at some viewpoint, with axes right, down, forward.
class PixelGrid {
 public:
  explicit PixelGrid(const PcdViewpoint& viewpoint) : viewpoint_(viewpoint) {}

  void add(std::uint64_t column, std::uint64_t row, const glm::dvec3& point) {
    // Some programs write the camera's position for pixels without a measurement.
    if (point == viewpoint_.position) return;
    const glm::dvec3 seen = (point - viewpoint_.position) * viewpoint_.rotation;
    if (!(seen.z > 0.0)) {
      is_behind_ = true;
      return;
    }
    columns_.add(static_cast<double>(column), seen.x, seen.z);
    rows_.add(static_cast<double>(row), seen.y, seen.z);
  }

  bool is_camera() const { return !is_behind_ && columns_.is_of_camera() && rows_.is_of_camera(); }

  ScannerPosition sensor() const {
    return {.scan = {},
            .position = viewpoint_.position,
            .axes = DepthCameraAxes{.forward = viewpoint_.rotation[2], .down = viewpoint_.rotation[1]}};
  }

 private:
  /// One direction of the grid.
  struct Cells {
    Correlation of_slopes, of_coordinates;

    void add(double cell, double coordinate, double depth) {
      of_slopes.add(cell, coordinate / depth);
      of_coordinates.add(cell, coordinate);
    }
    /// Cells of a height map have equal steps of the coordinate, those of a camera equal steps of the slope.
    bool is_of_camera() const {
      constexpr double k_fewest_points = 16.0, k_least_correlation = 0.99;
      return of_slopes.count() >= k_fewest_points && of_slopes.value() >= k_least_correlation &&
             of_slopes.value() > of_coordinates.value();
    }
  };

  PcdViewpoint viewpoint_;
  Cells columns_, rows_;
  bool is_behind_ = false;
};

class PcdReader final : public TableReader {
 public:
  PcdReader(InputFile input, PcdHeader header, Damage damage)
      : TableReader(std::move(input), "PCD", damage, {.announced_rows = header.point_count}),
        header_(std::move(header)) {
    facts_.file.version = header_.version;
    std::vector<TableColumn> columns;
    std::string skipped;
    bool has_color = false;
    for (const PcdField& field : header_.fields) {
      TableColumn column{field.name, field.type, ColumnRole::extra};
      if (field.name == "_" || field.count != 1) column.role = ColumnRole::ignored;
      if (field.name != "_" && field.count != 1) skipped += (skipped.empty() ? "" : ", ") + quote(field.name);
      // 0xAARRGGBB in four bytes of any type.
      const bool is_color = field.name == "rgb" || field.name == "rgba";
      if (is_color && field.count == 1 && scalar_size(field.type) == 4 && !has_color) {
        column.role = ColumnRole::packed_color;
        has_color = true;
      }
      columns.push_back(std::move(column));
    }
    assign_roles(columns, NameRules::point_format);
    set_columns(std::move(columns), "line " + std::to_string(header_.line_count));
    // A damaged file may have fewer points than it states.
    const std::uint64_t point_size = std::max<std::uint64_t>(header_.point_size(), 1);
    if (header_.format == PcdFormat::binary && header_.point_count <= input_.size() / point_size)
      check_end(header_.data_offset, header_.data_offset + header_.point_count * point_size);
    if (!skipped.empty()) warn("skipped fields with several values per point: " + skipped);
    if (header_.has_invalid_viewpoint)
      warn("the VIEWPOINT is not a position and a quaternion of seven finite numbers, and was ignored");
  }

  FileRead read(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                const Progress& progress) override {
    FileRead done = TableReader::read(cloud, wanted, pieces, progress);
    if (const auto sensor = find_sensor()) cloud.scanner_positions.push_back(*sensor);
    return done;
  }

 protected:
  void visit_rows(const RowVisitor& visit, const Progress& progress) override {
    grids_.clear();
    const auto x = find_role(columns(), ColumnRole::x), y = find_role(columns(), ColumnRole::y),
               z = find_role(columns(), ColumnRole::z);
    if (header_.width < 2 || header_.height < 2 || !z) return visit_stored_rows(visit, progress);
    // Frames are in the axes of their camera or in those of the world, with or without VIEWPOINT.
    grids_.emplace_back(PcdViewpoint());
    if (header_.viewpoint) grids_.emplace_back(*header_.viewpoint);
    std::uint64_t cell = 0;
    visit_stored_rows(
        [&](std::span<const Cell> row) {
          const glm::dvec3 point(row[*x].number, row[*y].number, row[*z].number);
          if (is_finite(point))
            for (PixelGrid& grid : grids_) grid.add(cell % header_.width, cell / header_.width, point);
          ++cell;
          visit(row);
        },
        progress);
  }

 private:
  /// The sensor; empty if unknown. Programs write a VIEWPOINT at the origin if they have none.
  std::optional<ScannerPosition> find_sensor() const {
    for (const PixelGrid& grid : grids_)
      if (grid.is_camera()) return grid.sensor();
    if (!header_.viewpoint || header_.viewpoint->position == glm::dvec3(0.0)) return std::nullopt;
    return ScannerPosition{.scan = {}, .position = header_.viewpoint->position};
  }

  void visit_stored_rows(const RowVisitor& visit, const Progress& progress) {
    switch (header_.format) {
      case PcdFormat::ascii:
        return visit_text(visit, progress);
      case PcdFormat::binary:
        return visit_binary(visit, progress);
      case PcdFormat::binary_compressed:
        return visit_compressed(visit, progress);
    }
  }

  Cell read_cell(const std::byte* bytes, std::size_t column) const {
    const ScalarType type = columns()[column].type;
    if (columns()[column].role == ColumnRole::packed_color)
      return {0.0, load<std::uint32_t>(bytes, std::endian::little)};
    return cell_from(bytes, type, std::endian::little);
  }

  void visit_binary(const RowVisitor& visit, const Progress& progress) {
    ByteCursor cursor(input_, header_.data_offset);
    const std::size_t point_size = static_cast<std::size_t>(header_.point_size());
    visit_points(header_.point_count, cursor, visit, progress, [&](std::vector<Cell>& row) {
      const std::byte* field = cursor.take(point_size);
      for (std::size_t i = 0; i < row.size(); ++i) {
        if (columns()[i].role != ColumnRole::ignored) row[i] = read_cell(field, i);
        field += header_.fields[i].size();
      }
    });
  }

  /// Reads two sizes, then LZF, which decodes to all values of the first field, then all of the second, ...
  void visit_compressed(const RowVisitor& visit, const Progress& progress) {
    const std::vector<std::byte> data = decompress();
    const std::size_t count = data.empty() ? 0 : static_cast<std::size_t>(header_.point_count);
    std::vector<const std::byte*> cursors;  // the next value of each field
    const std::byte* start = data.data();
    for (const PcdField& field : header_.fields) {
      cursors.push_back(start);
      start += static_cast<std::size_t>(field.size()) * count;
    }
    std::vector<Cell> row(header_.fields.size());
    for (std::size_t point = 0; point < count; ++point) {
      if (point % k_rows_per_report == 0) report(progress, input_.size() / count * point, input_.size());
      for (std::size_t i = 0; i < row.size(); ++i) {
        if (columns()[i].role != ColumnRole::ignored) row[i] = read_cell(cursors[i], i);
        cursors[i] += header_.fields[i].size();
      }
      visit(row);
    }
  }

  std::vector<std::byte> decompress() {
    if (header_.point_count == 0) return {};
    ByteCursor cursor(input_, header_.data_offset);
    const std::byte* const sizes = cursor.take(8);
    const std::uint32_t packed = load<std::uint32_t>(sizes, std::endian::little);
    const std::uint32_t unpacked = load<std::uint32_t>(sizes + 4, std::endian::little);
    const std::string location = "byte " + std::to_string(header_.data_offset);
    if (packed > input_.size() - cursor.offset())
      fail(location, "truncated compressed points", std::to_string(packed) + " bytes",
           std::to_string(input_.size() - cursor.offset()));
    const std::uint64_t point_size = header_.point_size();
    if (point_size == 0 || unpacked % point_size != 0 || unpacked / point_size != header_.point_count)
      fail(location, "wrong size of the uncompressed points",
           std::to_string(header_.point_count) + " points of " + std::to_string(point_size) + " bytes",
           std::to_string(unpacked) + " bytes");
    if (unpacked / k_lzf_largest_ratio > packed)
      fail(location, "too few compressed bytes for the points",
           "at least " + std::to_string(unpacked / k_lzf_largest_ratio), std::to_string(packed));
    std::vector<std::byte> data(unpacked);
    if (!decode_lzf({cursor.take(packed), packed}, data)) {
      reject_text_transfer(input_, header_.data_offset, header_.data_offset + 8 + packed);
      fail("byte " + std::to_string(header_.data_offset + 8), "corrupt compressed points");
    }
    input_.rest();  // releases the compressed bytes
    return data;
  }

  void visit_text(const RowVisitor& visit, const Progress& progress) {
    TextScanner scanner(input_, header_.data_offset, header_.line_count);
    written_.emplace(columns());
    std::uint64_t point = 0;
    visit_points(header_.point_count, scanner, visit, progress, [&](std::vector<Cell>& row) {
      if (!scanner.next_words(words_))
        scanner.fail("truncated file", std::to_string(header_.point_count) + " points",
                     std::to_string(point));
      parse_row(scanner, row);
      ++point;
    });
  }

  void parse_row(const TextScanner& scanner, std::vector<Cell>& row) {
    if (words_.size() != header_.value_count())
      scanner.fail("wrong number of values of a point", std::to_string(header_.value_count()),
                   std::to_string(words_.size()));
    std::size_t word = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const TableColumn& column = columns()[i];
      if (column.role == ColumnRole::packed_color) {
        const Cell cell = require_cell(scanner, words_[word], ScalarType::float64);
        // Most programs write the float, some its bits as an integer even if the type is float; the first
        // pass detects which.
        has_float_colors_ =
            has_float_colors_ || (column.type == ScalarType::float32 &&
                                  words_[word].find_first_of(".eE") != std::string_view::npos);
        row[i] = {0.0, packed_color_from(cell, has_float_colors_)};
      } else if (column.role != ColumnRole::ignored) {
        row[i] = require_cell(scanner, words_[word], column.type);
        written_->add(i, words_[word]);
      }
      word += static_cast<std::size_t>(header_.fields[i].count);
    }
  }

  PcdHeader header_;
  bool has_float_colors_ = false;  ///< whether a packed colour in text is written as a float
  std::vector<PixelGrid> grids_;   ///< of the last pass
};

}  // namespace

std::unique_ptr<CloudReader> open_pcd(InputFile file, Damage damage) {
  PcdHeader header = read_pcd_header(file, damage);
  return std::make_unique<PcdReader>(std::move(file), std::move(header), damage);
}

}  // namespace alidade
