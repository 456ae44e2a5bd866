// SPDX-License-Identifier: MIT
#include "base/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/error.h"

namespace alidade {
namespace {

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
               .place = document_->place(byte),
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
  const std::string expected = fmt::format("a whole number from {} to {}", minimum, maximum);
  std::uint64_t whole = 0;
  if (const auto* exact = std::get_if<std::uint64_t>(&value_->data)) {
    whole = *exact;
  } else if (const auto* real = std::get_if<double>(&value_->data)) {
    if (std::trunc(*real) != *real) fail("not a whole number", expected);
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
  if (!text) fail("wrong type", "a text in quotes");
  if (text->empty()) fail("empty text", "at least one character");
  if (text->find('\0') != std::string::npos) fail("text holds a NUL character", "text without it");
  return *text;
}

std::size_t JsonNode::choice(std::span<const std::string_view> words) const {
  const auto* word = std::get_if<std::string>(&value_->data);
  if (!word) fail("wrong type", list_of(words));
  const auto found = std::ranges::find(words, *word);
  if (found == words.end()) fail("unknown word" + did_you_mean(*word, words), list_of(words));
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

JsonFields::JsonFields(const JsonNode& node, std::initializer_list<std::string_view> known) : node_(node) {
  const auto* object = std::get_if<JsonObject>(&node.value().data);
  if (!object) node.fail("wrong type", "an object");
  const std::span<const std::string_view> words(known.begin(), known.size());
  for (const JsonMember& member : *object) {
    if (std::ranges::find(words, member.key) != words.end()) continue;
    const JsonDocument& document = *node.document_;
    node.fail_at(member.key_begin, "unknown key" + did_you_mean(member.key, words), list_of(words),
                 document.quote(member.key_begin, member.key_end),
                 node.pointer() + pointer_step(document.quote(member.key_begin + 1, member.key_end - 1)));
  }
}

std::optional<JsonNode> JsonFields::find(std::string_view key) const {
  return node_.find(key);
}

JsonNode JsonFields::require(std::string_view key) const {
  if (auto node = node_.find(key)) return *node;
  node_.fail(fmt::format("missing key \"{}\"", key), "the key", "an object without it");
}

JsonNode type_of(const JsonNode& node, std::initializer_list<std::string_view> known) {
  if (const auto type = node.find("type")) return *type;
  return JsonFields(node, known).require("type");
}

std::string_view nearest_word(std::string_view word, std::span<const std::string_view> words) {
  // More typing errors than a third of the letters are another word; the limit also bounds the cost for
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
    // A distance as long as the candidate means that nothing of it is left.
    if (row.back() < nearest_distance && row.back() < candidate.size()) {
      nearest = candidate;
      nearest_distance = row.back();
    }
  }
  return nearest;
}

}  // namespace alidade
