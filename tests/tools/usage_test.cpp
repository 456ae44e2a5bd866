// SPDX-License-Identifier: MIT
#include <algorithm>
#include <memory>

#include "jobs/clouds/index.h"
#include "jobs/field_table.h"
#include "jobs/long_run.h"
#include "tests/tools/run_program.h"
#include "tools/command.h"

namespace alidade::test {
namespace {

using ::testing::Test;

class UsageTest : public ProgramTest {};

TEST_F(UsageTest, help_lists_the_finished_commands_and_the_exit_codes) {
  const ProgramResult result = run({"--help"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  for (const char* const command : {"info", "generate", "index", "query", "render", "visibility", "sql"})
    EXPECT_TRUE(contains(result.out, command)) << command;
  for (const char* const code : {"0 success", "1 a check failed", "2 error", "130 interrupted"}) {
    EXPECT_TRUE(contains(result.out, code)) << code;
  }
}

TEST_F(UsageTest, help_of_every_command_gives_units_and_examples) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> expected = {
      {"info", {"metres", "Examples:", "alidade info --json"}},
      {"generate", {"metres", "Examples:", "alidade generate courtyard"}},
      {"query",
       {"metres", "degrees", "inclusive", "ray_id,rank,point_id", "Examples:", "alidade query site.las"}},
      {"render", {"metres", "pixels", "degrees", "bits", "Examples:", "alidade render site.las"}},
      {"sql", {"metres", "dist_ray(", "dist_plane(", "Examples:", "alidade sql site.db"}}};
  for (const auto& [command, parts] : expected) {
    const ProgramResult result = run({command, "--help"});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.err, "");
    for (const std::string& part : parts) EXPECT_TRUE(contains(result.out, part)) << command << ": " << part;
  }
}

TEST_F(UsageTest, the_word_help_asks_for_the_manual_of_the_words_behind_it) {
  EXPECT_EQ(run({"help"}).out, run({"--help"}).out);
  const ProgramResult result = run({"help", "visibility", "raster"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out, run({"visibility", "raster", "--help"}).out);
  EXPECT_TRUE(contains(run({"help", "rendr"}).err, "unknown command 'rendr'; did you mean 'render'?"));
}

TEST_F(UsageTest, the_manual_needs_no_file_on_the_line) {
  write("scene.json", "{");
  for (const char* const scene : {"none.json", "scene.json"}) {
    const ProgramResult result = run({"render", scene, "--samples", "x", "--help"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out, run({"render", "--help"}).out);
  }
}

TEST_F(UsageTest, a_viewshed_is_a_visibility_raster) {
  EXPECT_EQ(run({"visibility", "viewshed", "--help"}).exit_code, 0);
  EXPECT_TRUE(contains(run({"visibility", "viewshed", "--observre", "0,0"}).err,
                       "unknown option '--observre'; did you mean '--observer'?"));
}

TEST(Options, what_is_declared_through_them_stays_required_under_a_heading) {
  tools::Parser parser;
  const tools::Options info = parser.program().command("info", "");
  std::string file;
  info.required().group("Files").text("--file", "FILE", "", file);
  EXPECT_THROW(parser.parse(std::vector<std::string>{"info"}), tools::UsageError);
  EXPECT_EQ(parser.parse(std::vector<std::string>{"info", "--file", "a"}), tools::Parser::Action::work);
  EXPECT_EQ(file, "a");
}

TEST(Options, those_of_the_command_line_alone_do_not_change_answers) {
  tools::Parser parser;
  const tools::Command index = tools::add_index(parser.program());
  jobs::IndexRequest request;
  const auto table = std::make_shared<jobs::FieldTable>("index");
  jobs::add_index_fields(jobs::Fields(table), request);
  const auto fields = table->given();
  // A checkpoint of a job is one of the command, and the other way round.
  for (const std::string& option : index.options.long_names()) {
    const std::string name = option.substr(2);
    const bool is_field = std::ranges::any_of(fields, [&](const auto& field) { return field.first == name; });
    EXPECT_TRUE(is_field || jobs::is_silent(name, {})) << option;
  }
}

TEST_F(UsageTest, version_is_a_line_on_stdout) {
  const ProgramResult result = run({"--version"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out.rfind("alidade ", 0), 0u) << result.out;
}

TEST_F(UsageTest, no_command_is_a_usage_error) {
  const ProgramResult result = run({});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "alidade: error: ")) << result.err;
  EXPECT_TRUE(contains(result.err, "alidade --help")) << result.err;
}

TEST_F(UsageTest, misspelt_command_names_the_nearest_one) {
  const ProgramResult result = run({"rendr", "scene.json"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "unknown command 'rendr'; did you mean 'render'?")) << result.err;
}

TEST_F(UsageTest, misspelt_option_names_the_nearest_one) {
  const ProgramResult result = run({"render", "--cloud", "a.las", "--smaples=4", "-o", "a.png"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "unknown option '--smaples'; did you mean '--samples'?")) << result.err;
  EXPECT_TRUE(contains(result.err, "alidade render --help")) << result.err;
}

TEST_F(UsageTest, outlandish_option_is_rejected_without_a_guess) {
  const ProgramResult result = run({"info", "--xyzzyxyzzy", "a.las"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "unknown option '--xyzzyxyzzy'")) << result.err;
  EXPECT_FALSE(contains(result.err, "did you mean")) << result.err;
}

TEST_F(UsageTest, values_that_are_not_wholly_a_number_in_range_are_errors) {
  write_square("square.xyz");
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"--samples", "5x"},      {"--samples", "0"},
      {"--samples", "-3"},      {"--samples", ""},
      {"--samples", "1.5"},     {"--size", "600"},
      {"--size", "600x"},       {"--size", "600x400x2"},
      {"--size", "0x400"},      {"--size", "70000x4"},
      {"--radius", "0.1m"},     {"--radius", "0"},
      {"--radius", "nan"},      {"--radius", "inf"},
      {"--radius", "-1"},       {"--seed", "18446744073709551616"},
      {"--threads", "0"},       {"--threads", "2 "},
      {"--exposure", "bright"}, {"--color-depth", "12"},
      {"--color-map", "green"}, {"--color-range", "5,5"},
      {"--color-range", "5"},   {"--color-range", "1,2,3"},
      {"--color-range", "a,b"}, {"--color-percentiles", "1,101"},
      {"--class-color", "6"},   {"--class-color", "256=#000000"},
      {"--legend", "a.jpg"},    {"--class-color", "6=red"},
      {"--color-by", ""},       {"--hits", "first"},
      {"--layers", "color,"},   {"--layers", "colour"},
      {"--max-bounces", "-1"},  {"--samples", "1e400"},
      {"--radius-max", "0"},    {"--radius-neighbours", "65"},
      {"--layers", "id,id"},    {"--size", "65536x65536"}};
  for (const auto& [option, value] : wrong) {
    const ProgramResult result =
        run({"render", "--cloud", "square.xyz", "-o", "a.png", option + "=" + value});
    EXPECT_EQ(result.exit_code, 2) << option << " " << value;
    EXPECT_TRUE(contains(result.err, option)) << result.err;
  }
  EXPECT_EQ(names(), std::vector<std::string>{"square.xyz"});
}

TEST_F(UsageTest, counts_may_be_written_with_an_exponent) {
  EXPECT_EQ(run({"generate", "courtyard", "--points", "2e3", "-o", "a.las", "-q"}).exit_code, 0);
  EXPECT_EQ(run({"generate", "courtyard", "--points", "2000", "-o", "b.las", "-q"}).exit_code, 0);
  EXPECT_EQ(read("a.las"), read("b.las"));
  EXPECT_NE(read("a.las"), "");
  for (const char* const count : {"2e3x", "2.5", "1e-3", "-2e3", "0", "1e20", "5e9", " 2e3"}) {
    EXPECT_EQ(run({"generate", "courtyard", "--points", count, "-o", "c.las", "-q"}).exit_code, 2) << count;
  }
}

TEST_F(UsageTest, scene_and_cloud_exclude_each_other) {
  const ProgramResult result = run({"render", "scene.json", "--cloud", "a.las", "-o", "a.png"});
  EXPECT_EQ(result.exit_code, 2);
}

TEST_F(UsageTest, render_without_scene_or_cloud_reports_what_is_missing) {
  const ProgramResult result = run({"render", "-o", "a.png"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "SCENE.json, CLOUD..., --mesh FILE or --site")) << result.err;
}

TEST_F(UsageTest, program_itself_loads_neither_image_nor_map_libraries) {
  if (shell_output("command -v ldd", folder).empty()) GTEST_SKIP() << "ldd is not there";
  const std::string libraries = shell_output("ldd '" + program_file().string() + "'", folder);
  EXPECT_TRUE(contains(libraries, "libstdc++")) << libraries;
  for (const char* const name : {"libOpenImageIO", "libgdal", "libproj", "libfreetype"})
    EXPECT_FALSE(contains(libraries, name)) << name;
  EXPECT_LE(std::ranges::count(libraries, '\n'), 20) << libraries;
}

}  // namespace
}  // namespace alidade::test
