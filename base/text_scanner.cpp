// SPDX-License-Identifier: MIT
#include "base/text_scanner.h"

#include <algorithm>
#include <cstring>

#include "base/error.h"

namespace alidade {

namespace {

constexpr std::size_t k_window = 1 << 20;

}  // namespace

void reject_utf16(std::string_view start, const std::string& file) {
  constexpr std::size_t k_fewest = 8, k_most = 64;
  start = start.substr(0, k_most);
  const auto is_zero = [&](std::size_t first) {
    for (std::size_t i = first; i < start.size(); i += 2)
      if (start[i] != 0) return false;
    return start.size() >= k_fewest;
  };
  const bool has_mark = start.starts_with("\xff\xfe") || start.starts_with("\xfe\xff");
  if (!has_mark && is_zero(0) == is_zero(1)) return;
  throw file_error(file, "text in UTF-16", "UTF-8 or ASCII: save the file with another encoding");
}

/// Offset of the end of the next line; empty if the window does not contain it.
std::optional<std::size_t> TextScanner::find_end() {
  const auto find = [&](char character, std::size_t end) {
    const void* const found =
        used_ < end ? std::memchr(window_.data() + used_, character, end - used_) : nullptr;
    return found ? static_cast<std::size_t>(static_cast<const char*>(found) - window_.data()) : end;
  };
  // A file of carriage returns would otherwise be searched to its end for every line.
  if (line_feed_ < used_) line_feed_ = find('\n', window_.size());
  const std::size_t end = find('\r', line_feed_);
  // A "\n" may follow behind the window.
  const bool is_open = end + 1 >= window_.size() && window_offset_ + window_.size() < file_.size();
  if (end == window_.size() || (end < line_feed_ && is_open)) return std::nullopt;
  return end;
}

void TextScanner::refill() {
  window_offset_ += used_;
  used_ = 0;
  const auto bytes = file_.view_up_to(window_offset_, k_window + 2);  // with the end of the longest line
  window_ = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  line_feed_ = std::min(window_.find('\n'), window_.size());
  if (window_offset_ > 0) return;
  reject_utf16(window_, file_.name());
  if (window_.starts_with(k_byte_order_mark)) used_ = k_byte_order_mark.size();
}

std::optional<std::string_view> TextScanner::next_line() {
  std::optional<std::size_t> end = find_end();
  if (!end && window_offset_ + window_.size() < file_.size()) {
    refill();
    end = find_end();
    if (!end && window_offset_ + window_.size() < file_.size()) {
      ++line_number_;
      fail("line too long", "at most " + std::to_string(k_window) + " bytes");
    }
  }
  if (used_ == window_.size()) return std::nullopt;
  ++line_number_;
  const std::string_view line = window_.substr(used_, end.value_or(window_.size()) - used_);
  used_ += line.size();
  if (used_ < window_.size() && window_[used_] == '\r') ++used_;
  if (used_ < window_.size() && window_[used_] == '\n') ++used_;
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
