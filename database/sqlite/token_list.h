// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "database/sqlite/sql_tokens.h"

namespace alidade {

/// Tokens [begin, end) of a list.
struct TokenRange {
  std::size_t begin = 0, end = 0;
};

/// A statement's tokens, asked by place. Behind the last one nothing is a word or sign.
class TokenList {
 public:
  /// The text must outlive it.
  explicit TokenList(std::string_view sql);

  std::size_t size() const { return tokens_.size(); }
  const SqlToken& operator[](std::size_t place) const { return tokens_[place]; }
  std::string_view text(std::size_t place) const;

  bool is(std::size_t place, SqlTokenKind kind) const {
    return place < size() && tokens_[place].kind == kind;
  }
  bool is_sign(std::size_t place, std::string_view sign) const {
    return is(place, SqlTokenKind::sign) && text(place) == sign;
  }
  /// `word` in small letters.
  bool is_word(std::size_t place, std::string_view word) const;
  bool is_one_of(std::size_t place, std::initializer_list<std::string_view> words) const;
  /// A name, quoted or not; keywords are names here too.
  bool is_name(std::size_t place) const {
    return is(place, SqlTokenKind::word) || is(place, SqlTokenKind::quoted_name);
  }

  /// Whether there is no wrong token and every parenthesis has its other.
  bool is_sound() const { return is_sound_; }
  /// The closing parenthesis to the opening one there. Requires is_sound().
  std::size_t closing(std::size_t opening) const { return closing_[opening]; }

  /// What stands between commas within parentheses. Requires is_sound().
  std::vector<TokenRange> arguments(std::size_t opening) const;

 private:
  std::string_view sql_;
  std::vector<SqlToken> tokens_;
  std::vector<std::size_t> closing_;
  bool is_sound_ = true;
};

}  // namespace alidade
