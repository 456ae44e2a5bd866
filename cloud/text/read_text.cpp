// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/csv_table.h"
#include "base/text_scanner.h"
#include "cloud/cloud_reader.h"
#include "cloud/table_reader.h"
#include "cloud/text/text_layout.h"

namespace alidade {
namespace {

constexpr std::uint64_t k_lines_per_report = 1 << 15;
constexpr double k_no_value = std::numeric_limits<double>::quiet_NaN();

class TextReader final : public TableReader {
 public:
  TextReader(InputFile input, TextLayout layout, Damage damage)
      : TableReader(std::move(input), layout.format, damage), layout_(std::move(layout)) {
    facts_.crs = layout_.crs;
    if (layout_.format != "CSV") rules_.intensities = IntensityScale::signed_12_bit;
    set_columns(layout_.columns, "line " + std::to_string(std::max<std::uint64_t>(layout_.title_line, 1)));
    for (const std::string& remark : layout_.remarks) warn(remark);
    for (std::size_t i = 0; i < columns().size(); ++i) {
      const ColumnRole role = columns()[i].role;
      if (role > ColumnRole::normal_z && role < ColumnRole::gps_time && role != ColumnRole::scan_angle)
        without_nan_.push_back(i);
    }
  }

 protected:
  void visit_rows(const RowVisitor& visit, const Progress& progress) override {
    TextScanner scanner(input_, layout_.data_offset, layout_.line_count);
    written_.emplace(columns());
    row_.assign(columns().size(), {});
    word_count_ = 0;
    missing_.assign(columns().size(), 0);
    std::uint64_t announced = 0;  // points of the last count line that are still to come
    while (const auto line = scanner.next_line()) {
      if (scanner.line_number() % k_lines_per_report == 0) report(progress, scanner.offset(), input_.size());
      if (is_comment_or_empty(*line) || scanner.line_number() == layout_.title_line) continue;
      split_line(*line, layout_.separator, row_.size(), words_);
      if (layout_.has_blocks && announced == 0) {
        announced = require_block(scanner);
        continue;
      }
      parse_row(scanner);
      visit(row_);
      if (layout_.has_blocks) --announced;
    }
    if (!std::exchange(warned_, true)) warn_of_values();
    if (announced > 0)
      scanner.fail("truncated file", std::to_string(announced) + " more points, as the count line states");
  }

 private:
  /// The number in a count line of a PTS file, checked against the rest of the file.
  std::uint64_t require_block(const TextScanner& scanner) const {
    const auto count = words_.size() == 1 ? parse_count(words_[0]) : std::nullopt;
    if (!count)
      scanner.fail("more points than the count line states",
                   "the count line of a further block or the end of the file",
                   std::to_string(words_.size()) + " words");
    // A value takes two bytes with the blank behind it, which the last one of the file may lack.
    const std::uint64_t room = (input_.size() - scanner.offset() + 1) / (2 * columns().size());
    if (*count > room && damage() == Damage::reject)
      scanner.fail("truncated file: too short for the points of the count line",
                   "at most " + std::to_string(room), std::to_string(*count));
    return *count;
  }

  void parse_row(const TextScanner& scanner) {
    if (words_.size() != row_.size())
      scanner.fail(words_.size() < row_.size() ? "too few columns" : "too many columns",
                   std::to_string(row_.size()), std::to_string(words_.size()));
    bool is_point = true;
    for (std::size_t i = 0; i < row_.size(); ++i) {
      const TableColumn& column = columns()[i];
      if (column.role == ColumnRole::ignored) continue;
      row_[i].number = parse_cell(scanner, i, column);
      if (column.role <= ColumnRole::z) is_point = is_point && std::isfinite(row_[i].number);
    }
    if (!is_point) return;  // it is left out, and counted there
    for (const std::size_t i : without_nan_)
      if (std::isnan(row_[i].number)) ++missing_[i];
  }

  double parse_cell(const TextScanner& scanner, std::size_t i, const TableColumn& column) {
    std::string_view word = words_[i];
    const bool is_mixed = layout_.has_decimal_commas && word.find('.') != word.npos;
    if (layout_.has_decimal_commas) word = with_point(word, room_);
    if (const auto number = is_mixed ? std::nullopt : parse_number(word)) {
      if (column.role <= ColumnRole::z) written_->add(i, word);
      return *number;
    }
    if (is_missing(word)) return k_no_value;
    if (column.role != ColumnRole::extra || !layout_.has_names)
      scanner.fail("invalid value in the column " + quote(column.name),
                   is_mixed ? "a decimal comma, as before" : "a number", quote(word));
    ++word_count_;
    return k_no_value;
  }

  /// Warns of cells without a number.
  void warn_of_values() {
    if (word_count_ > 0) warn(std::to_string(word_count_) + " invalid numbers were read as NaN");
    for (const std::size_t i : without_nan_) {
      if (missing_[i] > 0)
        warn(fmt::format("{} values of the column {} are missing and were read as 0", missing_[i],
                         quote(columns()[i].name)));
    }
  }

  TextLayout layout_;
  std::uint64_t word_count_ = 0;          ///< cells of extra columns that hold a word instead of a number
  std::vector<std::size_t> without_nan_;  ///< columns of attributes that cannot be NaN
  std::vector<std::uint64_t> missing_;    ///< their cells without a value, by column
  bool warned_ = false;
  std::vector<Cell> row_;
  std::string room_;  ///< for a number whose decimal comma is replaced by a point
};

}  // namespace

std::unique_ptr<CloudReader> open_text(InputFile file, Damage damage) {
  return open_text(std::move(file), damage, {});
}

std::unique_ptr<CloudReader> open_text(InputFile file, Damage damage, std::span<const std::string> columns) {
  TextLayout layout = read_text_layout(file, columns);
  return std::make_unique<TextReader>(std::move(file), std::move(layout), damage);
}

}  // namespace alidade
