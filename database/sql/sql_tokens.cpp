// SPDX-License-Identifier: MIT
#include "database/sql/sql_tokens.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <functional>

#include "base/words.h"

namespace alidade::database {
namespace {

bool is_space(char character) {
  return character == ' ' || (character >= '\t' && character <= '\r' && character != '\v');
}
bool is_digit(char character) {
  return character >= '0' && character <= '9';
}
bool is_hex_digit(char character) {
  return is_digit(character) || (character >= 'a' && character <= 'f') ||
         (character >= 'A' && character <= 'F');
}
bool starts_name(char character) {
  return (character >= 'a' && character <= 'z') || (character >= 'A' && character <= 'Z') ||
         character == '_' || static_cast<unsigned char>(character) >= 0x80;
}
bool in_name(char character) {
  return starts_name(character) || is_digit(character) || character == '$';
}

/// `text` between two marks, with marks within it doubled, so that it cannot end early.
std::string quoted(std::string_view text, char mark) {
  std::string all(1, mark);
  for (const char character : text) all.append(character == mark ? 2 : 1, character);
  return all + mark;
}

class Scanner {
 public:
  explicit Scanner(std::string_view sql) : sql_(sql.substr(0, sql.find('\0'))) {}

  std::vector<SqlToken> tokens() {
    std::vector<SqlToken> found;
    for (skip_blanks(); at_ < sql_.size(); skip_blanks()) {
      const std::size_t begin = at_;
      const SqlTokenKind kind = token();
      found.push_back({kind, begin, at_});
    }
    return found;
  }

 private:
  /// The byte `ahead` bytes after the current one; 0 after the end.
  char peek(std::size_t ahead = 0) const { return at_ + ahead < sql_.size() ? sql_[at_ + ahead] : '\0'; }

  template <class Test>
  void skip_while(const Test& test) {
    while (at_ < sql_.size() && test(sql_[at_])) ++at_;
  }

  void skip_blanks() {
    while (at_ < sql_.size()) {
      if (is_space(peek())) {
        ++at_;
      } else if (sql_.substr(at_).starts_with(k_byte_order_mark)) {
        // Files of other systems begin with a byte order mark, which remains inside when files are joined. To
        // SQLite it is a blank where a token would begin, and a character in a name.
        at_ += k_byte_order_mark.size();
      } else if (peek() == '-' && peek(1) == '-') {
        at_ = std::min(sql_.find('\n', at_), sql_.size());
      } else if (peek() == '/' && peek(1) == '*') {
        // A comment without an end extends to the end of the text.
        const std::size_t end = sql_.find("*/", at_ + 2);
        at_ = end == std::string_view::npos ? sql_.size() : end + 2;
      } else {
        return;
      }
    }
  }

  SqlTokenKind token() {
    const char character = peek();
    if (character == '\'') return quoted('\'', SqlTokenKind::text);
    if (character == '"' || character == '`') return quoted(character, SqlTokenKind::quoted_name);
    if (character == '[') return bracketed();
    if ((character == 'x' || character == 'X') && peek(1) == '\'') return blob();
    if (is_digit(character) || (character == '.' && is_digit(peek(1)))) return number();
    if (character == '?') {
      ++at_;
      skip_while(is_digit);
      return SqlTokenKind::parameter;
    }
    if (character == ':' || character == '@' || character == '$' || character == '#')
      return named_parameter();
    if (starts_name(character)) {
      skip_while(in_name);
      return SqlTokenKind::word;
    }
    return sign();
  }

  /// A quote within is doubled.
  SqlTokenKind quoted(char quote, SqlTokenKind kind) {
    for (++at_; at_ < sql_.size(); ++at_) {
      if (sql_[at_] != quote) continue;
      ++at_;
      if (peek() != quote) return kind;
    }
    return SqlTokenKind::wrong;
  }

  SqlTokenKind bracketed() {
    const std::size_t end = sql_.find(']', at_);
    at_ = end == std::string_view::npos ? sql_.size() : end + 1;
    return end == std::string_view::npos ? SqlTokenKind::wrong : SqlTokenKind::quoted_name;
  }

  SqlTokenKind blob() {
    const std::size_t first = at_ += 2;
    skip_while(is_hex_digit);
    const bool is_whole = (at_ - first) % 2 == 0 && peek() == '\'';
    if (peek() == '\'') ++at_;
    return is_whole ? SqlTokenKind::blob : SqlTokenKind::wrong;
  }

