// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/text_scanner.h"
#include "cloud/cloud_reader.h"
#include "cloud/table_reader.h"

namespace alidade {
namespace {

/// How the lines of a text file of points are to be read; found out from its first lines.
///
/// - A first line with one whole number makes a PTS file: blocks of a count line and that many points.
/// - A first line with a word that is not a number is a header of column names. So is a comment right before
///   the points that has a name for each column, x and y among them.
/// - Otherwise columns go by their number and by what the first 256 points hold. Colours are three columns of
///   whole numbers 0 .. 65535 or of numbers 0 .. 1, normals three columns of vectors of length 1 (or 0). The
///   first layout of the list that fits is taken; the columns of others become extra dimensions column_4,
///   column_5, ...
///     3  x y z
///     4  x y z intensity
///     6  x y z normal | x y z color
///     7  x y z intensity color | x y z color intensity | x y z intensity normal | x y z normal intensity
///     9  x y z color normal | x y z normal color
///    10  x y z intensity color normal | x y z color intensity normal | x y z color normal intensity
///
/// Columns are separated by semicolons if the first line has one, else by commas, else by blanks and tabs.
/// Lines that are empty or begin with # or // are left out everywhere.
struct TextLayout {
  std::string format;    ///< "XYZ", "CSV" or "PTS"
  char separator = ' ';  ///< ' ' is any blanks and tabs
  std::vector<TableColumn> columns;
  bool has_names = false;            ///< columns have the file's own names; words in extra columns become NaN
  std::uint64_t data_offset = 0;     ///< first byte of the points or of the first count line
  std::uint64_t line_count = 0;      ///< lines before that
  std::vector<std::string> remarks;  ///< what was assumed, as clauses
};

/// Whether a line holds no data.
bool is_comment_or_empty(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  return first == line.npos || line[first] == '#' || line.substr(first).starts_with("//");
}

/// Splits a line as the layout says. An empty cell after the last separator is left out.
void split_line(std::string_view line, char separator, std::vector<std::string_view>& words) {
  if (separator == ' ') {
    split_words(line, words);
  } else {
    split_cells(line, separator, words);
    if (words.size() > 1 && words.back().empty()) words.pop_back();
  }
}

using Words = std::vector<std::string_view>;

constexpr std::size_t k_sample_rows = 256;

/// The first points, as numbers; NaN for words that are not numbers.
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

/// Layouts after x y z: i intensity, c colour, n normal. Of those with as many columns the first that fits is
/// taken.
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

char separator_of(std::string_view line) {
  for (const char separator : {';', ','}) {
    if (line.find(separator) != line.npos) return separator;
  }
  return ' ';
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

/// The points from the scanner's offset on; count lines of PTS files are passed over. Rows of another width
/// are left to the reader, which reports their line.
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
    layout.remarks.push_back("the column " + quote(column.name) + " contains no numbers and was skipped");
  }
}

/// Errors: a first line of words without the names of coordinates; fewer than three columns; a file without
/// lines has no points and is XYZ.
TextLayout read_text_layout(InputFile& input) {
  TextScanner scanner(input);
  TextLayout layout;
  layout.format = "XYZ";
  std::string comment;
  std::optional<std::string_view> line;
  while (true) {
    layout.data_offset = scanner.offset();
    layout.line_count = scanner.line_number();
    line = scanner.next_line();
    if (!line) {
      layout.columns = unnamed_columns(3);
      assign_by_content(layout, {});
      return layout;
    }
    if (!is_comment_or_empty(*line)) break;
    comment = line->substr(std::min(line->find_first_not_of(" \t#/"), line->size()));
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
      scanner.fail("neither a point nor a header with column names",
                   "numbers, or column names with x, y and z", quote(*line));
    layout.has_names = true;
    layout.data_offset = scanner.offset();
    layout.line_count = scanner.line_number();
    std::size_t column_count = layout.columns.size();
    leave_out_words(layout, take_sample(scanner, layout.separator, column_count));
    return layout;
  }

  if (words.size() < 3) scanner.fail("too few columns for a point", "at least 3 numbers", quote(*line));
  require_few_columns(scanner, words.size());
  std::size_t column_count = words.size();
  const Sample sample =
      take_sample(TextScanner(input, layout.data_offset, layout.line_count), layout.separator, column_count);
  split_line(comment, separator_of(comment), words);
  if (words.size() == column_count) layout.columns = named_columns(words);
  layout.has_names = has_place(layout.columns);
  if (!layout.has_names) {
    layout.columns = unnamed_columns(column_count);
    assign_by_content(layout, sample);
  }
  return layout;
}

constexpr std::uint64_t k_lines_per_report = 1 << 15;

class TextReader final : public TableReader {
 public:
  TextReader(InputFile input, TextLayout layout, Damage damage)
      : TableReader(std::move(input), layout.format, damage), layout_(std::move(layout)) {
    set_columns(layout_.columns, "line " + std::to_string(std::max<std::uint64_t>(layout_.line_count, 1)));
    for (const std::string& remark : layout_.remarks) warn(remark);
  }

