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

/// How finely the coordinates of a text are written: the most decimals found on each axis.
class WrittenResolution {
 public:
  WrittenResolution() = default;
  explicit WrittenResolution(std::span<const TableColumn> columns)
      : columns_{find_role(columns, ColumnRole::x), find_role(columns, ColumnRole::y),
                 find_role(columns, ColumnRole::z)} {}

  /// Looks at the word in a column; words of other columns than coordinates cost nothing.
  void add(std::size_t column, std::string_view word) {
    for (int axis = 0; axis < 3; ++axis) {
      if (columns_[axis] != column) continue;
      const int decimals = written_decimals(word);
      if (!decimals_[axis] || decimals > *decimals_[axis]) decimals_[axis] = decimals;
    }
  }

  /// Half of the last written digit, per axis; 0 where nothing was written.
  glm::dvec3 resolution() const {
    glm::dvec3 result(0.0);
    for (int axis = 0; axis < 3; ++axis) {
      if (decimals_[axis]) result[axis] = 0.5 * std::pow(10.0, -*decimals_[axis]);
    }
    return result;
  }

 private:
  std::optional<std::size_t> columns_[3];
  std::optional<int> decimals_[3];
};

/// The first pass over the rows of a point table: where the points are and how large the values that need
/// scaling.
struct TableSurvey : CoordinateSurvey {
  ColumnRange colors{}, near_infrared{}, intensities{};
};

/// The rows that the header of a file of points announces.
struct AnnouncedRows {
  std::uint64_t offset = 0;  ///< of the first
  std::uint64_t count = 0;
  std::uint64_t smallest_row = 0;  ///< values of a row as text, else its bytes, at least
  bool is_text = false;
  const char *name = "points", *value_name = "values";  ///< what the format calls them
};

/// Checks that the file has room for them. Errors: rows without values; more rows than that, which is damage.
void check_room(const InputFile& input, const AnnouncedRows& rows, Damage damage);

/// Errors: a binary file that was transferred as text, so that a carriage return was put before every line feed of
/// its points: they begin at `begin`, and bytes are left over behind their `end`, as far as it is known.
void reject_text_transfer(InputFile& input, std::uint64_t begin, std::optional<std::uint64_t> end);

/// What PLY, PCD and the text formats share: a file is a table of points with free coordinates, its columns
/// have names or an agreed order. A format sets its columns and visits the rows; survey and read are done
/// here.
class TableReader : public CloudReader {
 public:
  const CloudFile& file() const override { return description_; }
  AttributeSet attributes() const override { return attributes_of(columns_); }
  /// As the coordinates were written in the last pass, or from the types of the columns.
  glm::dvec3 resolution(const Bounds& bounds) const override;
  CoordinateSurvey survey(const Progress& progress) override;
  void read_in_pieces(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                      const Progress& progress) override;
  std::vector<LostPoints> lost() const override { return lost_; }
  void rest() override { input_.rest(); }

 protected:
  /// Takes one row, a cell for each column.
  using RowVisitor = std::function<void(std::span<const Cell>)>;

  TableReader(InputFile input, std::string format, Damage damage);

  /// Sets the columns, whose roles have been assigned; `location` is that of their names in the file. Errors: two
  /// columns of one name; more than 4096; no x or no y. A missing z is said in the warnings.
  void set_columns(std::vector<TableColumn> columns, const std::string& location);

  /// Shows every row to `visit`, in order. A point without a position has NaN coordinates. An Error means that
  /// this and the following rows cannot be had.
  virtual void visit_rows(const RowVisitor& visit, const Progress& progress) = 0;

  /// How many rows the header says there are, if it does.
  virtual std::optional<std::uint64_t> announced_rows() const { return std::nullopt; }

  /// Says why points were left out, as a clause.
  virtual std::string reason_to_drop() const { return "without finite coordinates"; }

  /// How colours are stored, where the file says so.
  virtual std::optional<ValueScaling> stated_colors() const { return std::nullopt; }

  /// What the format says about intensities.
  virtual IntensityScale intensity_scale() const { return IntensityScale::free; }

  /// Adds a sentence about this file, for the cloud's warnings.
  void warn(const std::string& clause);
  /// Warns of bytes behind the last point of a binary file. Errors: as reject_text_transfer().
  void check_end(std::uint64_t begin, std::optional<std::uint64_t> end);
  [[noreturn]] void fail(std::string location, std::string problem, std::string expected = {},
                         std::string found = {}) const;

  /// Calls fill(row) and then `visit` for `count` points; `source` is at the offset that progress names.
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
  /// With Damage::read_over, counts are not compared with the room in the file: it ends where it ends.
  Damage damage() const { return damage_; }
  InputFile input_;
  CloudFile description_;
  std::optional<WrittenResolution> written_;  ///< by the last pass, of text
  std::vector<std::string_view> words_;       ///< of the line that is read, of text

 private:
  std::optional<ScalarType> type_of(ColumnRole role) const;
  void warn_of_coarse_floats();
  void visit_whole_rows(const RowVisitor& visit, const Progress& progress);

  std::vector<TableColumn> columns_;
  std::vector<std::string> warnings_;
  Damage damage_;
  std::vector<LostPoints> lost_;       ///< in the last pass
  std::optional<TableSurvey> survey_;  ///< after the first pass
};

}  // namespace alidade
