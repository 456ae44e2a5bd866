// SPDX-License-Identifier: MIT
#include "base/json.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>

#include "base/error.h"
#include "base/shown_text.h"
#include "base/words.h"

namespace alidade {
namespace {

constexpr std::size_t k_deepest = 64;
constexpr std::size_t k_longest_quote = 40;

// Builds the tree from the parser's events. The parser does not report where tokens begin. Since it has
// checked the grammar up to the token it reports, the beginning is found by skipping the characters allowed
// between tokens.
class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  TreeBuilder(JsonDocument& document, std::span<const std::string_view> unread)
      : document_(document), text_(document.text), unread_(unread) {
    if (text_.starts_with(k_byte_order_mark)) cursor_ = k_byte_order_mark.size();
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
      fail(begin, "number out of range", "a number in the range of a double",
           document_.quote(begin, number_end()));
    }
    // "[...] parse error at line 1, column 2: syntax error while parsing value - PROBLEM; expected X" or
    // "... - PROBLEM; last read: 'TEXT'". The parts before " - " are replaced.
    if (const auto dash = problem.find(" - "); dash != std::string::npos) problem.erase(0, dash + 3);
    if (problem.starts_with("invalid string"))
      begin = std::min(std::max(position, begin + 1) - 1, text_.size());
    std::string expected;
    if (const auto split = problem.find("; expected "); split != std::string::npos) {
      expected = problem.substr(split + 11);
      problem.erase(split);
    }
    if (const auto split = problem.find("; last read"); split != std::string::npos) problem.erase(split);
    fail(begin, "invalid JSON: " + problem, expected, begin >= text_.size() ? "the end of the file" : "");
  }

 private:
  [[noreturn]] void fail(std::size_t byte, std::string problem, std::string expected,
                         std::string found) const {
    throw Error(document_.name, document_.line_and_column(byte), std::move(problem), std::move(expected),
                std::move(found));
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
      fail(begin, "too many nested levels", "at most " + std::to_string(k_deepest) + " levels", "");
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
         "duplicate key " + document_.quote(again.key_begin, again.key_end) + ", first at " +
             document_.line_and_column(twice[0]->key_begin),
         "unique keys", "");
  }

  JsonDocument& document_;
  const std::string& text_;
  std::span<const std::string_view> unread_;
  std::size_t cursor_ = 0;         // end of the last token
  std::vector<JsonValue*> open_;   // objects and arrays that are not closed yet
  bool skips_next_ = false;        // the next value is that of an unread key
  std::size_t skipped_depth_ = 0;  // objects and arrays open inside such a value
};

std::string list_of(std::span<const std::string_view> words) {
  std::string list;
  for (const std::string_view word : words) list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", word);
  return words.size() == 1 ? list : "one of " + list;
}

// JSON pointer (RFC 6901): ~ and / inside a key are written ~0 and ~1.
std::string pointer_step(std::string_view key) {
  std::string step = "/";
  for (const char c : key) step += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return step;
}

std::string did_you_mean(std::string_view word, std::span<const std::string_view> words) {
  const std::string_view nearest = nearest_word(word, words);
  return nearest.empty() ? "" : fmt::format(", did you mean \"{}\"?", nearest);
}

}  // namespace