  SqlTokenKind number() {
    if (peek() == '0' && (peek(1) == 'x' || peek(1) == 'X') && is_hex_digit(peek(2))) {
      at_ += 2;
      skip_while(is_hex_digit);
    } else {
      skip_while(is_digit);
      if (peek() == '.') {
        ++at_;
        skip_while(is_digit);
      }
      const std::size_t sign = peek(1) == '+' || peek(1) == '-' ? 1 : 0;
      if ((peek() == 'e' || peek() == 'E') && is_digit(peek(1 + sign))) {
        at_ += 1 + sign;
        skip_while(is_digit);
      }
    }
    if (!in_name(peek())) return SqlTokenKind::number;
    skip_while(in_name);
    return SqlTokenKind::wrong;
  }

  /// In SQLite, names of parameters may have :: and end with something in parentheses, as in Tcl.
  SqlTokenKind named_parameter() {
    ++at_;
    std::size_t characters = 0;
    while (at_ < sql_.size()) {
      if (in_name(peek())) {
        ++characters;
        ++at_;
      } else if (peek() == ':' && peek(1) == ':') {
        at_ += 2;
      } else if (peek() == '(' && characters > 0) {
        skip_while([](char character) { return character != ')' && !is_space(character); });
        if (peek() != ')') return SqlTokenKind::wrong;
        ++at_;
        break;
      } else {
        break;
      }
    }
    return characters > 0 ? SqlTokenKind::parameter : SqlTokenKind::wrong;
  }

  SqlTokenKind sign() {
    constexpr std::array<std::string_view, 10> k_long = {"->>", "->", "<=", "<>", "<<",
                                                         ">=",  ">>", "==", "!=", "||"};
    for (const std::string_view candidate : k_long) {
      if (sql_.substr(at_, candidate.size()) == candidate) {
        at_ += candidate.size();
        return SqlTokenKind::sign;
      }
    }
    constexpr std::string_view k_short = "()+-*/%&|~<>=,;.";
    return k_short.find(sql_[at_++]) == std::string_view::npos ? SqlTokenKind::wrong : SqlTokenKind::sign;
  }

  std::string_view sql_;
  std::size_t at_ = 0;
};

}  // namespace

std::string sql_name(std::string_view name) {
  return quoted(name, '"');
}

std::string sql_text(std::string_view text) {
  return quoted(text, '\'');
}

std::string unquoted(std::string_view text) {
  const char quote = text.front();
  std::string plain;
  for (std::size_t i = 1; i + 1 < text.size(); ++i) {
    plain += text[i];
    if (quote != '[' && text[i] == quote) ++i;
  }
  return plain;
}

std::string text_location(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, byte);
  const std::size_t line_begin = before.rfind('\n') + 1;  // 0 if there is no line before
  return fmt::format("{}:{}", 1 + std::ranges::count(before, '\n'),
                     1 + std::ranges::count_if(before.substr(line_begin), std::not_fn(is_continuation)));
}

std::string plain_name(std::string_view text) {
  const bool is_quoted = text.size() >= 2 && std::string_view("\"`[").find(text.front()) != text.npos;
  return lower_case(is_quoted ? unquoted(text) : text);
}

TokenList::TokenList(std::string_view sql, std::string_view foreign_signs)
    : sql_(sql), tokens_(Scanner(sql).tokens()), closing_(tokens_.size()) {
  for (std::size_t i = 0; i < size(); ++i) {
    if (is(i, SqlTokenKind::wrong) && text(i).size() == 1 &&
        foreign_signs.find(text(i).front()) != std::string_view::npos)
      tokens_[i].kind = SqlTokenKind::sign;
  }
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < size() && is_sound_; ++i) {
    if (is_sign(i, "(")) open.push_back(i);
    if (is(i, SqlTokenKind::wrong) || (is_sign(i, ")") && open.empty())) {
      is_sound_ = false;
    } else if (is_sign(i, ")")) {
      closing_[open.back()] = i;
      open.pop_back();
    }
  }
  is_sound_ = is_sound_ && open.empty();
}

std::string_view TokenList::text(std::size_t index) const {
  if (index >= size()) return {};
  return sql_.substr(tokens_[index].begin, tokens_[index].end - tokens_[index].begin);
}

bool TokenList::is_word(std::size_t index, std::string_view word) const {
  return is(index, SqlTokenKind::word) && text(index).size() == word.size() &&
         lower_case(text(index)) == word && (index == 0 || !is_sign(index - 1, "."));
}

bool TokenList::is_one_of(std::size_t index, std::initializer_list<std::string_view> words) const {
  return std::ranges::any_of(words, [&](std::string_view word) { return is_word(index, word); });
}

std::vector<TokenRange> TokenList::arguments(std::size_t opening) const {
  std::vector<TokenRange> found = {{opening + 1, opening + 1}};
  for (std::size_t i = opening + 1; i < closing(opening); ++i) {
    if (is_sign(i, "(")) i = closing(i);
    found.back().end = i + 1;
    if (is_sign(i, ",")) {
      found.back().end = i;
      found.push_back({i + 1, i + 1});
    }
  }
  return found;
}

}  // namespace alidade::database
