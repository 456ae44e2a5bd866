// SPDX-License-Identifier: MIT
#include "base/text_scanner.h"

#include <cstring>

#include "base/error.h"

namespace alidade {

std::optional<std::string_view> TextScanner::next_line() {
  constexpr std::size_t k_window = 1 << 20;
  const char* start = window_.data() + used_;
  std::size_t left = window_.size() - used_;
  const char* end = left > 0 ? static_cast<const char*>(std::memchr(start, '\n', left)) : nullptr;
  if (!end && window_offset_ + window_.size() < file_.size()) {
    window_offset_ += used_;
    used_ = 0;
    const auto bytes = file_.view_up_to(window_offset_, k_window);
    window_ = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    if (window_offset_ == 0 && window_.starts_with(k_byte_order_mark)) used_ = k_byte_order_mark.size();
    start = window_.data() + used_;
    left = window_.size() - used_;
    end = left > 0 ? static_cast<const char*>(std::memchr(start, '\n', left)) : nullptr;
    if (!end && window_offset_ + window_.size() < file_.size()) {
      ++line_number_;
      fail("line too long", "at most " + std::to_string(k_window) + " bytes");
    }
  }
  if (left == 0) return std::nullopt;
  ++line_number_;
  std::string_view line(start, end ? static_cast<std::size_t>(end - start) : left);
  used_ += line.size() + (end ? 1 : 0);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

bool TextScanner::next_words(std::vector<std::string_view>& words) {
  while (const auto line = next_line()) {
    split_words(*line, words);
    if (!words.empty()) return true;
  }
  return false;
}

void TextScanner::fail(std::string problem, std::string expected, std::string found) const {
  throw Error(file_.name(), "line " + std::to_string(line_number_), std::move(problem), std::move(expected),
              std::move(found));
}

void require_few_columns(const TextScanner& scanner, std::size_t count) {
  if (count > k_most_columns)
    scanner.fail("too many columns", "at most " + std::to_string(k_most_columns), std::to_string(count));
}

}  // namespace alidade
