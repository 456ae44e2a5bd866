// SPDX-License-Identifier: MIT
// Names of attributes, observers and files never act as commands: not to a terminal, in a spreadsheet or in a
// page, and they never start a line of their own.
#include "base/shown_text.h"
#include "base/words.h"
#include "cloud/las/write_las.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

/// A formula, an escape sequence, a line end with a line of its own, a C1 control, a right-to-left override,
/// a comma and a quote.
const std::string k_name = "=\x1b[2J\nINJ\xc2\x9b\u202e,\"q";

/// Whether a text has nothing but characters that are shown, line ends, and no line that a name has begun.
bool is_plain(const std::string& text) {
  std::string without_ends = text;
  std::erase(without_ends, '\n');
  return line_text(without_ends) == without_ends && text.find("\nINJ") == text.npos;
}

class HostileNamesTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    PointCloud cloud;
    cloud.lattice.scale = glm::dvec3(0.01);
    for (int i = 0; i < 400; ++i) cloud.positions.emplace_back(100 * (i % 20), 100 * (i / 20), 0);
    cloud.extra_dimensions = {plain_dimension(k_name, ScalarType::uint8)};
    cloud.extra_dimensions[0].values.assign(400, 7);
    write_las(folder / k_file, cloud);
  }

  /// Runs a command whose output and files are plain, and returns what it printed.
  std::string said(const Words& words, int exit_code = 0) {
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_TRUE(is_plain(result.out)) << line_text(result.out);
    EXPECT_TRUE(is_plain(result.err)) << line_text(result.err);
    return result.out + result.err;
  }

  std::string plain_file(const std::string& name) const {
    const std::string content = read(name);
    EXPECT_NE(content, "") << name;
    EXPECT_TRUE(is_plain(content)) << line_text(content);
    return content;
  }

  const std::string k_file = "a\x1b[2J\nINJ\u202e.las";
};

TEST_F(HostileNamesTest, of_attributes_and_files_are_escapes_on_a_terminal_and_in_json) {
  for (const Words& words :
       {Words{"info", k_file}, Words{"info", "--stats", k_file}, Words{"info", "-v", k_file}}) {
    const std::string text = said(words);
    EXPECT_TRUE(contains(text, "a\\x1b[2J\\nINJ\\u202e.las")) << text;
    EXPECT_TRUE(contains(text, "=\\x1b[2J\\nINJ\\u009b\\u202e,\"q")) << text;
  }
  for (const Words& words : {Words{"info", "--json", k_file}, Words{"info", "--json", "--stats", k_file}})
    EXPECT_TRUE(contains(said(words), "\"=\\u001b[2J\\nINJ\\u009b\\u202e,\\\"q\""));
  EXPECT_TRUE(contains(said({"info", "none\x1b\nINJ.las"}, 2), "none\\x1b\\nINJ.las: cannot open the file"));
  EXPECT_TRUE(contains(said({"info", k_file, "--x\nINJ"}, 2), "\\nINJ"));
  said({"convert", k_file, "-o", "b" + k_file});
  said({"render", "--cloud", k_file, "--color", "nothing", "--size", "8x8", "-o", "x.png"}, 2);
}

TEST_F(HostileNamesTest, of_columns_are_quoted_cells_and_no_formulas) {
  said({"convert", k_file, "-o", "points.csv"});
  EXPECT_TRUE(contains(plain_file("points.csv"), ",\"'=_[2J_INJ_____,\"\"q\"\n"));
  const std::string select = "SELECT * FROM points LIMIT 2";
  const std::string csv = said({"sql", k_file, select, "--csv", "-q"});
  EXPECT_TRUE(contains(csv.substr(0, csv.find('\n')), ",\"'=_[2J_INJ\\u009b\\u202e,\"\"q\"")) << csv;
  const std::string json = said({"sql", k_file, select, "--json", "-q"});
  EXPECT_TRUE(contains(json, ",\"=_[2J_INJ\\u009b\\u202e,\\\"q\":7}")) << json;
  EXPECT_TRUE(contains(said({"sql", k_file, select, "-q"}), "=_[2J_INJ\\u009b\\u202e,\"q"));
  // Values that are text likewise; numbers are numbers, also as text.
  EXPECT_EQ(said({"sql", k_file,
                  "SELECT '=1+1' AS a, '-5' AS b, -5 AS c, '@x' || char(10) || 'INJ' AS d, '+1' AS e",
                  "--csv", "-q"}),
            "a,b,c,d,e\n'=1+1,-5,-5,'@x\\nINJ,+1\n");
  said({"sql", k_file, "SELECT \"" + k_name, "-q"}, 2);
}

