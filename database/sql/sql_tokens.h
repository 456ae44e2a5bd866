// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

// Names and texts as SQL writes them, and SQL cut into tokens as SQLite does. Source:
// https://www.sqlite.org/lang_keywords.html (quotes), lang_comment.html, lang_expr.html (literals and
// parameters).

namespace alidade::database {

/// `name` as a name in SQL, whatever its characters: "na""me".
std::string sql_name(std::string_view name);

/// `text` as a literal in SQL: 'te''xt'.
std::string sql_text(std::string_view text);

/// What a quoted name or text means. Requires that it begins and ends with a quote or bracket.
std::string unquoted(std::string_view text);

/// A name as SQL compares it: without its quotes, ASCII letters in lower case. Requires the text of a word or
/// quoted name.
std::string plain_name(std::string_view text);

/// Line and column of a byte, counted from 1: "2:14".
std::string text_location(std::string_view text, std::size_t byte);

enum class SqlTokenKind {
  word,         ///< a keyword or a name without quotes
  quoted_name,  ///< "name", `name` or [name]
  text,         ///< 'text'
  blob,         ///< x'00ff'
  number,       ///< 12, 0x0c, .5e-3
  parameter,    ///< ?, ?12, :name, @name, $name
  sign,         ///< an operator, parenthesis, comma, dot or semicolon
  wrong         ///< not a token of SQLite
};

/// Bytes [begin, end) of a statement.
struct SqlToken {
  SqlTokenKind kind = SqlTokenKind::wrong;
  std::size_t begin = 0, end = 0;
};

/// Tokens [begin, end) of a list.
struct TokenRange {
  std::size_t begin = 0, end = 0;

  bool empty() const { return begin == end; }
};

/// All tokens of a text, up to its end or a byte of value 0, by index. White space and comments are not
/// tokens. Beyond the last one nothing is a word or sign.
class TokenList {
 public:
  /// The text must outlive it. `foreign_signs`: characters that are signs here but not tokens of SQLite.
  explicit TokenList(std::string_view sql, std::string_view foreign_signs = {});

  std::size_t size() const { return tokens_.size(); }
  const SqlToken& operator[](std::size_t index) const { return tokens_[index]; }
  std::string_view text(std::size_t index) const;

  bool is(std::size_t index, SqlTokenKind kind) const {
    return index < size() && tokens_[index].kind == kind;
  }
  bool is_sign(std::size_t index, std::string_view sign) const {
    return is(index, SqlTokenKind::sign) && text(index) == sign;
  }

  /// `word`: in lower case. After a dot any word is a name.
  bool is_word(std::size_t index, std::string_view word) const;
  bool is_one_of(std::size_t index, std::initializer_list<std::string_view> words) const;
  /// Whether it is a name, quoted or not, or a keyword.
  bool is_name(std::size_t index) const {
    return is(index, SqlTokenKind::word) || is(index, SqlTokenKind::quoted_name);
  }

  /// Whether there is no wrong token and parentheses are balanced.
  bool is_sound() const { return is_sound_; }
  /// The closing parenthesis of an opening one. Requires is_sound().
  std::size_t closing(std::size_t opening) const { return closing_[opening]; }

  /// The arguments between commas within parentheses. Requires is_sound().
  std::vector<TokenRange> arguments(std::size_t opening) const;

 private:
  std::string_view sql_;
  std::vector<SqlToken> tokens_;
  std::vector<std::size_t> closing_;
  bool is_sound_ = true;
};

}  // namespace alidade::database
