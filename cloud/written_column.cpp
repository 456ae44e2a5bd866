// SPDX-License-Identifier: MIT
#include "cloud/written_column.h"

#include <array>
#include <cassert>
#include <charconv>
#include <iterator>
#include <span>
#include <unordered_map>
#include <unordered_set>

#include "base/output_file.h"
#include "cloud/point_table.h"

namespace alidade {
namespace {

void add_standard(const PointCloud& cloud, int color_bits, std::vector<WrittenColumn>& columns) {
  const auto add = [&](const char* name, ScalarType type, auto value) {
    columns.push_back({name, type, [value](std::size_t i) { return static_cast<double>(value(i)); }});
  };
  const auto add_three = [&](const std::array<const char*, 3>& names, ScalarType type, auto values) {
    for (int part = 0; part < 3; ++part)
      add(names[static_cast<std::size_t>(part)], type, [=](std::size_t i) { return values(i)[part]; });
  };
  add_three({"x", "y", "z"}, ScalarType::float64, [&cloud](std::size_t i) { return cloud.world(i); });
  if (!cloud.normals.empty()) {
    add_three({"nx", "ny", "nz"}, ScalarType::float32, [&cloud](std::size_t i) { return cloud.normals[i]; });
  }
  if (!cloud.colors.empty()) {
    if (color_bits == 8) {
      add_three({"red", "green", "blue"}, ScalarType::uint8,
                [&cloud](std::size_t i) { return (glm::ivec3(cloud.colors[i]) + 128) / 257; });
    } else {
      add_three({"red", "green", "blue"}, ScalarType::uint16,
                [&cloud](std::size_t i) { return cloud.colors[i]; });
    }
  }
  const auto add_column = [&](const char* name, ScalarType type, const auto& column) {
    if (!column.empty()) add(name, type, [&column](std::size_t i) { return column[i]; });
  };
  add_column("near_infrared", ScalarType::uint16, cloud.near_infrared);
  add_column("intensity", ScalarType::uint16, cloud.intensities);
  add_column("classification", ScalarType::uint8, cloud.classifications);
  if (!cloud.returns.empty()) {
    add("return_number", ScalarType::uint8, [&cloud](std::size_t i) { return cloud.returns[i].number; });
    add("number_of_returns", ScalarType::uint8, [&cloud](std::size_t i) { return cloud.returns[i].count; });
  }
  if (!cloud.flags.empty()) {
    const auto add_bits = [&](const char* name, int shift, int mask) {
      add(name, ScalarType::uint8,
          [&cloud, shift, mask](std::size_t i) { return cloud.flags[i] >> shift & mask; });
    };
    add_bits("class_flags", 0, 15);
    add_bits("scan_channel", 4, 3);
    add_bits("scan_direction_flag", 6, 1);
    add_bits("edge_of_flight_line", 7, 1);
  }
  add_column("scan_angle", ScalarType::float32, cloud.scan_angles);
  add_column("user_data", ScalarType::uint8, cloud.user_data);
  add_column("point_source_id", ScalarType::uint16, cloud.point_source_ids);
  add_column("gps_time", ScalarType::float64, cloud.gps_times);
}

/// Whether readers identify a column of this name as a standard one.
bool is_standard_name(const std::string& name) {
  std::vector<TableColumn> columns{{name}};
  assign_roles(columns, NameRules::point_format);
  return columns[0].role != ColumnRole::extra;
}

/// Makes unique names without blanks, none of which is that of a standard column.
class FreeNames {
 public:
  explicit FreeNames(const std::vector<WrittenColumn>& taken) {
    for (const WrittenColumn& column : taken) taken_.insert(column.name);
  }

  /// The name itself if it is free, else with the prefix "extra_", else also with a number behind it.
  std::string take(const std::string& name) {
    std::string free = name.empty() ? "extra" : name;
    for (char& character : free) {
      if (character <= ' ' || character > '~') character = '_';
    }
    if (is_standard_name(free) || !taken_.insert(free).second) {
      const std::string longer = "extra_" + free;
      // Continues from the last number of the name, so that a thousand of one name do not try all numbers.
      int& number = last_number_[longer];
      do {
        ++number;
        free = number == 1 ? longer : longer + '_' + std::to_string(number);
      } while (!taken_.insert(free).second);
    }
    return free;
  }

 private:
  std::unordered_set<std::string> taken_;
  std::unordered_map<std::string, int> last_number_;
};

void add_extra(const PointCloud& cloud, std::vector<WrittenColumn>& columns) {
  FreeNames names(columns);
  for (const ExtraDimension& dimension : cloud.extra_dimensions) {
    if (dimension.type == ScalarType::bytes) continue;
    const bool is_wide = dimension.type == ScalarType::int64 || dimension.type == ScalarType::uint64;
    const bool is_scaled = dimension.has_scale || dimension.has_offset;
    const bool needs_nan = dimension.no_data && dimension.type != ScalarType::float32;
    const auto value = [&dimension](std::size_t i) {
      return meant_number(dimension,
                          dimension.values.data() + i * static_cast<std::size_t>(dimension.byte_count));
    };
    columns.push_back({names.take(dimension.name),
                       is_wide || is_scaled || needs_nan ? ScalarType::float64 : dimension.type, value});
  }
}

}  // namespace

std::vector<WrittenColumn> written_columns(const PointCloud& cloud, int color_bits) {
  std::vector<WrittenColumn> columns;
  add_standard(cloud, color_bits, columns);
  add_extra(cloud, columns);
  return columns;
}

void append_number(std::string& text, ScalarType type, double number) {
  const auto append = [&](auto value) {
    char digits[32];
    text.append(digits, std::to_chars(digits, std::end(digits), value).ptr);
  };
  if (type == ScalarType::float64) return append(number);
  if (type == ScalarType::float32) return append(static_cast<float>(number));
  append(static_cast<std::int64_t>(number));
}

void write_rows(OutputFile& output, std::size_t point_count, const PointPieces& pieces,
                const Progress& progress, const std::function<std::string(const PointCloud&, bool)>& begin,
                const std::function<void(std::string&, std::size_t)>& append) {
  constexpr std::size_t k_rows_per_write = 4096;
  std::size_t done = 0;
  do {
    const PointCloud& piece = pieces(done);
    std::string text = begin(piece, done == 0);
    for (std::size_t row = 0; row < piece.size(); ++row) {
      if (row % k_rows_per_write == 0) {
        output.write(text);
        text.clear();
        report(progress, done + row, point_count);
      }
      append(text, row);
    }
    output.write(text);
    assert(piece.size() > 0 || point_count == 0);
    done += piece.size();
  } while (done < point_count);
  report(progress, point_count, point_count);
}

}  // namespace alidade
