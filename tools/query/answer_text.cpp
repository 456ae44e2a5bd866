// SPDX-License-Identifier: MIT
#include "tools/query/answer_text.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "tools/message.h"

namespace alidade {
namespace {

constexpr std::size_t k_grain = 1024;

void add(std::string& text, std::uint64_t value) {
  char digits[20];
  text.append(digits, std::to_chars(std::begin(digits), std::end(digits), value).ptr);
}

void add(std::string& text, double value) {
  char digits[32];
  text.append(digits,
              std::to_chars(std::begin(digits), std::end(digits), value, std::chars_format::general, 17).ptr);
}

void add_value(std::string& text, const AnswerColumn& column, const AnswerRow& row, TextForm form) {
  if (column.whole != nullptr) return add(text, row.*column.whole);
  const double value = column.real != nullptr ? row.*column.real : row.position[column.axis];
  if (form == TextForm::json_lines && !std::isfinite(value)) {
    text += "null";
  } else {
    add(text, value);
  }
}

void add_row(std::string& text, const std::vector<AnswerColumn>& columns, const AnswerRow& row,
             TextForm form) {
  const bool json = form == TextForm::json_lines;
  char separator = json ? '{' : '\0';
  for (const AnswerColumn& column : columns) {
    if (separator != '\0') text += separator;
    separator = ',';
    if (json) text.append("\"").append(column.name).append("\":");
    add_value(text, column, row, form);
  }
  text += json ? "}\n" : "\n";
}

}  // namespace

AnswerText::AnswerText(std::vector<AnswerColumn> columns, TextForm form, std::unique_ptr<OutputFile> file)
    : columns_(std::move(columns)), form_(form), file_(std::move(file)) {
  if (form_ == TextForm::json_lines) return;
  for (const AnswerColumn& column : columns_) header_ += (header_.empty() ? "" : ",") + column.name;
  header_ += "\n";
}

void AnswerText::put(const std::string& text) {
  if (file_) {
    file_->write(std::as_bytes(std::span(text)));
  } else {
    write_to_stdout(text);
  }
}

void AnswerText::put_header() {
  put(std::exchange(header_, {}));
}

void AnswerText::write(const AnswerRows& rows) {
  put_header();
  for (std::size_t begin = 0; begin < rows.size; begin += k_rows_at_once) {
    const std::size_t end = std::min(begin + k_rows_at_once, rows.size);
    std::vector<std::string> parts((end - begin + k_grain - 1) / k_grain);
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t p) {
      const std::size_t first = begin + p * k_grain;
      std::vector<AnswerRow> part_rows(std::min(k_grain, end - first));
      rows.fill(first, part_rows);
      parts[p].reserve(part_rows.size() * 24 * columns_.size());
      for (const AnswerRow& row : part_rows) add_row(parts[p], columns_, row, form_);
    });
    for (const std::string& part : parts) put(part);
  }
}

void AnswerText::finish() {
  put_header();
  if (file_) file_->commit();
}

}  // namespace alidade
