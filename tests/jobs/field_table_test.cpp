// SPDX-License-Identifier: MIT
#include "jobs/field_table.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace alidade::jobs {
namespace {

/// A request with a field of each form.
struct FieldTableTest : ::testing::Test {
  void SetUp() override {
    const Fields fields(table);
    fields.required().file("-o,--output", "FILE", "what is written", output);
    const Field radius = fields.number("--radius", "R", "metres", request_radius, 0.5, 10.0);
    fields.excludes(radius).count("--target-count", "N", "points", count, 1, 9);
    fields.needs(radius).flag("--overwrite", "replace it", overwrite);
    fields.text("--name", "TEXT", "names", names);
    fields.text("-t,--to", "TEXT", "a short name", to);
    fields.words(
        "cloud", "FILE...", "files", [this](const auto& words) { files = words; }, 2);
  }

  std::string error_of_reading() {
    try {
      table->read();
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  }
  std::string error_of_giving(const std::string& name, std::vector<std::string> texts) {
    try {
      table->give(name, std::move(texts));
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  }

  std::shared_ptr<FieldTable> table = std::make_shared<FieldTable>("thing");
  std::filesystem::path output;
  std::optional<double> request_radius;
  std::optional<int> count;
  bool overwrite = false;
  std::vector<std::string> names, files;
  std::string to;
};

TEST_F(FieldTableTest, fields_read_what_is_given_by_any_of_their_names) {
  table->give("o", {"a.tif"});
  table->give("radius", {"2.5"});
  table->give("overwrite", {});
  table->give("name", {"one"});
  table->give("name", {"two"});
  table->give("cloud", {"a.las", "b.las"});
  table->read();
  EXPECT_EQ(output, "a.tif");
  EXPECT_EQ(request_radius, 2.5);
  EXPECT_TRUE(overwrite);
  EXPECT_EQ(names, (std::vector<std::string>{"one", "two"}));
  EXPECT_EQ(files, (std::vector<std::string>{"a.las", "b.las"}));
  EXPECT_EQ(count, std::nullopt);
}

TEST_F(FieldTableTest, underscores_stand_for_hyphens) {
  table->give("output", {"a.tif"});
  table->give("target_count", {"3"});
  table->read();
  EXPECT_EQ(count, 3);
}

TEST_F(FieldTableTest, what_was_given_is_listed_in_the_order_of_declaration) {
  table->give("radius", {"1"});
  table->give("overwrite", {});
  table->give("output", {"a.tif"});
  const std::vector<std::pair<std::string, std::vector<std::string>>> expected = {
      {"output", {"a.tif"}}, {"radius", {"1"}}, {"target-count", {}}, {"overwrite", {"true"}},
      {"name", {}},          {"to", {}},        {"cloud", {}}};
  EXPECT_EQ(table->given(), expected);
  EXPECT_EQ(table->name(), "thing");
}

TEST_F(FieldTableTest, wrong_uses_name_the_field) {
  EXPECT_EQ(error_of_giving("radios", {"1"}), "unknown field 'radios' of thing; did you mean 'radius'?");
  EXPECT_EQ(error_of_giving("radius", {}), "radius: expected one value, found 0");
  EXPECT_EQ(error_of_giving("radius", {"1", "2"}), "radius: expected one value, found 2");
  EXPECT_EQ(error_of_giving("overwrite", {"yes"}), "overwrite: expected no value, found 1");
  EXPECT_EQ(error_of_giving("files", {"a.las"}), "files: expected at least 2 values, found 1");
  EXPECT_EQ(error_of_giving("target_cont", {"1"}),
            "unknown field 'target_cont' of thing; did you mean 'target_count'?");
  EXPECT_EQ(error_of_giving("output", {std::string("a\0.tif", 6)}),
            "output: invalid value; expected a text without bytes of value 0, found 'a\\x00.tif'");
  EXPECT_EQ(error_of_reading(), "missing output; expected FILE");
  table->give("output", {""});
  EXPECT_EQ(error_of_reading(), "output: invalid value; expected a file name, found ''");
  table->give("output", {"a.tif"});
  table->give("radius", {"11"});
  EXPECT_EQ(error_of_reading(), "radius: invalid value; expected a number from 0.5 to 10, found '11'");
  table->give("radius", {"10"});
  table->give("target_count", {"1"});
  EXPECT_EQ(error_of_reading(), "target_count excludes radius");
}

TEST_F(FieldTableTest, the_command_has_operands_before_options_and_no_outputs) {
  table->give("radius", {"1"});
  table->give("output", {"a.tif"});
  table->give("name", {"two words"});
  table->give("cloud", {"/site/a.las", "b.las"});
  EXPECT_EQ(command_text(*table), "alidade thing a.las b.las --radius 1 --name \"two words\"");
  EXPECT_EQ(command_text(*table, std::array<std::string_view, 1>{"radius"}),
            "alidade thing a.las b.las --name \"two words\"");
}

TEST_F(FieldTableTest, messages_name_fields_in_place_of_options) {
  EXPECT_EQ(table->in_own_words("--target-count requires --radius R; --other, a--b"),
            "target_count requires radius R; --other, a--b");
  EXPECT_EQ(table->in_own_words("--"), "--");
  EXPECT_EQ(table->in_own_words("expected '--radius', (--to) or --output."),
            "expected 'radius', (to) or output.");
  for (const char* const file : {"a--to: no file", "--output.las: no file", "site/--to/a.las: no file"})
    EXPECT_EQ(table->in_own_words(file), file);
}

TEST_F(FieldTableTest, a_field_that_needs_another_is_not_read_alone) {
  table->give("output", {"a.tif"});
  table->give("overwrite", {});
  EXPECT_EQ(error_of_reading(), "overwrite requires radius");
  EXPECT_FALSE(overwrite);
}

}  // namespace
}  // namespace alidade::jobs
