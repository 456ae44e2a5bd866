// SPDX-License-Identifier: MIT
#include "camera/formats/text_fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/error.h"

namespace alidade {
namespace {

constexpr std::string_view k_blanks = " \t,\r";

[[noreturn]] void fail(const char* what, const std::string& expected, std::string_view found) {
  constexpr std::size_t k_longest = 40;
  std::string text(found.substr(0, k_longest));
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  throw Error({.problem = std::string("bad ") + what,
               .expected = expected,
               .found = found.empty() ? "nothing" : "'" + text + "'"});
}

}  // namespace

bool LineWalk::next(std::string_view& line) {
  if (rest_.empty()) return false;
  const std::size_t end = rest_.find('\n');
  line = rest_.substr(0, end);
  rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  ++number_;
  return true;
}

double number_of(std::string_view text, const char* what) {
  // A plus sign is written by some programs; from_chars does not take it.
  std::string_view digits = text;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value) ||
      digits.starts_with('+'))
    fail(what, "a number", text);
  return value;
}

bool FieldWalk::at_end() {
  rest_.remove_prefix(std::min(rest_.find_first_not_of(k_blanks), rest_.size()));
  return rest_.empty();
}

std::string_view FieldWalk::word(const char* what) {
  if (at_end()) fail(what, "a further value on this line", "");
  const std::size_t end = std::min(rest_.find_first_of(k_blanks), rest_.size());
  const std::string_view word = rest_.substr(0, end);
  rest_.remove_prefix(end);
  return word;
}

double FieldWalk::number(const char* what) {
  return number_of(word(what), what);
}

std::uint64_t FieldWalk::whole_number(const char* what, std::uint64_t most) {
  const std::string_view text = word(what);
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value > most)
    fail(what, "a whole number from 0 to " + std::to_string(most), text);
  return value;
}

std::string_view FieldWalk::rest() {
  if (at_end()) return {};
  const std::string_view text = rest_.substr(0, rest_.find_last_not_of(" \t\r") + 1);
  rest_ = {};
  return text;
}

}  // namespace alidade
