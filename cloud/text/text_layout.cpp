// SPDX-License-Identifier: MIT
#include "cloud/text/text_layout.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/csv_table.h"
#include "base/text_scanner.h"
#include "base/words.h"

namespace alidade {
namespace {

using Words = std::vector<std::string_view>;

constexpr std::size_t k_sample_rows = 256;

bool is_number(std::string_view word) {
  return parse_number(word).has_value() || has_decimal_comma(word);
}

/// The separator of the cells of a row or of titles.
char separator_of(std::string_view line) {
  const auto has = [&](char separator) {
    bool is_quoted = false;
    return std::ranges::any_of(line, [&](char character) {
      if (character == '"') is_quoted = !is_quoted;
      return character == separator && !is_quoted;
    });
  };
  if (has(';')) return ';';
  if (!has(',')) return ' ';
  // Decimal commas, as in "691000,5 5336000,25 500,0": three numbers or more are separated by blanks.
  Words words;
  split_words(line, words);
  return words.size() >= 3 && std::ranges::all_of(words, is_number) ? ' ' : ',';
}

Words split_row(std::string_view line, char separator) {
  Words words;
  split_line(line, separator, 0, words);
  return words;
}

bool is_count(std::string_view line) {
  Words words;
  split_words(line, words);
  return words.size() == 1 && parse_count(words[0]);
}

/// Whether a line is a row of values, not of titles.
bool is_row(std::string_view line) {
  const Words words = split_row(line, separator_of(line));
  return std::ranges::any_of(words, is_number) && std::ranges::all_of(words, [](std::string_view word) {
           return is_number(word) || is_missing(word);
         });
}

/// The first points, as numbers; NaN for words that are not numbers.
struct Sample {
  std::vector<std::vector<double>> rows;
  std::vector<bool> has_words;  ///< per column: has words that are neither numbers nor missing values
  bool has_decimal_commas = false;

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

/// The points from the scanner's offset on, without count lines of PTS files. Ends at a row of another width,
/// for which the reader reports an error with its line.
Sample take_sample(TextScanner scanner, char separator, std::size_t& column_count) {
  Sample sample;
  Words words;
  std::string room;
  while (sample.rows.size() < k_sample_rows) {
    const auto line = scanner.next_line();
    if (!line) break;
    if (is_comment_or_empty(*line)) continue;
    split_line(*line, separator, column_count, words);
    if (words.size() == 1) continue;
    if (column_count == 0) {
      require_few_columns(scanner, words.size());
      column_count = words.size();
    }
    if (words.size() != column_count) break;
    sample.has_words.resize(column_count);
    std::vector<double>& row = sample.rows.emplace_back();
    for (const std::string_view word : words) {
      const bool has_comma = separator != ',' && has_decimal_comma(word);
      sample.has_decimal_commas = sample.has_decimal_commas || has_comma;
      const auto number = parse_number(has_comma ? with_point(word, room) : word);
      if (!number && !is_missing(word)) sample.has_words[row.size()] = true;
      row.push_back(number.value_or(std::nan("")));
    }
  }
  return sample;
}

std::vector<TableColumn> unnamed_columns(std::size_t count) {
  std::vector<TableColumn> columns;
  for (std::size_t i = 0; i < count; ++i) columns.push_back({"column_" + std::to_string(i + 1)});
  return columns;
}

/// Layouts after x y z: i intensity, c colour, n normal. The first one with the right number of columns and
/// fitting values applies.
constexpr std::string_view k_layouts[] = {"i",  "n",  "c",  "ic",  "ci",  "in",
                                          "ni", "cn", "nc", "icn", "cin", "cni"};

bool fits(const Sample& sample, std::string_view layout, std::size_t column_count) {
  const auto width = [](char part) -> std::size_t { return part == 'i' ? 1 : 3; };
  std::size_t column = 3;
  for (const char part : layout) column += width(part);
  if (column != column_count) return false;
  column = 3;
  for (const char part : layout) {
    if (part == 'c' && !sample.holds_color(column)) return false;
    if (part == 'n' && !sample.holds_normal(column)) return false;
    column += width(part);
  }
  return true;
}

/// Assigns roles to unnamed columns by number and content, with a remark if there was a choice.
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
  const auto* const layout = std::ranges::find_if(
      k_layouts, [&](std::string_view candidate) { return fits(sample, candidate, columns.size()); });
  for (const char part : layout == std::end(k_layouts) ? std::string_view() : *layout) {
    if (part == 'i') give(column++, ColumnRole::intensity, "intensity");
    if (part == 'c') give_three(ColumnRole::red, {"red", "green", "blue"});
    if (part == 'n') give_three(ColumnRole::normal_x, {"normal_x", "normal_y", "normal_z"});
  }
  std::string reading;
  for (const TableColumn& each : columns) reading += (reading.empty() ? "" : " ") + each.name;
  if (columns.size() > 3) result.remarks.push_back("unnamed columns were read as " + reading);
}

/// A title without the unit in brackets at its end, and the unit in lower case without blanks and signs.
struct Title {
  std::string name, unit;
};

Title split_title(std::string_view title) {
  for (const std::string_view brackets : {"[]", "()"}) {
    const std::size_t begin = title.rfind(brackets[0]);
    if (begin == title.npos || begin == 0 || title.back() != brackets[1]) continue;
    std::string unit = lower_case(title.substr(begin + 1, title.size() - begin - 2));
    std::erase_if(unit,
                  [](char character) { return character == ' ' || character == '-' || character == '_'; });
    return {std::string(trim(title.substr(0, begin))), unit};
  }
  return {std::string(title), ""};
}

/// The inverse of csv_cell() (base/shown_text.h): without the mark of formulas, and with single quotes.
std::string plain_title(std::string_view cell) {
  cell = trim(cell);
  const bool is_marked =
      cell.size() > 1 && cell[0] == '\'' && std::string_view("=+-@").find(cell[1]) != cell.npos;
  std::string title(cell.substr(is_marked ? 1 : 0));
  for (std::size_t at = title.find("\"\""); at != title.npos; at = title.find("\"\"", at + 1))
    title.erase(at, 1);
  return title;
}

bool is_one_of(std::string_view unit, std::string_view names) {
  Words words;
  split_words(names, words);
  return std::ranges::find(words, unit) != words.end();
}

/// A unit of coordinates.
struct CoordinateUnit {
  std::string_view names;
  const char* title;
  const char* wkt;
};

constexpr CoordinateUnit k_coordinate_units[] = {
    {"m metre metres meter meters", "m", R"(UNIT["metre",1])"},
    {"ft foot feet intft ift", "ft", R"(UNIT["foot",0.3048])"},
    {"usft ftus usfoot usfeet ussurveyfoot ussurveyfeet surveyfoot surveyfeet ussft", "US ft",
     R"(UNIT["US survey foot",0.3048006096012192])"},
    {"deg degree degrees dd \xc2\xb0", "deg", ""},
};
constexpr const CoordinateUnit& k_in_metres = k_coordinate_units[0];
constexpr const CoordinateUnit& k_in_degrees = k_coordinate_units[3];

/// The unit that the title of a coordinate states; null if it states none. Errors: an unknown one.
const CoordinateUnit* unit_of(const TextScanner& scanner, const TextLayout& layout, ColumnRole axis,
                              std::span<const Title> titles) {
  const auto column = find_role(layout.columns, axis);
  if (!column || titles[*column].unit.empty()) return nullptr;
  const auto* const known = std::ranges::find_if(k_coordinate_units, [&](const CoordinateUnit& unit) {
    return is_one_of(titles[*column].unit, unit.names);
  });
  if (known == std::end(k_coordinate_units) || (known == &k_in_degrees && axis == ColumnRole::z))
    scanner.fail("unknown unit of the column " + quote(layout.columns[*column].name), "m, ft or US ft",
                 quote(titles[*column].unit));
  return known;
}

/// Makes feet the unit of a reference system that defines only units, so that everything that measures
/// converts them. Errors: units that are unknown, or differ between x and y.
void take_coordinate_units(const TextScanner& scanner, std::span<const Title> titles, TextLayout& layout) {
  const auto unit = [&](ColumnRole axis) { return unit_of(scanner, layout, axis, titles); };
  const CoordinateUnit *const x = unit(ColumnRole::x), *const y = unit(ColumnRole::y),
                              *z = unit(ColumnRole::z);
  if (x && y && x != y) scanner.fail("x and y are in different units", x->title, y->title);
  const CoordinateUnit& plane = x ? *x : y ? *y : k_in_metres;
  if (&plane == &k_in_degrees) {
    layout.remarks.emplace_back("x and y are degrees of an unknown reference system, which --crs states");
    if (z && z != &k_in_metres)
      layout.remarks.push_back(fmt::format("z is in {}, which --vertical-unit states", z->title));
    return;
  }
  if (!z) z = &plane;
  if (&plane == &k_in_metres && z == &k_in_metres) return;
  layout.crs.wkt =
      fmt::format(R"(LOCAL_CS["unknown, in {}",LOCAL_DATUM["unknown",0],{},AXIS["x",EAST],AXIS["y",NORTH]])",
                  plane.title, plane.wkt);
  if (z == &plane) return;
  layout.crs.wkt = fmt::format(R"(COMPD_CS["unknown, in {} with heights in {}",{},)"
                               R"(VERT_CS["unknown, in {}",VERT_DATUM["unknown",2005],{},AXIS["up",UP]]])",
                               plane.title, z->title, layout.crs.wkt, z->title, z->wkt);
}

/// Makes times and angles in other units extra dimensions.
void take_other_units(std::span<const Title> titles, TextLayout& layout) {
  const auto require = [&](ColumnRole role, std::string_view units, const char* meaning) {
    const auto found = find_role(layout.columns, role);
    if (!found || titles[*found].unit.empty() || is_one_of(titles[*found].unit, units)) return;
    layout.columns[*found].role = ColumnRole::extra;
    layout.remarks.push_back(fmt::format("the column {} is not in {}; it is an extra dimension",
                                         quote(layout.columns[*found].name), meaning));
  };
  require(ColumnRole::gps_time, "s sec secs second seconds", "seconds");
  require(ColumnRole::scan_angle, k_in_degrees.names, "degrees");
}

/// Gives columns these names and their roles. The scanner has the location for errors.
void assign_by_names(const TextScanner& scanner, const Words& words, TextLayout& layout) {
  std::vector<Title> titles;
  layout.columns.clear();
  for (const std::string_view word : words) {
    titles.push_back(split_title(plain_title(word)));
    if (titles.back().name.empty()) titles.back().name = fmt::format("column_{}", titles.size());
    layout.columns.push_back({titles.back().name});
  }
  assign_roles(layout.columns, NameRules::text);
  for (std::size_t i = 0; i < words.size(); ++i)
    if (!trim(words[i]).empty()) layout.columns[i].name = plain_title(words[i]);
  layout.has_names = find_role(layout.columns, ColumnRole::x) && find_role(layout.columns, ColumnRole::y);
  if (!layout.has_names) return;
  take_coordinate_units(scanner, titles, layout);
  take_other_units(titles, layout);
}

/// Leaves out columns without numbers, with a remark.
void leave_out_words(TextLayout& layout, const Sample& sample) {
  for (std::size_t i = 0; i < layout.columns.size() && !sample.rows.empty(); ++i) {
    TableColumn& column = layout.columns[i];
    if (column.role != ColumnRole::extra || sample.holds_numbers(i) || !sample.has_words[i]) continue;
    column.role = ColumnRole::ignored;
    layout.remarks.push_back("the column " + quote(column.name) + " contains no numbers and was skipped");
  }
}

/// The lines before the second point.
struct Preamble {
  std::string comment;                         ///< the last one
  std::string titles;                          ///< the first line of words
  std::string row;                             ///< the first one
  std::uint64_t row_offset = 0, row_line = 0;  ///< byte and number of lines before the row
};

/// Sets data_offset, line_count, has_blocks and title_line of the layout. Errors: a line of words that are
/// not titles.
Preamble read_preamble(TextScanner& scanner, std::span<const std::string> names, TextLayout& layout) {
  Preamble preamble;
  bool is_begun = false;
  while (preamble.row.empty()) {
    const std::uint64_t offset = scanner.offset(), number = scanner.line_number();
    const auto line = scanner.next_line();
    if (!line) break;
    if (is_comment_or_empty(*line)) {
      const std::size_t first = line->find_first_not_of(" \t#/");
      if (first != line->npos) preamble.comment = line->substr(first);
      continue;
    }
    if (!std::exchange(is_begun, true)) layout.data_offset = offset, layout.line_count = number;
    if (is_count(*line)) {
      layout.has_blocks = true;
      continue;
    }
    const bool has_numbers = std::ranges::any_of(split_row(*line, separator_of(*line)), is_number);
    if (preamble.titles.empty() && (names.empty() ? !is_row(*line) : !has_numbers)) {
      preamble.titles = *line;
      layout.title_line = scanner.line_number();
      if (names.empty()) {
        layout.separator = separator_of(*line);
        if (layout.separator == ' ' && line->find('\t') != line->npos) layout.separator = '\t';
        const Words words = split_row(*line, layout.separator);
        require_few_columns(scanner, words.size());
        assign_by_names(scanner, words, layout);
        if (!layout.has_names)
          scanner.fail("neither a point nor a header with column names",
                       "numbers, or column names with x, y and z, also by --columns", quote(*line));
      }
      continue;
    }
    preamble.row = *line;
    preamble.row_offset = offset;
    preamble.row_line = number;
  }
  if (!is_begun) layout.data_offset = scanner.offset(), layout.line_count = scanner.line_number();
  return preamble;
}

}  // namespace

bool is_comment_or_empty(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  return first == line.npos || line[first] == '#' || line.substr(first).starts_with("//");
}

bool is_missing(std::string_view word) {
  constexpr std::string_view k_words[] = {"",     "-",         "na",       "n/a",     "nil",    "null",
                                          "none", "-nan(ind)", "nan(ind)", "1.#qnan", "-1.#ind"};
  return word.size() <= 9 && std::ranges::find(k_words, lower_case(word)) != std::end(k_words);
}

void split_line(std::string_view line, char separator, std::size_t column_count,
                std::vector<std::string_view>& words) {
  if (separator == ' ') return split_words(line, words);
  split_cells(line, separator, words);
  if (words.size() > std::max<std::size_t>(column_count, 1) && words.back().empty()) words.pop_back();
}

TextLayout read_text_layout(InputFile& input, std::span<const std::string> names) {
  TextScanner scanner(input);
  TextLayout layout;
  const Preamble preamble = read_preamble(scanner, names, layout);
  const bool has_titles = layout.has_names;
  if (!has_titles && !preamble.row.empty()) layout.separator = separator_of(preamble.row);
  layout.format = layout.has_blocks ? "PTS" : has_titles && layout.separator != ' ' ? "CSV" : "XYZ";
  std::size_t column_count = layout.columns.size();
  Sample sample;
  if (!preamble.row.empty())
    sample = take_sample(TextScanner(input, preamble.row_offset, preamble.row_line), layout.separator,
                         column_count);
  layout.has_decimal_commas = sample.has_decimal_commas;

  if (!names.empty()) {
    if (column_count != 0 && column_count != names.size())
      scanner.fail("--columns names other columns than there are", fmt::format("{} names", column_count),
                   std::to_string(names.size()));
    assign_by_names(scanner, Words(names.begin(), names.end()), layout);
    if (!layout.has_names)
      scanner.fail("--columns names no coordinates", "x and y", fmt::format("{}", fmt::join(names, ",")));
    if (!preamble.titles.empty())
      layout.remarks.push_back("--columns replaces the titles " + quote(preamble.titles));
  } else if (!has_titles) {
    const Words words = split_row(preamble.comment, separator_of(preamble.comment));
    const bool can_be_titles =
        preamble.row.empty() ? words.size() <= k_most_columns : words.size() == column_count;
    if (can_be_titles) assign_by_names(scanner, words, layout);
  }
  if (layout.has_names) {
    leave_out_words(layout, sample);
    return layout;
  }
  if (!preamble.row.empty() && !layout.has_blocks && column_count < 3)
    scanner.fail("too few columns for a point", "at least 3 numbers", quote(preamble.row));
  layout.columns = unnamed_columns(std::max<std::size_t>(column_count, 3));
  assign_by_content(layout, sample);
  return layout;
}

}  // namespace alidade
