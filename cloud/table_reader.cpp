// SPDX-License-Identifier: MIT
#include "cloud/table_reader.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "base/bytes.h"
#include "base/error.h"
#include "base/ray.h"
#include "cloud/point_cloud.h"
#include "cloud/rows.h"

namespace alidade {

namespace {

constexpr ColumnRole k_axes[] = {ColumnRole::x, ColumnRole::y, ColumnRole::z};

/// Nearest value of an integer type, clamped to its range; NaN becomes 0.
template <class Integer>
Integer nearest(double value) {
  constexpr double k_low = static_cast<double>(std::numeric_limits<Integer>::min());
  constexpr double k_high = static_cast<double>(std::numeric_limits<Integer>::max());
  if (!(value > k_low)) return value <= k_low ? std::numeric_limits<Integer>::min() : Integer{0};
  return value >= k_high ? std::numeric_limits<Integer>::max() : static_cast<Integer>(std::nearbyint(value));
}

/// Nearest float; numbers that are too large become infinite, as in IEEE 754.
float to_float(double value) {
  constexpr double k_largest = std::numeric_limits<float>::max();
  if (!(std::abs(value) > k_largest)) return static_cast<float>(value);
  return static_cast<float>(std::copysign(std::numeric_limits<double>::infinity(), value));
}

void store_as(ScalarType type, const Cell& cell, std::byte* bytes) {
  with_type(type, [&](auto none) {
    using Value = decltype(none);
    if constexpr (std::is_same_v<Value, double>) {
      store(bytes, cell.number);
    } else if constexpr (std::is_same_v<Value, float>) {
      store(bytes, to_float(cell.number));
    } else if constexpr (k_is_wide<Value>) {
      store(bytes, cell.integer);
    } else {
      store(bytes, nearest<Value>(cell.number));
    }
  });
}

}  // namespace

/// How the values of a table become 0 .. 65535.
struct TableScalings {
  ValueScaling colors, near_infrared, intensities;
};

/// The second pass over the rows of a point table, which fills the columns of a cloud.
class TableAppender : public RowsToFill {
 public:
  /// Appends rows of zeros to `cloud` for the next `count` rows, as far as a piece has room, with the columns
  /// that they need: those of `columns` that are in `wanted`. `pieces` must outlive the object.
  TableAppender(PointCloud& cloud, std::span<const TableColumn> columns, AttributeSet wanted,
                TableScalings scalings, std::uint64_t count, const CloudPieces& pieces)
      : RowsToFill(cloud, attributes_of(columns) & wanted, count, pieces), scalings_(std::move(scalings)) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const TableColumn& column = columns[i];
      const auto attribute = attribute_of(column.role);
      if (!attribute || !wanted.contains(*attribute)) continue;
      Target target{i, column.role, column.type, 0};
      if (column.role == ColumnRole::extra)
        target.dimension = find_extra_dimension(cloud, plain_dimension(column.name, column.type));
      targets_.push_back(target);
    }
    make_rows();
  }

  /// Takes the next row. Returns false as begin_row() does.
  bool add(const glm::dvec3& world, std::span<const Cell> row) {
    if (!begin_row(world)) return false;
    for (const Target& target : targets_) put(target, row[target.column]);
    return true;
  }

 private:
  struct Target {
    std::size_t column;
    ColumnRole role;
    ScalarType type;
    std::size_t dimension;  ///< of the cloud, for ColumnRole::extra
  };

  void put(const Target& target, const Cell& cell) {
    const double number = cell.number;
    const auto set = [](auto& value, const auto& to) { value = to; };
    const auto round = [number]<class Integer>(Integer& value) { value = nearest<Integer>(number); };
    const auto add_flags = [&](int mask, int shift) {
      cloud_.flags[row_] |= static_cast<PointFlags>((nearest<std::uint8_t>(number) & mask) << shift);
    };
    const auto part_behind = [&](ColumnRole first) {
      return static_cast<int>(target.role) - static_cast<int>(first);
    };
    switch (target.role) {
      case ColumnRole::red:
      case ColumnRole::green:
      case ColumnRole::blue:
        return set(cloud_.colors[row_][part_behind(ColumnRole::red)], scalings_.colors.apply(number));
      case ColumnRole::packed_color:
        return set(cloud_.colors[row_], Color16{(cell.integer >> 16 & 255) * 257,
                                                (cell.integer >> 8 & 255) * 257, (cell.integer & 255) * 257});
      case ColumnRole::normal_x:
      case ColumnRole::normal_y:
      case ColumnRole::normal_z:
        return set(cloud_.normals[row_][part_behind(ColumnRole::normal_x)], to_float(number));
      case ColumnRole::near_infrared:
        return set(cloud_.near_infrared[row_], scalings_.near_infrared.apply(number));
      case ColumnRole::intensity:
        return set(cloud_.intensities[row_], scalings_.intensities.apply(number));
      case ColumnRole::classification:
        return round(cloud_.classifications[row_]);
      case ColumnRole::return_number:
        return round(cloud_.returns[row_].number);
      case ColumnRole::return_count:
        return round(cloud_.returns[row_].count);
      case ColumnRole::class_flags:
        return add_flags(15, 0);
      case ColumnRole::scanner_channel:
        return add_flags(3, 4);
      case ColumnRole::scan_direction:
        return add_flags(1, 6);
      case ColumnRole::edge_of_flight_line:
        return add_flags(1, 7);
      case ColumnRole::scan_angle:
        return set(cloud_.scan_angles[row_], to_float(number));
      case ColumnRole::user_data:
        return round(cloud_.user_data[row_]);
      case ColumnRole::point_source_id:
        return round(cloud_.point_source_ids[row_]);
      case ColumnRole::gps_time:
        return set(cloud_.gps_times[row_], number);
      case ColumnRole::extra: {
        ExtraDimension& dimension = cloud_.extra_dimensions[target.dimension];
        const std::size_t bytes = static_cast<std::size_t>(dimension.byte_count);
        store_as(target.type, cell, reinterpret_cast<std::byte*>(dimension.values.data() + row_ * bytes));
        return;
      }
      case ColumnRole::x:
      case ColumnRole::y:
      case ColumnRole::z:
      case ColumnRole::ignored:
        return;
    }
  }

  std::vector<Target> targets_;
  TableScalings scalings_;
};

