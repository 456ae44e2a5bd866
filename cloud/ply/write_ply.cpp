// SPDX-License-Identifier: MIT
#include "cloud/ply/write_ply.h"

#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/output_file.h"
#include "cloud/point_table.h"
#include "cloud/written_column.h"

namespace alidade {
namespace {

const char* type_name(ScalarType type) {
  // In the order of the types; types that PLY lacks are written as double.
  static constexpr const char* k_names[] = {"double", "uchar",  "char",   "ushort", "short", "uint",
                                            "int",    "double", "double", "float",  "double"};
  return k_names[static_cast<std::size_t>(type)];
}

void append_binary(std::string& text, ScalarType type, double number) {
  with_type(type, [&](auto none) {
    std::byte bytes[sizeof none];
    store(bytes, static_cast<decltype(none)>(number));
    text.append(reinterpret_cast<const char*>(bytes), sizeof bytes);
  });
}

std::string header(std::size_t points, const std::vector<WrittenColumn>& properties, PlyEncoding encoding) {
  std::string text = "ply\nformat ";
  text += encoding == PlyEncoding::ascii ? "ascii 1.0\n" : "binary_little_endian 1.0\n";
  text += "comment written by Alidade\n";
  text += "element vertex " + std::to_string(points) + "\n";
  for (const WrittenColumn& property : properties)
    text += std::string("property ") + type_name(property.type) + " " + property.name + "\n";
  return text + "end_header\n";
}

void append_point(std::string& text, const std::vector<WrittenColumn>& properties, PlyEncoding encoding,
                  std::size_t point) {
  for (std::size_t i = 0; i < properties.size(); ++i) {
    const double number = properties[i].value(point);
    if (encoding == PlyEncoding::ascii) {
      if (i > 0) text += ' ';
      append_number(text, properties[i].type, number);
    } else {
      append_binary(text, properties[i].type, number);
    }
  }
  if (encoding == PlyEncoding::ascii) text += '\n';
}

}  // namespace

void write_ply(const std::filesystem::path& path, std::size_t point_count, const PointPieces& pieces,
               const PlyWriteOptions& options) {
  OutputFile output(path, options.overwrite);
  std::vector<WrittenColumn> properties;
  write_rows(
      output, point_count, pieces, options.progress,
      [&](const PointCloud& piece, bool is_first) {
        properties = written_columns(piece, 8);
        return is_first ? header(point_count, properties, options.encoding) : "";
      },
      [&](std::string& text, std::size_t row) { append_point(text, properties, options.encoding, row); });
  output.commit();
}

void write_ply(const std::filesystem::path& path, const PointCloud& cloud, const PlyWriteOptions& options) {
  write_ply(
      path, cloud.size(), [&cloud](std::size_t) -> const PointCloud& { return cloud; }, options);
}

}  // namespace alidade
