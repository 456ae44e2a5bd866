// SPDX-License-Identifier: MIT
#include "base/shown_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/json.h"
#include "base/words.h"

namespace alidade {
namespace {

TEST(LineTextTest, what_is_obeyed_instead_of_shown_is_an_escape) {
  EXPECT_EQ(line_text("a\tb\n\x1b[31mred\x7f\r"), "a\\x09b\\n\\x1b[31mred\\x7f\\x0d");
  EXPECT_EQ(line_text(std::string("\0", 1)), "\\x00");
  EXPECT_EQ(line_text("\xff\xc3 \xe2\x82"), "\\xff\\xc3 \\xe2\\x82");
  // C1: both ends; the bytes alone, which some terminals obey, too.
  EXPECT_EQ(line_text("\xc2\x80\xc2\x9b\xc2\x9f \x9b"), "\\u0080\\u009b\\u009f \\x9b");
  // Both ends of each range that turns the direction of writing or ends a line.
  EXPECT_EQ(line_text("\u061c\u200e\u200f\u2028\u2029\u202a\u202e\u2066\u2069"),
            "\\u061c\\u200e\\u200f\\u2028\\u2029\\u202a\\u202e\\u2066\\u2069");
  EXPECT_EQ(line_text("\u00a0\u061b\u200d\u2010\u2027\u202f\u2065\u206a Grün é€𝄞 \\n"),
            "\u00a0\u061b\u200d\u2010\u2027\u202f\u2065\u206a Grün é€𝄞 \\n");
  EXPECT_EQ(line_text(""), "");
  const std::string once = line_text("\x1b\n\xff\u202e");
  EXPECT_EQ(line_text(once), once);
}

TEST(LineTextTest, quotations_in_messages_are_such_text_of_whole_characters) {
  EXPECT_EQ(quote("a\x1b\u202e\n"), "\"a\\x1b\\u202e\\n\"");
  EXPECT_EQ(quote(std::string(39, 'a') + "ä"), '"' + std::string(39, 'a') + "...\"");
  EXPECT_EQ(quote(std::string(38, 'a') + "ä"), '"' + std::string(38, 'a') + "ä\"");
  EXPECT_EQ(quote(std::string(60, '\x80')).size(), 4 * 37 + 5u)
      << "bytes that are no characters are cut, too";
}

TEST(CsvCellTest, texts_are_quoted_as_rfc_4180_says) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", ""},           {"plain name", "plain name"}, {"a,b", "\"a,b\""},      {"a\"b", "\"a\"\"b\""},
      {"\"", "\"\"\"\""}, {"a;b'c", "\"a;b'c\""},       {"a\r\nb", "a\\x0d\\nb"}};
  for (const auto& [text, cell] : cases) EXPECT_EQ(csv_cell(text), cell) << text;
}

TEST(CsvCellTest, formulas_begin_with_an_apostrophe_and_numbers_do_not) {
  for (const std::string text :
       {"=1+1", "+cmd", "-x", "@SUM(1)", "=", "+", "-", "@", "-1,5x", "--5", "+-5", "=5", "@5"})
    EXPECT_TRUE(csv_cell(text).starts_with(text.find(',') == text.npos ? "'" + text : "\"'" + text)) << text;
  EXPECT_EQ(csv_cell("=HYPERLINK(\"x\",1)"), "\"'=HYPERLINK(\"\"x\"\",1)\"");
  for (const std::string text : {"-5", "+5", "-1e300", "-.5", "-inf", "+0.25", "x=1", "a-b", "'=1"})
    EXPECT_EQ(csv_cell(text), text);
  // What spreadsheets skip in front of a formula is no longer there.
  EXPECT_EQ(csv_cell("\t=1"), "\\x09=1");
  EXPECT_EQ(csv_cell("\n=1"), "\\n=1");
}

TEST(CsvCellTest, cells_are_found_again) {
  for (const std::string text : {"a,b", "a\",b", "\",\"", "\"\"", ","}) {
    const std::string line = csv_cell(text) + ",next";
    std::vector<std::string_view> words;
    split_cells(line, ',', words);
    ASSERT_EQ(words.size(), 2u) << line;
    EXPECT_EQ(words[1], "next") << line;
  }
}

TEST(JsonTextTest, strings_hold_such_characters_as_escapes_and_stay_the_same) {
  const std::string text = "a\x1b\n\x7f\xc2\x9b\u202e\u2028 Grün 𝄞\"\\";
  const nlohmann::json json = {{text, text}};
  const std::string written = json_text(json);
  for (const char* const raw : {"\x1b", "\n", "\x7f", "\xc2\x9b", "\u202e", "\u2028"})
    EXPECT_EQ(written.find(raw), written.npos) << written;
  EXPECT_NE(written.find("\\u007f\\u009b\\u202e\\u2028 Grün 𝄞"), written.npos) << written;
  EXPECT_EQ(nlohmann::json::parse(written), json);
  // No UTF-8 is no reason to fail.
  EXPECT_EQ(json_text(nlohmann::json("\xff")), "\"\ufffd\"");
  EXPECT_EQ(plain_json("{\"a\": 1}"), "{\"a\": 1}");
}

TEST(JsonTextTest, quotations_of_scene_files_are_lines_of_text) {
  const JsonDocument document = parse_json("[\"a\u202e\x7f\",\n 1]", "scene.json");
  EXPECT_EQ(document.quote(0, document.text.size()), "[\"a\\u202e\\x7f\",  1]");
}

TEST(QuantityTest, is_written_as_people_write_it) {
  EXPECT_EQ(quantity(1, "rays"), "1 ray");
  EXPECT_EQ(quantity(1, "boxes"), "1 box");
  EXPECT_EQ(quantity(2, "rays"), "2 rays");
  EXPECT_EQ(quantity(640'000, "points"), "640 k points");
  EXPECT_EQ(quantity(1'250'000, "points"), "1.25 M points");
  EXPECT_EQ(quantity(512, "B"), "512 B");
  EXPECT_EQ(quantity(36'000'000, "B"), "36 MB");
  EXPECT_EQ(quantity(64'000, "B"), "64 kB");
}

TEST(ShortCountTest, counts_are_short) {
  EXPECT_EQ(short_count(0), "0");
  EXPECT_EQ(short_count(9999), "9999");
  EXPECT_EQ(short_count(10000), "10 k");
  EXPECT_EQ(short_count(123456), "123 k");
  EXPECT_EQ(short_count(999499), "999 k");
  EXPECT_EQ(short_count(999500), "1 M");
  EXPECT_EQ(short_count(1234567), "1.23 M");
  EXPECT_EQ(short_count(2e9), "2 G");
}

TEST(ClockTimeTest, times_are_minutes_and_seconds) {
  EXPECT_EQ(clock_time(0), "0:00");
  EXPECT_EQ(clock_time(59.6), "1:00");
  EXPECT_EQ(clock_time(754), "12:34");
  EXPECT_EQ(clock_time(3723), "1:02:03");
}

}  // namespace
}  // namespace alidade
