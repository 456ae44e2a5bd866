// SPDX-License-Identifier: MIT
#include "base/json_document.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <tuple>

#include "base/error.h"

namespace alidade {
namespace {

constexpr std::size_t k_deepest = 64;
constexpr std::size_t k_longest_quote = 40;

// Builds the tree from the parser's events. The parser does not tell where a token stands; since it has
// checked the grammar up to the token it reports, the place is found by skipping what may stand between
// tokens.
class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  TreeBuilder(JsonDocument& document, std::span<const std::string_view> unread)
      : document_(document), text_(document.text), unread_(unread) {
    if (text_.starts_with("\xEF\xBB\xBF")) cursor_ = 3;
  }

  bool null() override { return add(nullptr, literal_end(4)); }
  bool boolean(bool value) override { return add(value, literal_end(value ? 4 : 5)); }
  bool number_integer(number_integer_t value) override {
    return add(static_cast<double>(value), number_end());
  }
  bool number_unsigned(number_unsigned_t value) override { return add(std::uint64_t{value}, number_end()); }
  bool number_float(number_float_t value, const string_t&) override { return add(value, number_end()); }
  bool string(string_t& value) override { return add(std::move(value), string_end()); }
  bool binary(binary_t&) override { return false; }

  bool start_object(std::size_t) override { return open(JsonObject{}); }
  bool start_array(std::size_t) override { return open(JsonArray{}); }
  bool end_array() override { return close(); }

  bool end_object() override {
    if (skipped_depth_ > 0) return close();
    check_keys(std::get<JsonObject>(open_.back()->data));
    return close();
  }

  bool key(string_t& key) override {
    const std::size_t begin = token_begin();
    cursor_ = string_end();
    if (skipped_depth_ > 0) return true;
    skips_next_ = std::ranges::find(unread_, key) != unread_.end();
    auto& object = std::get<JsonObject>(open_.back()->data);
    object.push_back({.key = std::move(key), .key_begin = begin, .key_end = cursor_, .value = {}});
    return true;
  }

  bool parse_error(std::size_t position, const std::string&,
                   const nlohmann::json::exception& exception) override {
    std::size_t begin = token_begin();
    std::string problem = exception.what();
    if (exception.id == 406) {
      fail(begin, "number too large", "a number a double can hold", document_.quote(begin, number_end()));
    }
    // "[...] parse error at line 1, column 2: syntax error while parsing value - PROBLEM; expected X" or
    // "... - PROBLEM; last read: 'TEXT'"; of the first parts we know better.
    if (const auto dash = problem.find(" - "); dash != std::string::npos) problem.erase(0, dash + 3);
    if (problem.starts_with("invalid string"))
      begin = std::min(std::max(position, begin + 1) - 1, text_.size());
    std::string expected;
    if (const auto split = problem.find("; expected "); split != std::string::npos) {
      expected = problem.substr(split + 11);
      problem.erase(split);
    }
    if (const auto split = problem.find("; last read"); split != std::string::npos) problem.erase(split);
    fail(begin, "not valid JSON: " + problem, expected, begin >= text_.size() ? "the end of the file" : "");
  }

 private:
  [[noreturn]] void fail(std::size_t byte, std::string problem, std::string expected,
                         std::string found) const {
    throw Error({.file = document_.name,
                 .place = document_.place(byte),
                 .problem = std::move(problem),
                 .expected = std::move(expected),
                 .found = std::move(found)});
  }

  std::size_t token_begin() const {
    return std::min(text_.find_first_not_of(" \t\r\n,:", cursor_), text_.size());
  }
  std::size_t literal_end(std::size_t length) const { return token_begin() + length; }
  std::size_t number_end() const {
    const std::size_t begin = token_begin();
    const std::size_t digits = begin + (text_.compare(begin, 1, "-") == 0 ? 1 : 0);
    // A number that begins with 0 has no further digit before its point.
    if (text_.compare(digits, 1, "0") == 0 && digits + 1 < text_.size() && text_[digits + 1] >= '0' &&
        text_[digits + 1] <= '9') {
      return digits + 1;
    }
    return std::min(text_.find_first_not_of("+-.0123456789eE", begin), text_.size());
  }
  std::size_t string_end() const {
    std::size_t byte = token_begin() + 1;
    while (text_[byte] != '"') byte += text_[byte] == '\\' ? 2 : 1;
    return byte + 1;
  }