TEST_F(HostileNamesTest, of_observers_are_cells_and_strings) {
  write("observers.geojson", R"({"type": "FeatureCollection", "features": [{"type": "Feature", "properties":
    {"name": "=\u001b[2J\nINJ\u009b\u202e,\"q"}, "geometry": {"type": "Point", "coordinates": [5, 5, 1]}}]})");
  for (const std::string form : {"csv", "json", "geojson"}) {
    const std::string file = "summary." + form;
    said({"visibility", "summary", k_file, "--observers", "observers.geojson", "--observers-crs", "cloud",
          "-o", file});
    const std::string content = plain_file(file);
    EXPECT_TRUE(contains(content, form == "csv" ? "\"'=\\x1b[2J\\nINJ\\u009b\\u202e,\"\"q\""
                                                : "\"=\\u001b[2J\\nINJ\\u009b\\u202e,\\\"q\""))
        << content;
  }
  write("observers.csv", "name,x,y,z\n\"=\x1b[2J\xc2\x9b\u202e,q\",900,900,900\n");
  said({"visibility", "summary", k_file, "--observers", "observers.csv", "-o", "far.csv"});
  EXPECT_TRUE(contains(plain_file("far.csv"), "\"'=\\x1b[2J\\u009b\\u202e,q\""));
}

TEST_F(HostileNamesTest, of_images_are_text_in_tables_json_and_pages) {
  const std::string name = "a\x1b\nINJ\u202e.png";
  said({"render", "--cloud", k_file, "--size", "16x16", "--samples", "1", "-o", name});
  EXPECT_TRUE(contains(said({"compare", name, name}), "a\\x1b\\nINJ\\u202e.png"));
  EXPECT_TRUE(contains(said({"compare", name, name, "--json"}), "a\\u001b\\nINJ\\u202e.png"));
  said({"compare", name, name, "--report", "page.html"});
  EXPECT_TRUE(contains(plain_file("page.html"), "a\\x1b\\nINJ\\u202e.png against "));
  EXPECT_TRUE(contains(read("page.html"), "a\\\\u001b\\nINJ\\\\u202e.png"));
  std::filesystem::create_directories(folder / "one");
  std::filesystem::copy_file(folder / name, folder / "one" / name);
  EXPECT_TRUE(contains(said({"compare", "one", "one"}), "a\\x1b\\nINJ\\u202e"));
  said({"compare", "one", "one", "--json"});
  said({"compare", "one", "one", "--report", "pairs.html"});
  EXPECT_TRUE(contains(plain_file("pairs.html"), "INJ\\\\u202e"));
}

TEST_F(HostileNamesTest, of_files_in_a_catalog_are_addresses_and_strings) {
  said({"catalog", k_file, "-o", "site.catalog.json"});
  const std::string catalog = plain_file("site.catalog.json");
  EXPECT_TRUE(contains(catalog, "\"id\":\"a\\u001b[2J\\nINJ\\u202e.las\"")) << catalog;
  EXPECT_TRUE(contains(catalog, "\"href\":\"a%1B%5B2J%0AINJ%E2%80%AE.las\"")) << catalog;
  // An href with a control character is an error in one line.
  EXPECT_TRUE(
      contains(said({"info", "site.catalog.json"}, 2), "item 1: the href leaves the catalog's folder"));
}

}  // namespace
}  // namespace alidade::test
