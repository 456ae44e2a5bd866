// SPDX-License-Identifier: MIT
#include "cloud/text/write_text.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "base/output_file.h"
#include "base/shown_text.h"
#include "cloud/written_column.h"

namespace alidade {
namespace {

/// 8 if all colours are multiples of 257, as 8-bit colours are, else 16.
int color_bits(std::size_t point_count, const PointPieces& pieces) {
  const auto is_of_8 = [](const Color16& color) {
    return color.x % 257 == 0 && color.y % 257 == 0 && color.z % 257 == 0;
  };
  for (std::size_t done = 0; done < point_count;) {
    const PointCloud& piece = pieces(done);
    if (piece.colors.empty()) break;
    if (!std::ranges::all_of(piece.colors, is_of_8)) return 16;
    done += piece.size();
  }
  return 8;
}

std::string header(const std::vector<WrittenColumn>& columns) {
  std::string text;
  for (const WrittenColumn& column : columns) text += (text.empty() ? "" : ",") + csv_cell(column.name);
  return text + '\n';
}

/// Appends a line. `decimals` are those of the coordinates, which come first; NaN is an empty cell.
void append_row(std::string& text, const std::vector<WrittenColumn>& columns,
                const std::array<std::optional<int>, 3>& decimals, char separator, std::size_t row) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (i > 0) text += separator;
    const double number = columns[i].value(row);
    if (std::isnan(number)) continue;
    if (i < decimals.size() && decimals[i])
      fmt::format_to(std::back_inserter(text), "{:.{}f}", number, *decimals[i]);
    else
      append_number(text, columns[i].type, number);
  }
  text += '\n';
}

}  // namespace

void write_text(const std::filesystem::path& path, std::size_t point_count, const PointPieces& pieces,
                const TextWriteOptions& options) {
  OutputFile output(path, options.overwrite);
  const int bits = color_bits(point_count, pieces);
  const char separator = options.coordinates_alone ? ' ' : ',';
  std::vector<WrittenColumn> columns;
  std::array<std::optional<int>, 3> decimals;
  write_rows(
      output, point_count, pieces, options.progress,
      [&](const PointCloud& piece, bool is_first) {
        columns = written_columns(piece, bits);
        if (options.coordinates_alone) columns.resize(3);
        for (int axis = 0; axis < 3; ++axis)
          decimals[static_cast<std::size_t>(axis)] = decimals_of(piece.lattice, axis);
        return is_first && !options.coordinates_alone ? header(columns) : "";
      },
      [&](std::string& text, std::size_t row) { append_row(text, columns, decimals, separator, row); });
  output.commit();
}

void write_text(const std::filesystem::path& path, const PointCloud& cloud, const TextWriteOptions& options) {
  write_text(
      path, cloud.size(), [&cloud](std::size_t) -> const PointCloud& { return cloud; }, options);
}

}  // namespace alidade
