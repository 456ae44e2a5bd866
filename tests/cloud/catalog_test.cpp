// SPDX-License-Identifier: MIT
#include "cloud/catalog.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "base/allowed_hosts.h"
#include "cloud/input_view.h"
#include "cloud/las/write_las.h"
#include "cloud/rows.h"
#include "tests/cloud/cloud_test_support.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;
using test::error_of;

std::string collection(const std::string& items) {
  return R"({"type": "FeatureCollection", "features": [)" + items + "]}";
}

std::string item(const std::string& href, const std::string& properties = "") {
  return R"({"type": "Feature", "geometry": null, "properties": {)" + properties +
         R"(}, "assets": {"data": {"href": ")" + href + R"("}}})";
}

class CatalogTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = test::test_folder();
    catalog_ = folder_ / "site.catalog.json";
  }

  std::vector<CloudInput> read(const std::string& text) const {
    test::write_text(catalog_, text);
    return read_catalog(catalog_);
  }
  std::string error_in(const std::string& text) const {
    return error_of([&] { read(text); });
  }
  std::string error_of_href(const std::string& href) const { return error_in(collection(item(href))); }

  fs::path folder_, catalog_;
};

TEST_F(CatalogTest, items_are_files_beside_the_catalog_with_what_is_stated_of_them) {
  const std::vector<CloudInput> inputs = read(
      collection(item("a.las", R"("pc:count": 7, "proj:bbox": [1, 2, 3, 4, 5, 6], "pc:encoding": "LASzip")") +
                 ",\n" + item("north/b%20%C3%A4.copc.laz", R"("pc:count": 0, "proj:bbox": [1, 2, 4, 5])") +
                 ", " + item("./x/../c.ply", R"("pc:encoding": "PLY", "pc:schemas": [{"name": "X"}])")));
  ASSERT_EQ(inputs.size(), 3u);
  EXPECT_EQ(inputs[0].name, folder_ / "a.las");
  EXPECT_EQ(inputs[0].format, &k_las_format);
  ASSERT_TRUE(inputs[0].stated);
  EXPECT_EQ(inputs[0].stated->point_count, 7u);
  EXPECT_EQ(inputs[0].stated->box.min, glm::dvec3(1, 2, 3));
  EXPECT_EQ(inputs[0].stated->box.max, glm::dvec3(4, 5, 6));
  EXPECT_EQ(inputs[1].name, folder_ / "north/b ä.copc.laz");
  EXPECT_EQ(inputs[1].format, &k_copc_format);
  EXPECT_FALSE(inputs[1].stated) << "a flat box bounds no heights";
  EXPECT_EQ(inputs[2].format, &k_ply_format);
  EXPECT_TRUE(fs::equivalent(inputs[2].name.parent_path().parent_path() / ".", folder_) ||
              inputs[2].name.lexically_normal() == folder_ / "c.ply");
}

TEST_F(CatalogTest, hrefs_of_names_are_read_back) {
  const std::string name = "a b/ä#1?%41:&.copc.laz";
  const std::string href = href_of(name);
  EXPECT_EQ(href, "a%20b/%C3%A4%231%3F%2541%3A%26.copc.laz");
  EXPECT_EQ(read(collection(item(href))).front().name, folder_ / name);
}

TEST_F(CatalogTest, an_asset_with_the_role_data_counts_where_none_is_called_so) {
  const auto inputs = read(collection(
      R"({"assets": {"thumbnail": {"href": "a.png", "roles": ["thumbnail"]},
                     "cloud": {"href": "a.laz", "roles": ["data"], "type": "application/vnd.laszip+copc"}}})"));
  EXPECT_EQ(inputs.front().name, folder_ / "a.laz");
  EXPECT_EQ(inputs.front().format, &k_copc_format);
}

