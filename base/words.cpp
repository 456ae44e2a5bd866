// SPDX-License-Identifier: MIT
#include "base/words.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include "base/shown_text.h"

namespace alidade {
namespace {

/// Bytes of a character by its first byte; 0 if none begins so.
std::size_t stated_size(unsigned char first) {
  return first == 0     ? 0
         : first < 0x80 ? 1
         : first < 0xc2 ? 0
         : first < 0xe0 ? 2
         : first < 0xf0 ? 3
         : first < 0xf5 ? 4
                        : 0;
}

}  // namespace

std::size_t utf8_character_size(std::string_view text) {
  if (text.empty()) return 0;
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::size_t size = stated_size(at(0));
  if (size == 0 || size > text.size()) return 0;
  for (std::size_t i = 1; i < size; ++i) {
    if (!is_continuation(text[i])) return 0;
  }
  const bool is_long = (at(0) == 0xe0 && at(1) < 0xa0) || (at(0) == 0xf0 && at(1) < 0x90);
  const bool is_no_character = (at(0) == 0xed && at(1) >= 0xa0) || (at(0) == 0xf4 && at(1) >= 0x90);
  return is_long || is_no_character ? 0 : size;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t size = utf8_character_size(text);
    if (size == 0) return false;
    text.remove_prefix(size);
  }
  return true;
}

std::string_view trim(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string shell_word(std::string_view word) {
  constexpr std::string_view k_plain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-.:/,+@";
  if (!word.empty() && word.find_first_not_of(k_plain) == std::string_view::npos) return std::string(word);
  std::string quoted = "'";
  for (const char character : word)
    quoted += character == '\'' ? std::string("'\\''") : std::string(1, character);
  return quoted + "'";
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

std::optional<std::string> percent_decoded(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    auto character = static_cast<unsigned char>(text[i]);
    if (text[i] == '%') {
      const std::string_view digits = text.substr(i + 1, 2);
      const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), character, 16);
      if (digits.size() != 2 || error != std::errc() || end != digits.data() + 2 || character == 0)
        return std::nullopt;
      i += 2;
    }
    plain.push_back(static_cast<char>(character));
  }
  return plain;
}

int written_decimals(std::string_view word) {
  constexpr int k_most = 400;  // beyond the resolution of a double
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
  const char* cursor = line.data();
  const char* const end = cursor + line.size();
  while (true) {
    while (cursor != end && is_blank(*cursor)) ++cursor;
    if (cursor == end) return;
    const char* const start = cursor;
    while (cursor != end && !is_blank(*cursor)) ++cursor;
    words.emplace_back(start, static_cast<std::size_t>(cursor - start));
  }
}

void split_cells(std::string_view line, char separator, std::vector<std::string_view>& words) {
  words.clear();
  while (true) {
    while (!line.empty() && is_blank(line.front()) && line.front() != separator) line.remove_prefix(1);
    std::size_t closing = line.npos;
    if (line.starts_with('"')) closing = line.find('"', 1);
    // Written twice it is a character of the word.
    while (closing != line.npos && line.substr(closing + 1).starts_with('"'))
      closing = line.find('"', closing + 2);
    const std::size_t end = line.find(separator, closing == line.npos ? 0 : closing + 1);
    words.push_back(closing == line.npos ? trim(line.substr(0, end)) : line.substr(1, closing - 1));
    if (end == line.npos) return;
    line.remove_prefix(end + 1);
  }
}

std::string quote(std::string_view text) {
  constexpr std::size_t k_longest = 40;
  std::size_t end = std::min(text.size(), k_longest);
  for (int i = 0; i < 3 && end < text.size() && is_continuation(text[end]); ++i) --end;
  return '"' + line_text(text.substr(0, end)) + (end < text.size() ? "...\"" : "\"");
}

std::string_view nearest_word(std::string_view word, std::span<const std::string_view> words) {
  // More typing errors than a third of the characters are another word; the limit also bounds the cost for
  // hostile input.
  std::string_view nearest;
  std::size_t nearest_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string_view candidate : words) {
    if (word.size() > candidate.size() + nearest_distance) continue;
    std::vector<std::size_t> before(candidate.size() + 1), previous(candidate.size() + 1),
        row(candidate.size() + 1);
    for (std::size_t j = 0; j <= candidate.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= word.size(); ++i) {
      before.swap(previous);
      previous.swap(row);
      row[0] = i;
      for (std::size_t j = 1; j <= candidate.size(); ++j) {
        const std::size_t change = previous[j - 1] + (word[i - 1] == candidate[j - 1] ? 0 : 1);
        row[j] = std::min({previous[j] + 1, row[j - 1] + 1, change});
        const bool swapped =
            i > 1 && j > 1 && word[i - 1] == candidate[j - 2] && word[i - 2] == candidate[j - 1];
        if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
    // A distance as long as the candidate means that no letter of it is in the word.
    if (row.back() < nearest_distance && row.back() < candidate.size()) {
      nearest = candidate;
      nearest_distance = row.back();
    }
  }
  return nearest;
}

}  // namespace alidade