  // Where the next value belongs: the document, the open array, or the last key of the open object.
  JsonValue& slot() {
    if (open_.empty()) return document_.root;
    if (auto* array = std::get_if<JsonArray>(&open_.back()->data)) return array->emplace_back();
    return std::get<JsonObject>(open_.back()->data).back().value;
  }

  template <typename Data>
  bool add(Data&& data, std::size_t end) {
    if (skipped_depth_ > 0) {
      cursor_ = end;
      return true;
    }
    if (skips_next_) {
      skips_next_ = false;
      return add(nullptr, end);
    }
    slot() = {.data = std::forward<Data>(data), .begin = token_begin(), .end = end};
    cursor_ = end;
    return true;
  }

  template <typename Data>
  bool open(Data data) {
    const std::size_t begin = token_begin();
    if (open_.size() + skipped_depth_ >= k_deepest) {
      fail(begin, "nested too deeply", "at most " + std::to_string(k_deepest) + " levels", "");
    }
    if (skips_next_ || skipped_depth_ > 0) {
      if (skipped_depth_ == 0) add(nullptr, begin + 1);
      ++skipped_depth_;
      skips_next_ = false;
      cursor_ = begin + 1;
      return true;
    }
    JsonValue& value = slot();
    value = {.data = std::move(data), .begin = begin, .end = begin + 1};
    open_.push_back(&value);
    cursor_ = begin + 1;
    return true;
  }

  bool close() {
    if (skipped_depth_ > 0) {
      --skipped_depth_;
      cursor_ = token_begin() + 1;
      return true;
    }
    cursor_ = open_.back()->end = token_begin() + 1;
    open_.pop_back();
    return true;
  }

  void check_keys(const JsonObject& object) const {
    std::vector<const JsonMember*> sorted;
    for (const JsonMember& member : object) sorted.push_back(&member);
    std::ranges::sort(sorted, [](const JsonMember* a, const JsonMember* b) {
      return std::tie(a->key, a->key_begin) < std::tie(b->key, b->key_begin);
    });
    const auto same_key = [](const JsonMember* a, const JsonMember* b) { return a->key == b->key; };
    const auto twice = std::ranges::adjacent_find(sorted, same_key);
    if (twice == sorted.end()) return;
    const JsonMember& again = *twice[1];
    fail(again.key_begin,
         "key " + document_.quote(again.key_begin, again.key_end) + " stands twice in one object",
         "every key once", "the first at " + document_.place(twice[0]->key_begin));
  }

  JsonDocument& document_;
  const std::string& text_;
  std::span<const std::string_view> unread_;
  std::size_t cursor_ = 0;         // end of the last token
  std::vector<JsonValue*> open_;   // objects and arrays that are not closed yet
  bool skips_next_ = false;        // the next value stands under an unread key
  std::size_t skipped_depth_ = 0;  // objects and arrays open inside such a value
};

bool is_continuation(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0) == 0x80;
}

}  // namespace

std::string JsonDocument::place(std::size_t byte) const {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte, text.size()));
  const auto line = std::count(text.begin(), end, '\n') + 1;
  auto start = end;
  while (start != text.begin() && start[-1] != '\n') --start;
  const auto column = std::count_if(start, end, [](char c) { return !is_continuation(c); }) + 1;
  return std::to_string(line) + ":" + std::to_string(column);
}

std::string JsonDocument::quote(std::size_t begin, std::size_t end) const {
  end = std::min(end, text.size());
  begin = std::min(begin, end);
  const bool cut = end - begin > k_longest_quote;
  if (cut) end = begin + k_longest_quote - 3;
  while (cut && end > begin && is_continuation(text[end])) --end;
  std::string quoted = text.substr(begin, end - begin);
  // DEL is the only control character JSON lets through in a string; line breaks can stand between tokens.
  for (char& c : quoted) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  return quoted + (cut ? "..." : "");
}

JsonDocument parse_json(std::string text, std::string name, std::span<const std::string_view> unread) {
  JsonDocument document{.name = std::move(name), .text = std::move(text), .root = {}};
  TreeBuilder builder(document, unread);
  nlohmann::json::sax_parse(document.text, &builder);
  return document;
}

}  // namespace alidade
