// SPDX-License-Identifier: MIT
#include "base/json.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>

#include "base/error.h"
#include "base/words.h"

namespace alidade {
namespace {

Error::Parts error_of(std::string text) {
  try {
    parse_json(std::move(text), "file.json");
  } catch (const Error& error) {
    return error.parts();
  }
  ADD_FAILURE() << "no error";
  return {};
}

TEST(JsonDocumentTest, values_have_the_offsets_of_their_text) {
  const std::string text = "{ \"a\" : [1, -2.5e1,\n \"x\\\"y\", true,null , {}] }";
  const JsonDocument document = parse_json(text, "file.json");
  const auto& member = std::get<JsonObject>(document.root.data).at(0);
  EXPECT_EQ(text.substr(member.key_begin, member.key_end - member.key_begin), "\"a\"");
  std::vector<std::string> found;
  for (const JsonValue& value : std::get<JsonArray>(member.value.data)) {
    found.push_back(text.substr(value.begin, value.end - value.begin));
  }
  EXPECT_EQ(found, (std::vector<std::string>{"1", "-2.5e1", "\"x\\\"y\"", "true", "null", "{}"}));
  EXPECT_EQ(document.root.end, text.size());
}

TEST(JsonDocumentTest, columns_count_characters_not_bytes) {
  const JsonDocument document = parse_json("[\n  \"\xC3\xA4\xC3\xB6\", 7]", "file.json");
  EXPECT_EQ(document.line_and_column(std::get<JsonArray>(document.root.data).at(1).begin), "2:9");
}

TEST(JsonDocumentTest, whole_numbers_of_64_bits_are_exact) {
  const JsonDocument document = parse_json("18446744073709551615", "file.json");
  EXPECT_EQ(std::get<std::uint64_t>(document.root.data), UINT64_MAX);
}

TEST(JsonDocumentTest, a_byte_order_mark_is_skipped) {
  const JsonDocument document = parse_json("\xEF\xBB\xBF [3]", "file.json");
  EXPECT_EQ(std::get<JsonArray>(document.root.data).at(0).begin, 5u);
}

TEST(JsonDocumentTest, what_is_not_json_is_an_error_with_line_and_column) {
  struct Case {
    std::string text, location;
  };
  const std::vector<Case> cases{
      {"", "1:1"},
      {"   \n", "2:1"},
      {"{\"a\": 1,}", "1:9"},
      {"[1, 2,]", "1:7"},
      {"[1 2]", "1:4"},
      {"[1] x", "1:5"},
      {"[1]]", "1:4"},
      {"{\"a\" 1}", "1:6"},
      {"{a: 1}", "1:2"},
      {"{\n \"a\": tru\n}", "2:7"},
      {"[NaN]", "1:2"},
      {"[Infinity]", "1:2"},
      {"[-Infinity]", "1:2"},
      {"[01]", "1:3"},
      {"[1.]", "1:2"},
      {"[.5]", "1:2"},
      {"[+1]", "1:2"},
      {"[1, // one\n 2]", "1:5"},
      {"'a'", "1:1"},
      {"[\"a\nb\"]", "1:4"},
      {"[\"a\\qb\"]", "1:5"},
      {"[\"a", "1:4"},
      {"{\"a\":", "1:6"},
      {"[\"\xFF\"]", "1:3"},
      {std::string("[1,\0 2]", 7), "1:4"},
  };
  for (const Case& each : cases) {
    const Error::Parts parts = error_of(each.text);
    EXPECT_EQ(parts.file, "file.json") << each.text;
    EXPECT_EQ(parts.location, each.location) << each.text << ": " << parts.problem;
    EXPECT_TRUE(parts.problem.starts_with("invalid JSON: ")) << parts.problem;
    EXPECT_EQ(parts.problem.find("exception"), std::string::npos) << parts.problem;
  }
}

TEST(JsonDocumentTest, a_number_beyond_double_is_an_error) {
  const Error::Parts parts = error_of("[1, 1e999]");
  EXPECT_EQ(parts.location, "1:5");
  EXPECT_EQ(parts.problem, "number out of range");
  EXPECT_EQ(parts.found, "1e999");
}

TEST(JsonDocumentTest, a_duplicate_key_is_an_error_at_the_second) {
  const Error::Parts parts = error_of("{\"a\": 1,\n \"b\": {\"a\": 2}, \"\\u0061\": 3}");
  EXPECT_EQ(parts.location, "2:17");
  EXPECT_EQ(parts.problem, "duplicate key \"\\u0061\", first at 1:2");
}

TEST(JsonDocumentTest, deep_nesting_is_an_error_and_no_stack_overflow) {
  const Error::Parts parts = error_of(std::string(1'000'000, '['));
  EXPECT_EQ(parts.location, "1:65");
  EXPECT_EQ(parts.problem, "too many nested levels");
  EXPECT_NO_THROW(parse_json(std::string(64, '[') + std::string(64, ']'), "file.json"));
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
  EXPECT_EQ(error_of(objects).problem, "too many nested levels");
}

TEST(JsonDocumentTest, quotations_are_short_and_on_one_line) {
  const std::string text = "[\n \"" + std::string(100, 'x') + "\"]";
  const JsonDocument document = parse_json(text, "file.json");
  const std::string quote = document.quote(0, text.size());
  EXPECT_LE(quote.size(), 40u);
  EXPECT_EQ(quote.find('\n'), std::string::npos);
  EXPECT_TRUE(quote.ends_with("..."));
}

TEST(NearestWordTest, finds_what_was_probably_meant) {
  constexpr std::array<std::string_view, 4> words{"samples", "max_bounces", "seed", "fx"};
  EXPECT_EQ(nearest_word("sample", words), "samples");
  EXPECT_EQ(nearest_word("smaples", words), "samples");
  EXPECT_EQ(nearest_word("maxBounces", words), "max_bounces");
  EXPECT_EQ(nearest_word("Seed", words), "seed");
  EXPECT_EQ(nearest_word("fz", words), "fx");
  EXPECT_EQ(nearest_word("camera", words), "");
  EXPECT_EQ(nearest_word("", words), "");
  EXPECT_EQ(nearest_word(std::string(1'000'000, 's'), words), "");
}

TEST(JsonDocumentTest, values_of_unread_keys_are_checked_but_not_kept) {
  constexpr std::array<std::string_view, 2> unread{"points", "b"};
  const JsonDocument document = parse_json(
      R"({"points": {"a": [1, {"points": [2]}], "c": "x"}, "a": [{"b": 1, "c": 2}, {"b": [[], 3], "c": {"b": {}, "d": 4}}]})",
      "f", unread);
  const JsonDocument same = parse_json(
      R"({"points": null, "a": [{"b": null, "c": 2}, {"b": null, "c": {"b": null, "d": 4}}]})", "f");
  const std::function<std::string(const JsonValue&)> text = [&](const JsonValue& value) -> std::string {
    std::string result = std::to_string(value.data.index());
    if (const auto* array = std::get_if<JsonArray>(&value.data)) {
      for (const JsonValue& each : *array) result.append("[").append(text(each));
    }
    if (const auto* object = std::get_if<JsonObject>(&value.data)) {
      for (const JsonMember& each : *object) result.append("{").append(each.key).append(text(each.value));
    }
    if (const auto* number = std::get_if<std::uint64_t>(&value.data))
      result.append("=").append(std::to_string(*number));
    return result;
  };
  EXPECT_EQ(text(document.root), text(same.root));
  EXPECT_THROW(parse_json(R"({"points": [1,}, "a": 1})", "f", unread), Error);
  std::string deep = "{\"points\": ";
  for (int i = 0; i < 70; ++i) deep += '[';
  EXPECT_THROW(parse_json(deep, "f", unread), Error);
}

}  // namespace
}  // namespace alidade