TEST_F(CatalogTest, what_leads_out_of_the_folder_is_an_error) {
  for (const char* const href :
       {"../a.las", "x/../../a.las", "%2e%2e/a.las", "x/%2E%2E%2f%2E%2E/a.las", "/etc/passwd",
        "%2Fetc/passwd", "file:///etc/passwd", "s3://bucket/a.las", "/vsizip/a.zip/a.las", "c:a.las", ".",
        "x/..", "a%00.las", "a%0A.las", "a%4", "a%zz.las"}) {
    const std::string error = error_of_href(href);
    EXPECT_NE(error.find("site.catalog.json:item 1: the href leaves the catalog's folder"), error.npos)
        << href << ": " << error;
  }
  EXPECT_NE(error_of_href("").find("leaves"), std::string::npos);
}

TEST_F(CatalogTest, urls_are_files_below_the_catalog_or_of_hosts_that_are_allowed) {
  const auto error_at = [](const std::string& catalog, const std::string& href) {
    return error_of([&] { parse_catalog(collection(item(href)), catalog); });
  };
  const std::string remote = "https://example.org/site/a.catalog.json?key=1", local = catalog_.string();
  const std::string remedy =
      "item 1: the href leads to other.org, which is not allowed; expected files below the catalog, or "
      "--allow-host "
      "other.org (or ALIDADE_ALLOW_HOSTS=other.org in the environment), found \"https://other.org/a.laz\"";
  EXPECT_TRUE(error_at(local, "https://other.org/a.laz").ends_with(remedy))
      << error_at(local, "https://other.org/a.laz");
  EXPECT_TRUE(error_at(remote, "https://other.org/a.laz").ends_with(remedy));
  // What is above or beside the folder, in any spelling, is not below it; nor is another port, or http.
  for (const char* const href :
       {"https://example.org/a.laz", "https://example.org/site/../a.laz",
        "https://example.org/site/%2e%2e/a.laz", "https://example.org/sites/a.laz",
        "https://example.org/site/", "https://example.org/site", "https://example.org",
        "https://example.org?/site/a.laz", "https://example.org#/site/a.laz",
        "https://example.org:444/site/a.laz", "http://example.org/site/a.laz",
        "https://example.org.other.org/site/a.laz", "https://example.org@other.org/site/a.laz",
        "https://example.org\\\\@other.org/site/a.laz"})
    EXPECT_NE(error_at(remote, href).find("which is not allowed; expected files below the catalog"),
              std::string::npos)
        << href << ": " << error_at(remote, href);
  for (const char* const href : {"https:///a.laz", "https://a b/a.laz", "http://", "https://a%2eb/a.laz"})
    EXPECT_NE(error_at(remote, href).find("invalid href"), std::string::npos) << href;
  for (const char* const href :
       {"https://example.org/site/a.laz", "https://EXAMPLE.org/site/deep/../a.laz?key=2",
        "https://example.org:443/site/deep/a.laz", "https://me@example.org/site/a.laz"})
    EXPECT_EQ(parse_catalog(collection(item(href)), remote).front().name, href);
  EXPECT_EQ(hosts_for("https://example.org/site/a.laz"), std::vector<std::string>());
  EXPECT_FALSE(hosts_for("https://other.org/a.laz")) << "nothing has listed it";

  allow_host("other.org");
  ::setenv("ALIDADE_ALLOW_HOSTS", "third.org, Fourth.org:8080", 1);
  for (const char* const href : {"https://other.org/a.laz", "http://OTHER.org/a.laz",
                                 "https://third.org/x/../a.laz", "http://fourth.org:8080/a.laz"}) {
    EXPECT_EQ(parse_catalog(collection(item(href)), local).front().name, href);
    EXPECT_EQ(hosts_for(href), (std::vector<std::string>{"third.org", "fourth.org:8080", "other.org"}));
  }
  EXPECT_NE(error_at(local, "http://fourth.org/a.laz").find("not allowed"), std::string::npos);
  ::unsetenv("ALIDADE_ALLOW_HOSTS");
  EXPECT_NE(error_at(local, "https://third.org/a.laz").find("not allowed"), std::string::npos);
  EXPECT_NE(error_at(local, "https://other.org/b.catalog.json?x=1").find("lists a catalog"),
            std::string::npos);
  for (const char* const host :
       {"", "other.org/", "https://other.org", "me@other.org", "Other.org", "other.org:443"})
    EXPECT_NE(error_of([&] { allow_host(host); }).find("invalid host"), std::string::npos) << host;
}

