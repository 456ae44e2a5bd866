// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_file.h"
#include "base/text_scanner.h"
#include "cloud/cloud_reader.h"
#include "cloud/point_table.h"

namespace alidade {

/// The resolution of the coordinates of a text: the most decimals on each axis.
class WrittenResolution {
 public:
  WrittenResolution() = default;
  explicit WrittenResolution(std::span<const TableColumn> columns)
      : columns_{find_role(columns, ColumnRole::x), find_role(columns, ColumnRole::y),
                 find_role(columns, ColumnRole::z)} {}

  /// Takes the word of a column; ignores words of other columns than coordinates.
  void add(std::size_t column, std::string_view word) {
    for (int axis = 0; axis < 3; ++axis) {
      if (columns_[axis] != column) continue;
      const int decimals = written_decimals(word);
      if (!decimals_[axis] || decimals > *decimals_[axis]) decimals_[axis] = decimals;
    }
  }

  /// Half of the last written digit, per axis, times `scale`; 0 without words.
  glm::dvec3 resolution() const {
    glm::dvec3 result(0.0);
    for (int axis = 0; axis < 3; ++axis) {
      if (decimals_[axis]) result[axis] = 0.5 * std::pow(10.0, -*decimals_[axis]);
    }
    return result * scale;
  }

  double scale = 1.0;  ///< from written coordinates to those of the points

 private:
  std::optional<std::size_t> columns_[3];
  std::optional<int> decimals_[3];
};

/// The result of the first pass over the rows of a point table: the extent of the points, and the ranges of
/// values that need scaling.
struct TableSurvey : CoordinateSurvey {
  ColumnRange colors{}, near_infrared{}, intensities{};
};

/// The rows that the header of a file states.
struct AnnouncedRows {
  std::uint64_t offset = 0;  ///< of the first
  std::uint64_t count = 0;
  std::uint64_t smallest_row = 0;  ///< values of a row of text, else the fewest bytes of a row
  bool is_text = false;
  const char *name = "points", *value_name = "values";  ///< the format's words for rows and values
};

/// Checks that the file has room for the rows. Errors: rows without values; more rows than the file has room
/// for, which is damage.
void check_room(const InputFile& input, const AnnouncedRows& rows, Damage damage);

/// Rejects a binary file that was transferred as text, which inserts a carriage return before every line feed
/// of its points: they begin at `begin`, and there are bytes behind their `end`, if it is known.
void reject_text_transfer(InputFile& input, std::uint64_t begin, std::optional<std::uint64_t> end);

/// What a format states about the values of its rows.
struct TableRules {
  std::optional<std::uint64_t> announced_rows{};              ///< by the header
  const char* reason_to_drop = "without finite coordinates";  ///< of points that are left out, as a clause
  std::optional<ValueScaling> colors{};                       ///< if the file defines it
  IntensityScale intensities = IntensityScale::free;
};

/// Common base of the readers of PLY, PCD and text: a file is a table of points with free coordinates, whose
/// columns have names or a defined order. A format sets its columns and rules and visits the rows; this class
/// does survey and read.
class TableReader : public CloudReader {
 public:
  CoordinateSurvey survey(const Progress& progress) override;
  FileRead read(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                const Progress& progress) override;
  void rest() override { input_.rest(); }

 protected:
  /// Takes one row, a cell for each column.
  using RowVisitor = std::function<void(std::span<const Cell>)>;

  TableReader(InputFile input, std::string format, Damage damage, TableRules rules = {});

  /// Sets the columns, whose roles have been assigned; `location` is that of their names in the file. Adds a
  /// warning if z is missing. Errors: two columns of one name; more than 4096 columns; x or y is missing.
  void set_columns(std::vector<TableColumn> columns, const std::string& location);

  /// Passes every row to `visit`, in order. A point without a position has NaN coordinates. Errors: this row
  /// and those behind it cannot be read.
  virtual void visit_rows(const RowVisitor& visit, const Progress& progress) = 0;

  /// Adds a sentence about this file, for the cloud's warnings.
  void warn(const std::string& clause);
  /// Warns of bytes behind the last point of a binary file. Errors: as reject_text_transfer().
  void check_end(std::uint64_t begin, std::optional<std::uint64_t> end);
  [[noreturn]] void fail(std::string location, std::string problem, std::string expected = {},
                         std::string found = {}) const;

  /// Calls fill(row) and then `visit` for `count` points; progress is the offset of `source`.
  template <class Source, class Fill>
  void visit_points(std::uint64_t count, const Source& source, const RowVisitor& visit,
                    const Progress& progress, const Fill& fill) {
    constexpr std::uint64_t k_points_per_report = 1 << 16;
    std::vector<Cell> row(columns_.size());
    for (std::uint64_t point = 0; point < count; ++point) {
      if (point % k_points_per_report == 0) report(progress, source.offset(), input_.size());
      fill(row);
      visit(row);
    }
  }

  const std::vector<TableColumn>& columns() const { return columns_; }
  /// With Damage::read_over, counts are not checked against the size of the file, which may end early.
  Damage damage() const { return damage_; }
  InputFile input_;
  TableRules rules_;
  std::optional<WrittenResolution> written_;  ///< by the last pass, of text
  std::vector<std::string_view> words_;       ///< of the line that is read, of text
  std::vector<ScannerPosition> scanners_;     ///< by the last pass

 private:
  std::optional<ScalarType> type_of(ColumnRole role) const;
  /// Without z, z is 0; empty if a coordinate is not finite, so that the point is left out.
  std::optional<glm::dvec3> position_of(std::span<const Cell> row) const;
  void warn_of_coarse_floats();
  void visit_whole_rows(const RowVisitor& visit, const Progress& progress);

  std::vector<TableColumn> columns_;
  std::array<std::optional<std::size_t>, 3> axes_{};  ///< columns of x, y and z
  std::vector<std::string> warnings_;
  Damage damage_;
  std::vector<LostPoints> lost_;       ///< in the last pass
  std::optional<TableSurvey> survey_;  ///< after the first pass
};

}  // namespace alidade
