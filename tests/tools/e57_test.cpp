// SPDX-License-Identifier: MIT
// alidade info on E57 files: what it prints, and what it extracts.
#include <nlohmann/json.hpp>

#include "tests/cloud/e57/e57_builder.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

using Json = nlohmann::json;

const std::string k_jpeg = "\xFF\xD8\xFF" + std::string(3000, 'j');

class E57ProgramTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    std::vector<double> x, y, z;
    for (int i = 0; i < 400; ++i) {
      x.push_back(0.1 * (i % 20) - 1);
      y.push_back(0.1 * (i / 20) - 1);
      z.push_back(0);
    }
    E57Builder builder;
    builder.root = "<coordinateMetadata type=\"String\">LOCAL_CS[\"site\"]</coordinateMetadata>";
    builder.add_scan(
        "<name type=\"String\">gate</name>" + pose_element("1 0 0 0", "100 200 5"),
        {float64_column("cartesianX", x), float64_column("cartesianY", y), float64_column("cartesianZ", z)});
    const std::string picture =
        "<jpegImage" + builder.add_blob(k_jpeg) +
        "/><imageWidth type=\"Integer\">40</imageWidth><imageHeight type=\"Integer\">30</imageHeight>";
    const std::string name = "<name type=\"String\">../../up/north.</name><guid type=\"String\">{1}</guid>";
    // Straight down from above the points.
    builder.add_image(
        name + pose_element("1 0 0 0", "100 200 15") + "<pinholeRepresentation type=\"Structure\">" +
        picture +
        "<focalLength type=\"Float\">0.02</focalLength><pixelWidth type=\"Float\">1e-4</pixelWidth>"
        "<pixelHeight type=\"Float\">1e-4</pixelHeight><principalPointX type=\"Float\">20</principalPointX>"
        "<principalPointY type=\"Float\">15</principalPointY></pinholeRepresentation>");
    builder.add_image(name + "<cylindricalRepresentation type=\"Structure\">" + picture +
                      "</cylindricalRepresentation>");
    write("site.e57", builder.file());
  }
};

TEST_F(E57ProgramTest, info_prints_scans_images_scanners_and_reference_system) {
  const ProgramResult table = run({"info", "site.e57"});
  ASSERT_EQ(table.exit_code, 0) << table.err;
  for (const char* const part :
       {"E57 1.0, 400 points", "scan 1 'gate': 400 records, at 100 200 5", "pinhole jpg 40x30, at 100 200 15",
        "cylindrical jpg 40x30, no pose", "scanner at 100 200 5", "site"}) {
    EXPECT_TRUE(contains(table.out, part)) << part << " in\n" << table.out;
  }
  const Json info = Json::parse(run({"info", "--json", "site.e57"}).out);
  EXPECT_EQ(info.at("points"), 400);
  EXPECT_EQ(info.at("crs"), "LOCAL_CS[\"site\"]");
  EXPECT_EQ(info.at("scanner_positions")[0].at("scan"), "gate");
  EXPECT_EQ(info.at("scanner_positions")[0].at("position"), Json({100.0, 200.0, 5.0}));
  const Json e57 = info.at("e57").at(0);
  EXPECT_EQ(e57.at("scans")[0].at("records"), 400);
  EXPECT_EQ(e57.at("scans")[0].at("fields").size(), 3u);
  EXPECT_EQ(e57.at("images").size(), 2u);
  EXPECT_EQ(e57.at("images")[0].at("pictures")[0].at("bytes"), k_jpeg.size());
}

TEST_F(E57ProgramTest, names_stay_on_their_line) {
  E57Builder builder;
  builder.add_scan("<name type=\"String\">&#27;[31mGr\xC3\xBCn&#10;points 9</name>",
                   {float64_column("cartesianX", {1}), float64_column("cartesianY", {1}),
                    float64_column("cartesianZ", {1})});
  builder.add_image("");
  write("named.e57", builder.file());
  const ProgramResult table = run({"info", "named.e57"});
  EXPECT_TRUE(contains(table.out, "scan 1 '\\x1b[31mGr\xC3\xBCn\\npoints 9': 1 records")) << table.out;
  EXPECT_TRUE(contains(table.out, "image 1: no image, no pose")) << table.out;
}

TEST_F(E57ProgramTest, scanner_positions_are_kept_by_index_files) {
  ASSERT_EQ(run({"index", "site.e57", "-o", "site.alidade", "-q"}).exit_code, 0);
  const Json info = Json::parse(run({"info", "--json", "site.alidade"}).out);
  EXPECT_EQ(info.at("scanner_positions")[0].at("position"), Json({100.0, 200.0, 5.0}));
}

TEST_F(E57ProgramTest, images_are_extracted_with_cameras_that_render_reads) {
  const ProgramResult result = run({"info", "--extract-images", "pictures", "site.e57"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  // Nothing is written outside the folder, whatever the names.
  EXPECT_EQ(read("pictures/_.._up_north..jpg"), k_jpeg);
  EXPECT_EQ(read("pictures/_.._up_north._2.jpg"), k_jpeg);
  const Json images = Json::parse(read("pictures/images.json"));
  ASSERT_EQ(images.size(), 2u);
  EXPECT_EQ(images[0].at("camera"), "_.._up_north..json");
  EXPECT_EQ(images[0].at("pose")[0], Json({1.0, 0.0, 0.0, 100.0}));
  EXPECT_TRUE(images[1].at("camera").is_null());
  EXPECT_TRUE(contains(images[1].at("note").get<std::string>(), "cylindrical"));
  const ProgramResult rendered =
      run({"render", "--cloud", "site.e57", "--camera", "pictures/_.._up_north..json", "--mode", "flat",
           "--samples", "1", "-o", "seen.png", "-q"});
  EXPECT_EQ(rendered.exit_code, 0) << rendered.err;
}

TEST_F(E57ProgramTest, nothing_is_overwritten_without_overwrite) {
  ASSERT_EQ(run({"info", "--extract-images", "pictures", "site.e57"}).exit_code, 0);
  write("pictures/_.._up_north..jpg", "mine");
  const ProgramResult rejected = run({"info", "--extract-images", "pictures", "site.e57"});
  EXPECT_NE(rejected.exit_code, 0);
  EXPECT_TRUE(contains(rejected.err, "north..jpg")) << rejected.err;
  EXPECT_EQ(read("pictures/_.._up_north..jpg"), "mine");
  EXPECT_EQ(run({"info", "--extract-images", "pictures", "--overwrite", "site.e57"}).exit_code, 0);
  EXPECT_EQ(read("pictures/_.._up_north..jpg"), k_jpeg);
}

TEST_F(E57ProgramTest, files_without_images_are_an_error_to_extract_from) {
  write_square("square.xyz");
  const ProgramResult result = run({"info", "--extract-images", "pictures", "square.xyz"});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_TRUE(contains(result.err, "no images to extract")) << result.err;
}

}  // namespace
}  // namespace alidade::test