void check_room(const InputFile& input, const AnnouncedRows& rows, Damage damage) {
  // In text, a value takes two bytes with the blank behind it, which the last one of the file may lack.
  const std::uint64_t left = input.size() - rows.offset, room = rows.is_text ? (left + 1) / 2 : left;
  if (rows.count == 0 || (rows.smallest_row > 0 && rows.count <= room / rows.smallest_row)) return;
  if (rows.smallest_row > 0 && damage == Damage::read_over) return;
  const std::string name = rows.name;
  throw DamagedFile({.file = input.name(),
                     .location = "byte " + std::to_string(rows.offset),
                     .problem = "truncated file: too short for its " + name,
                     .expected = std::to_string(rows.count) + " " + name,
                     .found = rows.smallest_row > 0 ? std::to_string(room / rows.smallest_row)
                                                    : name + " without " + rows.value_name});
}

void reject_text_transfer(InputFile& input, std::uint64_t begin, std::optional<std::uint64_t> end) {
  // Numbers may contain such pairs, in a column of one number at equal distances; but not four others by
  // chance without any other line feed.
  constexpr std::size_t k_tested_bytes = 1 << 20, k_many = 4;
  const std::uint64_t left_over = input.size() - std::min(end.value_or(begin), input.size());
  if (left_over == 0) return;
  const std::span<const std::byte> bytes = input.view_up_to(begin, k_tested_bytes);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::uint64_t pairs = 0;
  std::unordered_set<std::size_t> distances;
  for (std::size_t at = text.find('\n'), next = 0; at != text.npos; at = next, ++pairs) {
    if (at == 0 || text[at - 1] != '\r') return;
    next = text.find('\n', at + 1);
    if (next != text.npos) distances.insert(next - at);
  }
  // Each of them moves the end by a byte.
  const bool is_all = bytes.size() == input.size() - begin;
  const bool explains = end && pairs > 0 && (is_all ? pairs == left_over : pairs <= left_over);
  if (!explains && (pairs < k_many || distances.size() == 1)) return;
  fail_at_byte(input.name(), begin, "the binary data were changed by a transfer as text",
               "a copy that was transferred in binary mode", "a carriage return before every line feed");
}

TableReader::TableReader(InputFile input, std::string format, Damage damage, TableRules rules)
    : input_(std::move(input)), rules_(std::move(rules)), damage_(damage) {
  facts_.file.path = input_.name();
  facts_.file.format = std::move(format);
  facts_.bytes = input_.size();
}

void TableReader::set_columns(std::vector<TableColumn> columns, const std::string& location) {
  std::unordered_set<std::string> names;
  for (const TableColumn& column : columns) {
    if (column.role == ColumnRole::ignored) continue;
    if (!names.insert(column.name).second)
      fail(location, "duplicate column name", "unique names", quote(column.name));
  }
  facts_.attributes = attributes_of(columns);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    axes_[axis] = find_role(columns, k_axes[axis]);
    if (axes_[axis]) facts_.coordinate_types[axis] = columns[*axes_[axis]].type;
  }
  if (!axes_[0]) fail(location, "missing x column", "x, y and z");
  if (!axes_[1]) fail(location, "missing y column", "x, y and z");
  if (!axes_[2]) warn("no z column; using 0");
  columns_ = std::move(columns);
}

std::optional<glm::dvec3> TableReader::position_of(std::span<const Cell> row) const {
  const glm::dvec3 position(row[*axes_[0]].number, row[*axes_[1]].number,
                            axes_[2] ? row[*axes_[2]].number : 0.0);
  return is_finite(position) ? std::optional(position) : std::nullopt;
}