TEST_F(CatalogTest, a_catalog_in_a_catalog_is_an_error) {
  for (const char* const href : {"site.catalog.json", "x/../site.catalog.json", "OTHER.CATALOG.JSON"})
    EXPECT_NE(error_of_href(href).find("the catalog lists a catalog"), std::string::npos) << href;
}

TEST_F(CatalogTest, malformed_catalogs_are_errors_that_name_the_item) {
  const std::string good = item("a.las");
  EXPECT_TRUE(
      error_in("").ends_with("site.catalog.json:1:1: invalid JSON: unexpected end of input; expected '[', "
                             "'{', or a literal, found the end of the file"))
      << error_in("");
  for (const std::string& text : {collection(good).substr(0, 60), collection(good + ",\n{\"a\": tru}"),
                                  collection("{\"a\": \"\x9b\"}"), collection(good) + "}"}) {
    const std::string error = error_in(text);
    EXPECT_NE(error.find("invalid JSON: "), std::string::npos) << error;
    EXPECT_EQ(error.find("json.exception"), std::string::npos) << error;
    EXPECT_EQ(error.find("parse error"), std::string::npos) << error;
  }
  EXPECT_NE(error_in(collection(good + ",\n{\"a\": tru}")).find("site.catalog.json:2:7: "),
            std::string::npos);
  for (const char* const text : {"[]", "3", "{}", R"({"type": "FeatureCollection"})", R"({"features": []})",
                                 R"({"type": "FeatureCollection", "features": {}})",
                                 R"({"type": ["FeatureCollection"], "features": []})"})
    EXPECT_NE(error_in(text).find("not a catalog"), std::string::npos) << text;
  EXPECT_NE(error_in(collection("")).find("lists no files"), std::string::npos);
  EXPECT_NE(error_in(collection("3")).find("an item is no object"), std::string::npos);
  for (const char* const text : {"{}", R"({"assets": []})", R"({"assets": {"data": {}}})",
                                 R"({"assets": {"data": {"href": 3}}})", R"({"assets": {"x": 1}})"})
    EXPECT_NE(error_in(collection(good + "," + text)).find("item 2: the item has no file"), std::string::npos)
        << text;
  for (const char* const box : {"[1, 2, 3]", "3", "\"x\"", "[1, 2, 3, 4, 5, null]", "[1, 2, 3, 4, 5, 1e13]",
                                "[1, 2, 3, 0, 5, 6]", "[]"})
    EXPECT_NE(error_in(collection(item("a.las", std::string("\"pc:count\": 1, \"proj:bbox\": ") + box)))
                  .find("item 1: invalid proj:bbox"),
              std::string::npos)
        << box;
  for (const char* const count : {"-1", "1.5", "\"3\"", "[]"})
    EXPECT_NE(
        error_in(collection(
                     item("a.las", std::string("\"proj:bbox\": [1, 2, 3, 4, 5, 6], \"pc:count\": ") + count)))
            .find("invalid pc:count"),
        std::string::npos)
        << count;
  const std::string huge =
      item("a.las", "\"proj:bbox\": [1, 2, 3, 4, 5, 6], \"pc:count\": 4611686018427387904");
  EXPECT_NE(error_in(collection(huge + "," + huge)).find("item 2: pc:count is too large"), std::string::npos);
  const std::string deep = std::string(100, '[') + std::string(100, ']');
  EXPECT_NE(error_in(collection(item("a.las", "\"x\": " + deep))).find("nested too deep"), std::string::npos);
  EXPECT_NE(error_of([&] { read_catalog(folder_ / "missing.catalog.json"); }).find("missing.catalog.json"),
            std::string::npos);
}

/// Three LAS files in a row, 10 m wide each, with 50, 60 and 70 points, and what a catalog states of them.
class CatalogedTilesTest : public CatalogTest {
 protected:
  void SetUp() override {
    CatalogTest::SetUp();
    for (int i = 0; i < 3; ++i) {
      PointCloud tile;
      tile.lattice = {.scale = glm::dvec3(0.01), .offset = {10.0 * i, 0, 0}};
      for (int row = 0; row < 50 + 10 * i; ++row)
        tile.positions.emplace_back(row * 37 % 1000, row * 91 % 1000, row);
      write_las(folder_ / name_of(i), tile);
    }
  }