 protected:
  void visit_rows(const RowVisitor& visit, const Progress& progress) override {
    TextScanner scanner(input_, layout_.data_offset, layout_.line_count);
    written_.emplace(columns());
    row_.assign(columns().size(), {});
    word_count_ = 0;
    const bool has_blocks = layout_.format == "PTS";
    std::uint64_t announced = 0;  // points that the last count line still promises
    while (const auto line = scanner.next_line()) {
      if (scanner.line_number() % k_lines_per_report == 0) report(progress, scanner.offset(), input_.size());
      if (is_comment_or_empty(*line)) continue;
      split_line(*line, layout_.separator, words_);
      if (has_blocks && announced == 0) {
        announced = require_block(scanner);
        continue;
      }
      parse_row(scanner);
      visit(row_);
      if (has_blocks) --announced;
    }
    if (word_count_ > 0 && !std::exchange(warned_, true))
      warn(std::to_string(word_count_) + " invalid numbers were read as NaN");
    if (announced > 0)
      scanner.fail("truncated file", std::to_string(announced) + " more points, as the count line states");
  }

  IntensityScale intensity_scale() const override {
    return layout_.format == "CSV" ? IntensityScale::free : IntensityScale::signed_12_bit;
  }

 private:
  /// The number in a count line of a PTS file, checked against what is left of the file.
  std::uint64_t require_block(const TextScanner& scanner) const {
    const auto count = words_.size() == 1 ? parse_count(words_[0]) : std::nullopt;
    if (!count)
      scanner.fail("more points than the count line states",
                   "the count line of a further block or the end of the file",
                   std::to_string(words_.size()) + " words");
    // A value takes two bytes with the blank after it; the very last one may lack that.
    const std::uint64_t room = (input_.size() - scanner.offset() + 1) / (2 * columns().size());
    if (*count > room && damage() == Damage::reject)
      scanner.fail("truncated file: too short for the points of the count line",
                   "at most " + std::to_string(room), std::to_string(*count));
    return *count;
  }

  void parse_row(const TextScanner& scanner) {
    // A separator at the end of a line says nothing, unless the last cell is an empty one.
    const bool lacks_last = layout_.separator != ' ' && words_.size() + 1 == row_.size() &&
                            columns().back().role == ColumnRole::extra;
    if (lacks_last) words_.emplace_back();
    if (words_.size() != row_.size())
      scanner.fail(words_.size() < row_.size() ? "too few columns" : "too many columns",
                   std::to_string(row_.size()), std::to_string(words_.size()));
    for (std::size_t i = 0; i < row_.size(); ++i) {
      const ColumnRole role = columns()[i].role;
      if (role == ColumnRole::ignored) continue;
      if (words_[i].empty() && role > ColumnRole::z) {
        row_[i].number = std::numeric_limits<double>::quiet_NaN();
        continue;
      }
      auto number = parse_number(words_[i]);
      if (!number && role == ColumnRole::extra && layout_.has_names) {
        number = std::numeric_limits<double>::quiet_NaN();
        ++word_count_;
      }
      if (!number)
        scanner.fail("invalid value in the column " + quote(columns()[i].name), "a number", quote(words_[i]));
      row_[i].number = *number;
      if (role <= ColumnRole::z) written_->add(i, words_[i]);
    }
  }

  TextLayout layout_;
  std::uint64_t word_count_ = 0;  ///< cells of extra columns that hold a word instead of a number
  bool warned_ = false;
  std::vector<Cell> row_;
};

}  // namespace

std::unique_ptr<CloudReader> open_text(InputFile file, Damage damage) {
  TextLayout layout = read_text_layout(file);
  return std::make_unique<TextReader>(std::move(file), std::move(layout), damage);
}

}  // namespace alidade