void TableReader::visit_whole_rows(const RowVisitor& visit, const Progress& progress) {
  lost_.clear();
  std::uint64_t rows = 0;
  bool is_visiting = false;
  try {
    visit_rows(
        [&](std::span<const Cell> row) {
          is_visiting = true;
          visit(row);
          is_visiting = false;
          ++rows;
        },
        progress);
  } catch (const Error& error) {
    if (is_visiting) throw;
    if (damage_ == Damage::reject) throw DamagedFile(error.parts());
    const std::uint64_t announced = rules_.announced_rows.value_or(rows);
    lost_.push_back({.count = announced > rows ? announced - rows : 0,
                     .location = error.parts().location,
                     .problem = error.parts().problem});
  }
}

CoordinateSurvey TableReader::survey(const Progress& progress) {
  TableSurvey found;
  std::vector<std::pair<std::size_t, ColumnRange*>> watched;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const ColumnRole role = columns_[i].role;
    if (role >= ColumnRole::red && role <= ColumnRole::blue) watched.emplace_back(i, &found.colors);
    if (role == ColumnRole::near_infrared) watched.emplace_back(i, &found.near_infrared);
    if (role == ColumnRole::intensity) watched.emplace_back(i, &found.intensities);
  }
  const auto add = [&](std::span<const Cell> row) {
    const std::optional<glm::dvec3> position = position_of(row);
    if (!position) {
      ++found.dropped_count;
      return;
    }
    ++found.finite_count;
    found.bounds.grow(*position);
    for (const auto& [column, range] : watched) range->grow(row[column].number);
  };
  visit_whole_rows(add, progress);
  found.resolution = written_ ? written_->resolution() : facts_.resolution(found.bounds);
  survey_ = found;
  return found;
}

FileRead TableReader::read(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                           const Progress& progress) {
  if (!survey_) survey({});
  const auto assume = [&](Attribute attribute, const ValueScaling& scaling) {
    if (wanted.contains(attribute) && !scaling.assumption.empty() && survey_->finite_count > 0)
      warn("assuming that " + scaling.assumption);
    return scaling;
  };
  TableScalings scalings;
  if (const auto type = type_of(ColumnRole::red))
    scalings.colors =
        rules_.colors ? *rules_.colors : assume(Attribute::color, color_scaling(*type, survey_->colors));
  if (const auto type = type_of(ColumnRole::near_infrared))
    scalings.near_infrared = color_scaling(*type, survey_->near_infrared);
  if (const auto type = type_of(ColumnRole::intensity))
    scalings.intensities =
        assume(Attribute::intensity, intensity_scaling(*type, survey_->intensities, rules_.intensities));
  TableAppender appender(cloud, columns_, wanted, std::move(scalings), survey_->finite_count, pieces);
  visit_whole_rows(
      [&](std::span<const Cell> row) {
        const std::optional<glm::dvec3> position = position_of(row);
        if (!position || appender.add(*position, row)) return;
        fail({}, "a point lies outside the lattice, or the file changed while it was read");
      },
      progress);
  if (!appender.complete()) fail({}, "the file changed while it was read");

  if (!written_) warn_of_coarse_floats();
  if (survey_->dropped_count > 0)
    warn(std::to_string(survey_->dropped_count) + " points " + rules_.reason_to_drop + " were skipped");
  cloud.warnings.insert(cloud.warnings.end(), warnings_.begin(), warnings_.end());
  cloud.scanner_positions.insert(cloud.scanner_positions.end(), scanners_.begin(), scanners_.end());
  return read_rows(survey_->finite_count, survey_->dropped_count, lost_);
}

void TableReader::warn_of_coarse_floats() {
  CoordinateSurvey survey = *survey_;
  for (int axis = 0; axis < 3; ++axis)
    if (facts_.coordinate_types[static_cast<std::size_t>(axis)] != ScalarType::float32)
      survey.resolution[axis] = 0.0;
  if (const auto steps = coarse_floats(survey)) warn(*steps);
}

std::optional<ScalarType> TableReader::type_of(ColumnRole role) const {
  const auto column = find_role(columns_, role);
  return column ? std::optional(columns_[*column].type) : std::nullopt;
}

void TableReader::check_end(std::uint64_t begin, std::optional<std::uint64_t> end) {
  reject_text_transfer(input_, begin, end);
  if (end && *end < input_.size())
    warn(std::to_string(input_.size() - *end) + " bytes behind the last point were not read");
}

void TableReader::warn(const std::string& clause) {
  warnings_.push_back(input_.name() + ": " + clause);
}

void TableReader::fail(std::string location, std::string problem, std::string expected,
                       std::string found) const {
  throw Error(input_.name(), std::move(location), std::move(problem), std::move(expected), std::move(found));
}

}  // namespace alidade