  static std::string name_of(int i) { return "tile_" + std::to_string(i) + ".las"; }

  /// The true catalog, but for the last tile's number of points and least x.
  CloudInputs resolve(int last_count = 70, double last_x = 19.9) const {
    std::string items;
    for (int i = 0; i < 3; ++i) {
      const double x = i == 2 ? last_x : 10.0 * i - 0.1;
      const int count = i == 2 ? last_count : 50 + 10 * i;
      items += (i > 0 ? "," : "") +
               item(name_of(i), "\"pc:encoding\": \"LAS\", \"pc:count\": " + std::to_string(count) +
                                    ", \"proj:bbox\": [" + std::to_string(x) + ", -1, -1, " +
                                    std::to_string(10.0 * i + 10.1) + ", 11, 2]");
    }
    test::write_text(catalog_, collection(items));
    return resolve_clouds({&catalog_, 1});
  }
};

TEST_F(CatalogedTilesTest, a_catalog_is_its_files) {
  const PointCloud cloud = read_cloud(resolve());
  EXPECT_EQ(cloud.size(), 180u);
  EXPECT_EQ(cloud.positions, read_cloud(folder_ / "tile_*.las").positions);
  const Bounds box = stated_box(resolve());
  EXPECT_EQ(box.min.x, -0.1);
  EXPECT_EQ(box.max.x, 30.1);
}

TEST_F(CatalogedTilesTest, files_outside_of_the_region_are_not_opened_and_rows_are_numbered_as_if_they_were) {
  fs::remove(folder_ / name_of(1));
  const PointCloud cloud = read_cloud(resolve(), {.region = Bounds{{25, 0, 0}, {29, 9, 1}}});
  EXPECT_EQ(cloud.size(), 70u);
  const RowIds ids(cloud.files);
  EXPECT_EQ(ids.skipped_files(), 2u);
  EXPECT_EQ(ids(3), 113u);
  EXPECT_NE(error_of([&] { read_cloud(resolve()); }).find(name_of(1)), std::string::npos);
}

TEST_F(CatalogedTilesTest, files_outside_of_the_box_of_a_selection_are_not_opened) {
  const auto selected = [&](CloudInputs inputs) {
    const auto view = std::make_shared<InputView>();
    view->selection.box = Bounds{{25, 0, 0}, {29, 9, 1}};
    for (CloudInput& input : inputs.inputs) input.view = view;
    return read_cloud(inputs);
  };
  const PointCloud expected = selected(resolve_clouds(std::vector{folder_ / "tile_*.las"}));
  fs::remove(folder_ / name_of(1));
  const PointCloud cloud = selected(resolve());
  EXPECT_GT(cloud.size(), 10u);
  EXPECT_EQ(cloud.positions, expected.positions);
  EXPECT_EQ(cloud.lattice, expected.lattice);
  ASSERT_EQ(cloud.files.size(), 3u);
  EXPECT_EQ(cloud.files[1].left_out_count, 60u);
}

TEST_F(CatalogedTilesTest, a_file_that_is_not_what_the_catalog_states_is_an_error_when_it_is_opened) {
  const std::string count = error_of([&] { read_cloud(resolve(71)); });
  EXPECT_NE(count.find(name_of(2)), std::string::npos) << count;
  EXPECT_NE(count.find("states another number of points: make the catalog again"), std::string::npos)
      << count;
  EXPECT_NE(count.find("expected 71, found 70"), std::string::npos) << count;
  const std::string box = error_of([&] { read_cloud(resolve(70, 22.0)); });
  EXPECT_NE(box.find("states another box"), std::string::npos) << box;
  EXPECT_EQ(read_cloud(resolve(70, 22.0), {.region = Bounds{{0, 0, 0}, {5, 5, 1}}}).size(), 50u);
}

}  // namespace
}  // namespace alidade
