// SPDX-License-Identifier: MIT
#include "cloud/text/write_text.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/output_file.h"
#include "cloud/written_column.h"

namespace alidade {
namespace {

/// 8 if all colours are those of 8 bits, else 16.
int color_bits(const PointCloud& cloud) {
  const auto is_of_8 = [](const Color16& color) {
    return color.x % 257 == 0 && color.y % 257 == 0 && color.z % 257 == 0;
  };
  return std::ranges::all_of(cloud.colors, is_of_8) ? 8 : 16;
}

}  // namespace

void write_text(const std::filesystem::path& path, const PointCloud& cloud, const TextWriteOptions& options) {
  constexpr std::size_t k_points_per_write = 4096;
  OutputFile output(path, options.overwrite);
  std::vector<WrittenColumn> columns = written_columns(cloud, color_bits(cloud));
  if (options.coordinates_alone) columns.resize(3);
  std::array<std::optional<int>, 3> decimals;
  for (int axis = 0; axis < 3; ++axis)
    decimals[static_cast<std::size_t>(axis)] = decimals_of(cloud.lattice, axis);
  const char separator = options.coordinates_alone ? ' ' : ',';
  std::string text;
  for (const WrittenColumn& column : columns) {
    if (options.coordinates_alone) break;
    if (!text.empty()) text += separator;
    text += column.name;
  }
  if (!text.empty()) text += '\n';
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    if (row % k_points_per_write == 0) {
      output.write(std::as_bytes(std::span(text)));
      text.clear();
      report(options.progress, row, cloud.size());
    }
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (i > 0) text += separator;
      const double number = columns[i].value(row);
      if (i < decimals.size() && decimals[i])
        fmt::format_to(std::back_inserter(text), "{:.{}f}", number, *decimals[i]);
      else
        append_number(text, columns[i].type, number);
    }
    text += '\n';
  }
  output.write(std::as_bytes(std::span(text)));
  report(options.progress, cloud.size(), cloud.size());
  output.commit();
}

}  // namespace alidade
