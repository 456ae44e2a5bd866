// SPDX-License-Identifier: MIT
#include "database/sqlite/token_list.h"

#include <algorithm>

namespace alidade {

TokenList::TokenList(std::string_view sql) : sql_(sql), tokens_(sql_tokens(sql)), closing_(tokens_.size()) {
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

std::string_view TokenList::text(std::size_t place) const {
  if (place >= size()) return {};
  return sql_.substr(tokens_[place].begin, tokens_[place].end - tokens_[place].begin);
}

bool TokenList::is_word(std::size_t place, std::string_view word) const {
  return is(place, SqlTokenKind::word) && text(place).size() == word.size() &&
         std::ranges::equal(text(place), word, [](char letter, char small) {
           return (letter >= 'A' && letter <= 'Z' ? letter - 'A' + 'a' : letter) == small;
         });
}

bool TokenList::is_one_of(std::size_t place, std::initializer_list<std::string_view> words) const {
  return std::ranges::any_of(words, [&](std::string_view word) { return is_word(place, word); });
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

}  // namespace alidade
