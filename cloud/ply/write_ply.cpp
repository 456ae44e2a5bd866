// SPDX-License-Identifier: MIT
#include "cloud/ply/write_ply.h"

#include <array>
#include <bit>
#include <cassert>
#include <charconv>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "base/bytes.h"
#include "base/output_file.h"
#include "cloud/point_table.h"

namespace alidade {

namespace {

constexpr std::size_t k_points_per_write = 4096;

/// A property of the vertices and where its values come from. Every type but 64-bit integers, which PLY
/// lacks.
struct Property {
  std::string name;
  ScalarType type;
  std::function<double(std::size_t point)> value;
};

const char* type_name(ScalarType type) {
  // In the order of the types; what PLY lacks is written as double.
  static constexpr const char* k_names[] = {"double", "uchar",  "char",   "ushort", "short", "uint",
                                            "int",    "double", "double", "float",  "double"};
  return k_names[static_cast<std::size_t>(type)];
}

void add_standard(const PointCloud& cloud, std::vector<Property>& properties) {
  const auto add = [&](const char* name, ScalarType type, auto value) {
    properties.push_back({name, type, [value](std::size_t i) { return static_cast<double>(value(i)); }});
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
    add_three({"red", "green", "blue"}, ScalarType::uint8,
              [&cloud](std::size_t i) { return (glm::ivec3(cloud.colors[i]) + 128) / 257; });
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

/// Whether readers take a property of this name for one of the standard ones.
bool is_standard_name(const std::string& name) {
  std::vector<TableColumn> columns{{name}};
  assign_roles(columns, NameRules::point_format);
  return columns[0].role != ColumnRole::extra;
}

/// Names without blanks, each given once, and none that a reader mistakes for a standard property.
class FreeNames {
 public:
  explicit FreeNames(const std::vector<Property>& taken) {
    for (const Property& property : taken) taken_.insert(property.name);
  }

  /// The name itself if it is free, else with "extra_" before it, else also with a number behind it.
  std::string take(const std::string& name) {
    std::string free = name.empty() ? "extra" : name;
    for (char& character : free) {
      if (character <= ' ' || character > '~') character = '_';
    }
    if (is_standard_name(free) || !taken_.insert(free).second) {
      const std::string longer = "extra_" + free;
      // Counts on from the last number given, so that a thousand of one name do not try them all.
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

void add_extra(const PointCloud& cloud, std::vector<Property>& properties) {
  FreeNames names(properties);
  for (const ExtraDimension& dimension : cloud.extra_dimensions) {
    if (dimension.type == ScalarType::bytes) continue;
    const bool is_wide = dimension.type == ScalarType::int64 || dimension.type == ScalarType::uint64;
    const bool is_scaled = dimension.has_scale || dimension.has_offset;
    const double scale = dimension.has_scale ? dimension.scale : 1.0;
    const double offset = dimension.has_offset ? dimension.offset : 0.0;
    const auto value = [&dimension, is_scaled, scale, offset](std::size_t i) {
      const auto* bytes = reinterpret_cast<const std::byte*>(
          dimension.values.data() + i * static_cast<std::size_t>(dimension.byte_count));
      const double stored = cell_from(bytes, dimension.type, std::endian::little).number;
      return is_scaled ? offset + scale * stored : stored;
    };
    properties.push_back(
        {names.take(dimension.name), is_wide || is_scaled ? ScalarType::float64 : dimension.type, value});
  }
}

void append_binary(std::string& text, ScalarType type, double number) {
  with_type(type, [&](auto none) {
    std::byte bytes[sizeof none];
    store(bytes, static_cast<decltype(none)>(number));
    text.append(reinterpret_cast<const char*>(bytes), sizeof bytes);
  });
}

/// The shortest digits that give the same number again.
void append_ascii(std::string& text, ScalarType type, double number) {
  const auto append = [&](auto value) {
    char digits[32];
    text.append(digits, std::to_chars(digits, std::end(digits), value).ptr);
  };
  if (type == ScalarType::float64) return append(number);
  if (type == ScalarType::float32) return append(static_cast<float>(number));
  append(static_cast<std::int64_t>(number));
}

std::string header(std::size_t points, const std::vector<Property>& properties, PlyEncoding encoding) {
  std::string text = "ply\nformat ";
  text += encoding == PlyEncoding::ascii ? "ascii 1.0\n" : "binary_little_endian 1.0\n";
  text += "comment written by Alidade\n";
  text += "element vertex " + std::to_string(points) + "\n";
  for (const Property& property : properties)
    text += std::string("property ") + type_name(property.type) + " " + property.name + "\n";
  return text + "end_header\n";
}

void append_point(std::string& text, const std::vector<Property>& properties, PlyEncoding encoding,
                  std::size_t point) {
  for (std::size_t i = 0; i < properties.size(); ++i) {
    const double number = properties[i].value(point);
    if (encoding == PlyEncoding::ascii) {
      if (i > 0) text += ' ';
      append_ascii(text, properties[i].type, number);
    } else {
      append_binary(text, properties[i].type, number);
    }
  }
  if (encoding == PlyEncoding::ascii) text += '\n';
}

}  // namespace

void write_ply(const std::filesystem::path& path, std::size_t point_count, const PlyPieces& pieces,
               const PlyWriteOptions& options) {
  OutputFile output(path, options.overwrite);
  std::size_t done = 0;
  do {
    const PointCloud& piece = pieces(done);
    std::vector<Property> properties;
    add_standard(piece, properties);
    add_extra(piece, properties);
    std::string text = done == 0 ? header(point_count, properties, options.encoding) : "";
    for (std::size_t point = 0; point < piece.size(); ++point) {
      if (point % k_points_per_write == 0) {
        output.write(std::as_bytes(std::span(text)));
        text.clear();
        report(options.progress, done + point, point_count);
      }
      append_point(text, properties, options.encoding, point);
    }
    output.write(std::as_bytes(std::span(text)));
    assert(piece.size() > 0 || point_count == 0);
    done += piece.size();
  } while (done < point_count);
  report(options.progress, point_count, point_count);
  output.commit();
}

void write_ply(const std::filesystem::path& path, const PointCloud& cloud, const PlyWriteOptions& options) {
  write_ply(
      path, cloud.size(), [&cloud](std::size_t) -> const PointCloud& { return cloud; }, options);
}

}  // namespace alidade
