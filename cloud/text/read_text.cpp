// SPDX-License-Identifier: MIT
#include <algorithm>
#include <limits>
#include <utility>

#include "base/text_scanner.h"
#include "cloud/cloud_reader.h"
#include "cloud/table_reader.h"
#include "cloud/text/text_layout.h"

namespace alidade {

namespace {

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
    TextScanner scanner(input_, layout_.data_place, layout_.line_count);
    written_.emplace(columns());
    row_.assign(columns().size(), {});
    word_count_ = 0;
    const bool has_blocks = layout_.format == "PTS";
    std::uint64_t announced = 0;  // points that the last count line still promises
    while (const auto line = scanner.next_line()) {
      if (scanner.line_number() % k_lines_per_report == 0) report(progress, scanner.place(), input_.size());
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
      warn(std::to_string(word_count_) + " words that are no numbers were read as NaN");
    if (announced > 0)
      scanner.fail("the file ends early", std::to_string(announced) + " more points, as the count line says");
  }

  IntensityScale intensity_scale() const override {
    return layout_.format == "CSV" ? IntensityScale::free : IntensityScale::signed_12_bit;
  }

 private:
  /// The number in a count line of a PTS file, checked against what is left of the file.
  std::uint64_t require_block(const TextScanner& scanner) const {
    const auto count = words_.size() == 1 ? parse_count(words_[0]) : std::nullopt;
    if (!count)
      scanner.fail("more points than the count line says",
                   "the count line of a further block or the end of the file",
                   std::to_string(words_.size()) + " words");
    // A value takes two bytes with the blank after it; the very last one may lack that.
    const std::uint64_t room = (input_.size() - scanner.place() + 1) / (2 * columns().size());
    if (*count > room && damage() == Damage::refuse)
      scanner.fail("the file is too short for the points of the count line",
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
        scanner.fail("not a number in the column " + quote(columns()[i].name), "a number", quote(words_[i]));
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
