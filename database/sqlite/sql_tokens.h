// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

// SQL cut into the tokens that SQLite sees: https://www.sqlite.org/lang_keywords.html tells its quotes,
// lang_comment.html, lang_expr.html its literals and parameters.

namespace alidade {

enum class SqlTokenKind {
  word,         ///< a keyword or a name without quotes
  quoted_name,  ///< "name", `name` or [name]
  text,         ///< 'text'
  blob,         ///< x'00ff'
  number,       ///< 12, 0x0c, .5e-3
  parameter,    ///< ?, ?12, :name, @name, $name
  sign,         ///< an operator, parenthesis, comma, dot or semicolon
  wrong         ///< what SQLite takes for no token
};

/// Bytes [begin, end) of a statement.
struct SqlToken {
  SqlTokenKind kind = SqlTokenKind::wrong;
  std::size_t begin = 0, end = 0;
};

/// All tokens of the text, up to its end or a byte of value 0. White space and comments are none.
std::vector<SqlToken> sql_tokens(std::string_view sql);

/// Line and column of a byte, counted from 1: "2:14".
std::string text_place(std::string_view text, std::size_t byte);

/// A name as SQL compares it: without its quotes, ASCII letters small. `text` is that of a word or quoted
/// name.
std::string plain_name(std::string_view text);

}  // namespace alidade
