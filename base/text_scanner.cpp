// SPDX-License-Identifier: MIT
#include "base/text_scanner.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>

#include "base/error.h"

namespace alidade {

namespace {

constexpr std::size_t k_window = 1 << 20;

}  // namespace

bool is_blank(char letter) {
  return letter == ' ' || letter == '\t' || letter == '\r';
}

std::string_view trim(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

TextScanner::TextScanner(InputFile& file, std::uint64_t place, std::uint64_t line_number)
    : file_(file), window_place_(place), line_number_(line_number) {}

std::optional<std::string_view> TextScanner::next_line() {
  const char* start = window_.data() + used_;
  std::size_t left = window_.size() - used_;
  const char* end = left > 0 ? static_cast<const char*>(std::memchr(start, '\n', left)) : nullptr;
  if (!end && window_place_ + window_.size() < file_.size()) {
    window_place_ += used_;
    used_ = 0;
    const auto bytes = file_.view_up_to(window_place_, k_window);
    window_ = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    if (window_place_ == 0 && window_.starts_with(k_byte_order_mark)) used_ = k_byte_order_mark.size();
    start = window_.data() + used_;
    left = window_.size() - used_;
    end = left > 0 ? static_cast<const char*>(std::memchr(start, '\n', left)) : nullptr;
    if (!end && window_place_ + window_.size() < file_.size()) {
      ++line_number_;
      fail("the line does not end", "at most " + std::to_string(k_window) + " bytes in a line");
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
  throw Error({.file = file_.name(),
               .place = "line " + std::to_string(line_number_),
               .problem = std::move(problem),
               .expected = std::move(expected),
               .found = std::move(found)});
}

void require_few_columns(const TextScanner& scanner, std::size_t count) {
  if (count > k_most_columns)
    scanner.fail("too many columns", "at most " + std::to_string(k_most_columns), std::to_string(count));
}

std::optional<double> parse_number(std::string_view word) {
  if (word.starts_with('+')) {
    word.remove_prefix(1);
    if (word.starts_with('-')) return std::nullopt;
  }
  double value = 0.0;
  const char* const end = word.data() + word.size();
  const auto result = std::from_chars(word.data(), end, value);
  if (result.ptr != end || result.ec == std::errc::invalid_argument) return std::nullopt;
  if (result.ec == std::errc::result_out_of_range) {
    const std::size_t mark = word.find_first_of("eE");
    const std::size_t first_digit = word.starts_with('-') ? 1 : 0;
    const bool tiny = mark != word.npos ? word.substr(mark + 1).starts_with('-')
                                        : word[first_digit] == '0' || word[first_digit] == '.';
    if (tiny) return 0.0;
    return (word.front() == '-' ? -1.0 : 1.0) * std::numeric_limits<double>::infinity();
  }
  return value;
}

std::optional<std::uint64_t> parse_count(std::string_view word) {
  std::uint64_t value = 0;
  const char* const end = word.data() + word.size();
  const auto result = std::from_chars(word.data(), end, value);
  if (result.ptr != end || result.ec != std::errc{}) return std::nullopt;
  return value;
}

int written_decimals(std::string_view word) {
  constexpr int k_most = 400;  // beyond what a double can tell apart
  int exponent = 0;
  if (const std::size_t mark = word.find_first_of("eE"); mark != word.npos) {
    const char* first = word.data() + mark + 1;
    const char* const last = word.data() + word.size();
    if (first != last && *first == '+') ++first;
    std::from_chars(first, last, exponent);
    exponent = std::clamp(exponent, -k_most, k_most);
    word = word.substr(0, mark);
  }
  const std::size_t point = word.find('.');
  const std::size_t digits = point == word.npos ? 0 : word.size() - point - 1;
  return static_cast<int>(std::min<std::size_t>(digits, k_most)) - exponent;
}

void split_words(std::string_view line, std::vector<std::string_view>& words) {
  words.clear();
  const char* place = line.data();
  const char* const end = place + line.size();
  while (true) {
    while (place != end && is_blank(*place)) ++place;
    if (place == end) return;
    const char* const start = place;
    while (place != end && !is_blank(*place)) ++place;
    words.emplace_back(start, static_cast<std::size_t>(place - start));
  }
}

void split_cells(std::string_view line, char separator, std::vector<std::string_view>& words) {
  words.clear();
  while (true) {
    while (!line.empty() && is_blank(line.front()) && line.front() != separator) line.remove_prefix(1);
    std::size_t closing = line.npos;
    if (line.starts_with('"')) closing = line.find('"', 1);
    const std::size_t end = line.find(separator, closing == line.npos ? 0 : closing + 1);
    words.push_back(closing == line.npos ? trim(line.substr(0, end)) : line.substr(1, closing - 1));
    if (end == line.npos) return;
    line.remove_prefix(end + 1);
  }
}

Cell require_cell(const TextScanner& scanner, std::string_view word, ScalarType type) {
  if (type == ScalarType::uint64 || type == ScalarType::int64) {
    std::int64_t whole = 0;
    const char* const end = word.data() + word.size();
    if (type == ScalarType::uint64) {
      if (const auto count = parse_count(word)) return {static_cast<double>(*count), *count};
    } else if (const auto result = std::from_chars(word.data(), end, whole);
               result.ptr == end && result.ec == std::errc{}) {
      return {static_cast<double>(whole), static_cast<std::uint64_t>(whole)};
    }
    scanner.fail("not a whole number of 64 bits", "a whole number", quote(word));
  }
  const auto number = parse_number(word);
  if (!number) scanner.fail("not a number", "a number", quote(word));
  return {*number, 0};
}

std::string quote(std::string_view text) {
  constexpr std::size_t k_longest = 40;
  std::string result = "\"";
  for (const char letter : text.substr(0, k_longest))
    result += letter >= ' ' && letter != '\x7f' ? letter : '?';
  if (text.size() > k_longest) result += "...";
  return result + '"';
}

}  // namespace alidade