std::string JsonDocument::line_and_column(std::size_t byte) const {
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
  // Line breaks can be between tokens.
  std::ranges::replace_if(
      quoted, [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
  return line_text(quoted) + (cut ? "..." : "");
}

JsonDocument parse_json(std::string text, std::string name, std::span<const std::string_view> unread) {
  JsonDocument document{.name = std::move(name), .text = std::move(text), .root = {}};
  TreeBuilder builder(document, unread);
  nlohmann::json::sax_parse(document.text, &builder);
  return document;
}

bool NumberRange::contains(double value) const {
  return (above_minimum ? value > minimum : value >= minimum) &&
         (below_maximum ? value < maximum : value <= maximum);
}

std::string NumberRange::describe() const {
  if (!above_minimum && !below_maximum) return fmt::format("from {} to {}", minimum, maximum);
  return fmt::format("{} {} and {} {}", above_minimum ? "greater than" : "at least", minimum,
                     below_maximum ? "less than" : "at most", maximum);
}

void JsonNode::fail_at(std::size_t byte, const std::string& problem, const std::string& expected,
                       const std::string& found, const std::string& pointer) const {
  throw Error({.file = document_->name,
               .location = document_->line_and_column(byte),
               .problem = fmt::format("{} (at {})", problem, pointer.empty() ? "the top" : pointer),
               .expected = expected,
               .found = found});
}

void JsonNode::fail(const std::string& problem, const std::string& expected,
                    const std::optional<std::string>& found) const {
  fail_at(value_->begin, problem, expected, found ? *found : describe(), pointer_);
}

std::string JsonNode::describe() const {
  if (const auto* array = std::get_if<JsonArray>(&value_->data)) {
    return fmt::format("an array of {} value{}", array->size(), array->size() == 1 ? "" : "s");
  }
  if (is_object()) return "an object";
  return document_->quote(value_->begin, value_->end);
}

double JsonNode::number(const NumberRange& range) const {
  double number;
  if (const auto* whole = std::get_if<std::uint64_t>(&value_->data)) {
    number = static_cast<double>(*whole);
  } else if (const auto* real = std::get_if<double>(&value_->data)) {
    number = *real;
  } else {
    fail("wrong type", "a number");
  }
  if (!range.contains(number)) fail("number out of range", "a number " + range.describe());
  return number;
}

std::uint64_t JsonNode::whole_number(std::uint64_t minimum, std::uint64_t maximum) const {
  const std::string expected = fmt::format("an integer from {} to {}", minimum, maximum);
  std::uint64_t whole = 0;
  if (const auto* exact = std::get_if<std::uint64_t>(&value_->data)) {
    whole = *exact;
  } else if (const auto* real = std::get_if<double>(&value_->data)) {
    if (std::trunc(*real) != *real) fail("not an integer", expected);
    if (*real < 0.0 || *real >= 0x1p64) fail("number out of range", expected);
    whole = static_cast<std::uint64_t>(*real);
  } else {
    fail("wrong type", expected);
  }
  if (whole < minimum || whole > maximum) fail("number out of range", expected);
  return whole;
}

std::string JsonNode::text() const {
  const auto* text = std::get_if<std::string>(&value_->data);
  if (!text) fail("wrong type", "a string");
  if (text->empty()) fail("empty string", "at least one character");
  if (text->find('\0') != std::string::npos) fail("the string contains a NUL character", "", "");
  return *text;
}

std::size_t JsonNode::choice(std::span<const std::string_view> words) const {
  const auto* word = std::get_if<std::string>(&value_->data);
  if (!word) fail("wrong type", list_of(words));
  const auto found = std::ranges::find(words, *word);
  if (found == words.end()) fail("unknown value" + did_you_mean(*word, words), list_of(words));
  return static_cast<std::size_t>(found - words.begin());
}

std::vector<JsonNode> JsonNode::elements(std::size_t minimum, std::size_t maximum) const {
  const auto* array = std::get_if<JsonArray>(&value_->data);
  const std::string count = minimum == maximum ? fmt::format("an array of {} values", minimum)
                            : maximum == std::size_t(-1)
                                ? fmt::format("an array of at least {}", minimum)
                                : fmt::format("an array of {} to {} values", minimum, maximum);
  if (!array) fail("wrong type", count);
  if (array->size() < minimum || array->size() > maximum) fail("wrong number of values", count);
  std::vector<JsonNode> nodes;
  nodes.reserve(array->size());
  for (const JsonValue& element : *array) nodes.push_back(child(element, std::to_string(nodes.size())));
  return nodes;
}

glm::dvec3 JsonNode::vector(const NumberRange& range) const {
  const std::vector<JsonNode> numbers = elements(3, 3);
  return {numbers[0].number(range), numbers[1].number(range), numbers[2].number(range)};
}

std::vector<std::pair<std::string, JsonNode>> JsonNode::members() const {
  const auto* object = std::get_if<JsonObject>(&value_->data);
  if (!object) fail("wrong type", "an object");
  std::vector<std::pair<std::string, JsonNode>> all;
  all.reserve(object->size());
  for (const JsonMember& member : *object) all.emplace_back(member.key, child(member.value, member.key));
  return all;
}

bool JsonNode::is_word(std::string_view word) const {
  if (is_string()) choice({&word, 1});
  return is_string();
}

bool JsonNode::boolean() const {
  const auto* value = std::get_if<bool>(&value_->data);
  if (!value) fail("wrong type", "true or false");
  return *value;
}

JsonNode JsonNode::child(const JsonValue& value, std::string_view step) const {
  JsonNode node = *this;
  node.value_ = &value;
  node.pointer_ += pointer_step(step);
  return node;
}

std::optional<JsonNode> JsonNode::find(std::string_view key) const {
  if (const auto* object = std::get_if<JsonObject>(&value_->data)) {
    for (const JsonMember& member : *object) {
      if (member.key == key) return child(member.value, key);
    }
  }
  return {};
}

JsonFields::JsonFields(const JsonNode& node, std::span<const std::string_view> words) : node_(node) {
  const auto* object = std::get_if<JsonObject>(&node.value().data);
  if (!object) node.fail("wrong type", "an object");
  for (const JsonMember& member : *object) {
    if (std::ranges::find(words, member.key) != words.end()) continue;
    const JsonDocument& document = *node.document_;
    node.fail_at(member.key_begin, "unknown key" + did_you_mean(member.key, words), list_of(words),
                 document.quote(member.key_begin, member.key_end),
                 node.pointer() + pointer_step(document.quote(member.key_begin + 1, member.key_end - 1)));
  }
}

JsonNode JsonFields::require(std::string_view key) const {
  if (auto node = node_.find(key)) return *node;
  node_.fail(fmt::format("missing key \"{}\"", key), "", "");
}

void read_version(const JsonNode& version) {
  if (version.number({-1e9, 1e9}) != 1) version.fail("unsupported version", "1");
}

}  // namespace alidade
