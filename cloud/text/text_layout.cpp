// SPDX-License-Identifier: MIT
#include "cloud/text/text_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "base/text_scanner.h"

namespace alidade {

namespace {

using Words = std::vector<std::string_view>;

constexpr std::size_t k_sample_rows = 256;

/// The first points, as numbers; NaN where a word is none.
struct Sample {
  std::vector<std::vector<double>> rows;

  bool all_in(std::size_t column, double low, double high, bool whole) const {
    return std::ranges::all_of(rows, [&](const std::vector<double>& row) {
      const double value = row[column];
      return value >= low && value <= high && (!whole || value == std::floor(value));
    });
  }
  bool holds_numbers(std::size_t column) const {
    return std::ranges::any_of(rows, [&](const auto& row) { return !std::isnan(row[column]); });
  }
  bool holds_color(std::size_t first) const {
    const auto all = [&](double high, bool whole) {
      return all_in(first, 0, high, whole) && all_in(first + 1, 0, high, whole) &&
             all_in(first + 2, 0, high, whole);
    };
    return all(65535.0, true) || all(1.0, false);
  }
  bool holds_normal(std::size_t first) const {
    constexpr double k_tolerance = 0.01;
    bool any = false;
    for (const std::vector<double>& row : rows) {
      const double length_sq =
          row[first] * row[first] + row[first + 1] * row[first + 1] + row[first + 2] * row[first + 2];
      if (length_sq == 0.0) continue;
      if (!(std::abs(length_sq - 1.0) <= k_tolerance)) return false;
      any = true;
    }
    return any;
  }
};

std::vector<TableColumn> unnamed_columns(std::size_t count) {
  std::vector<TableColumn> columns;
  for (std::size_t i = 0; i < count; ++i) columns.push_back({"column_" + std::to_string(i + 1)});
  return columns;
}

/// Layouts after x y z: i intensity, c colour, n normal.
std::vector<std::string_view> layouts_for(std::size_t column_count) {
  switch (column_count) {
    case 4:
      return {"i"};
    case 6:
      return {"n", "c"};
    case 7:
      return {"ic", "ci", "in", "ni"};
    case 9:
      return {"cn", "nc"};
    case 10:
      return {"icn", "cin", "cni"};
    default:
      return {};
  }
}

bool fits(const Sample& sample, std::string_view layout) {
  std::size_t column = 3;
  for (const char part : layout) {
    if (part == 'c' && !sample.holds_color(column)) return false;
    if (part == 'n' && !sample.holds_normal(column)) return false;
    column += part == 'i' ? 1 : 3;
  }
  return true;
}

/// Gives unnamed columns their roles by number and content, and says how they were read unless there was no
/// choice.
void assign_by_content(TextLayout& result, const Sample& sample) {
  std::vector<TableColumn>& columns = result.columns;
  const auto give = [&](std::size_t column, ColumnRole role, const char* name) {
    columns[column] = {name, ScalarType::float64, role};
  };
  std::size_t column = 0;
  const auto give_three = [&](ColumnRole first, const std::array<const char*, 3>& names) {
    for (std::size_t i = 0; i < 3; ++i)
      give(column++, static_cast<ColumnRole>(static_cast<std::size_t>(first) + i), names[i]);
  };
  give_three(ColumnRole::x, {"x", "y", "z"});
  std::string_view layout;
  for (const std::string_view candidate : layouts_for(columns.size())) {
    if (!fits(sample, candidate)) continue;
    layout = candidate;
    break;
  }
  for (const char part : layout) {
    if (part == 'i') give(column++, ColumnRole::intensity, "intensity");
    if (part == 'c') give_three(ColumnRole::red, {"red", "green", "blue"});
    if (part == 'n') give_three(ColumnRole::normal_x, {"normal_x", "normal_y", "normal_z"});
  }
  std::string reading;
  for (const TableColumn& each : columns) reading += (reading.empty() ? "" : " ") + each.name;
  if (columns.size() > 3) result.remarks.push_back("columns have no names; they were read as " + reading);
}

char separator_of(std::string_view line) {
  for (const char separator : {';', ','}) {
    if (line.find(separator) != line.npos) return separator;
  }
  return ' ';
}

std::string_view without_comment_mark(std::string_view line) {
  while (!line.empty() &&
         (line.front() == ' ' || line.front() == '\t' || line.front() == '#' || line.front() == '/'))
    line.remove_prefix(1);
  return line;
}

std::vector<TableColumn> named_columns(const Words& words) {
  std::vector<TableColumn> columns;
  for (std::size_t i = 0; i < words.size(); ++i) {
    columns.push_back({words[i].empty() ? "column_" + std::to_string(i + 1) : std::string(words[i])});
  }
  assign_roles(columns, NameRules::text);
  return columns;
}

bool has_place(const std::vector<TableColumn>& columns) {
  return find_role(columns, ColumnRole::x) && find_role(columns, ColumnRole::y);
}

/// The points from the scanner's place on; count lines of PTS files are passed over. Rows of another width
/// are left to the reader, which tells their line.
Sample take_sample(TextScanner scanner, char separator, std::size_t& column_count) {
  Sample sample;
  Words words;
  while (sample.rows.size() < k_sample_rows) {
    const auto line = scanner.next_line();
    if (!line) break;
    if (is_comment_or_empty(*line)) continue;
    split_line(*line, separator, words);
    if (words.size() == 1) continue;
    if (column_count == 0) {
      require_few_columns(scanner, words.size());
      column_count = words.size();
    }
    if (words.size() != column_count) break;
    std::vector<double>& row = sample.rows.emplace_back();
    for (const std::string_view word : words) row.push_back(parse_number(word).value_or(std::nan("")));
  }
  return sample;
}

/// Columns without numbers cannot be kept.
void leave_out_words(TextLayout& layout, const Sample& sample) {
  for (std::size_t i = 0; i < layout.columns.size() && !sample.rows.empty(); ++i) {
    TableColumn& column = layout.columns[i];
    if (column.role != ColumnRole::extra || sample.holds_numbers(i)) continue;
    column.role = ColumnRole::ignored;
    layout.remarks.push_back("the column " + quote(column.name) + " holds no numbers and was left out");
  }
}

}  // namespace

bool is_comment_or_empty(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  return first == line.npos || line[first] == '#' || line.substr(first).starts_with("//");
}

void split_line(std::string_view line, char separator, std::vector<std::string_view>& words) {
  if (separator == ' ') {
    split_words(line, words);
  } else {
    split_cells(line, separator, words);
    if (words.size() > 1 && words.back().empty()) words.pop_back();
  }
}

TextLayout read_text_layout(InputFile& input) {
  TextScanner scanner(input);
  TextLayout layout;
  layout.format = "XYZ";
  std::string comment;
  std::optional<std::string_view> line;
  while (true) {
    layout.data_place = scanner.place();
    layout.line_count = scanner.line_number();
    line = scanner.next_line();
    if (!line) {
      layout.columns = unnamed_columns(3);
      assign_by_content(layout, {});
      return layout;
    }
    if (!is_comment_or_empty(*line)) break;
    comment = without_comment_mark(*line);
  }

  Words words;
  split_words(*line, words);
  if (words.size() == 1 && parse_count(words[0])) {
    layout.format = "PTS";
    std::size_t column_count = 0;
    const Sample sample = take_sample(scanner, layout.separator, column_count);
    layout.columns = unnamed_columns(std::max<std::size_t>(column_count, 3));
    assign_by_content(layout, sample);
    return layout;
  }

  layout.separator = separator_of(*line);
  split_line(*line, layout.separator, words);
  const bool is_header =
      !std::ranges::all_of(words, [](auto word) { return parse_number(word).has_value(); });
  if (is_header) {
    if (layout.separator == ' ' && line->find('\t') != line->npos) {
      layout.separator = '\t';
      split_line(*line, layout.separator, words);
    }
    require_few_columns(scanner, words.size());
    layout.format = layout.separator == ' ' ? "XYZ" : "CSV";
    layout.columns = named_columns(words);
    if (!has_place(layout.columns))
      scanner.fail("neither a point nor a header of column names",
                   "numbers, or names with x, y and z among them", quote(*line));
    layout.has_names = true;
    layout.data_place = scanner.place();
    layout.line_count = scanner.line_number();
    std::size_t column_count = layout.columns.size();
    leave_out_words(layout, take_sample(scanner, layout.separator, column_count));
    return layout;
  }

  if (words.size() < 3) scanner.fail("too few columns for a point", "at least 3 numbers", quote(*line));
  require_few_columns(scanner, words.size());
  std::size_t column_count = words.size();
  const Sample sample =
      take_sample(TextScanner(input, layout.data_place, layout.line_count), layout.separator, column_count);
  split_line(comment, separator_of(comment), words);
  if (words.size() == column_count) layout.columns = named_columns(words);
  layout.has_names = has_place(layout.columns);
  if (!layout.has_names) {
    layout.columns = unnamed_columns(column_count);
    assign_by_content(layout, sample);
  }
  return layout;
}

}  // namespace alidade
