// SPDX-License-Identifier: MIT
#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/tools/run_program.h"
#include "tools/command.h"

namespace alidade::test {
namespace {

using Json = nlohmann::json;

class IndexTest : public ProgramTest {
 protected:
  /// A scan `site.las` and its index `site.alidade`.
  void index_scan(Words options = {}) {
    ASSERT_EQ(run({"generate", "courtyard", "--points", "5000", "-o", "site.las", "-q"}).exit_code, 0);
    options.insert(options.begin(), {"index", "site.las", "-o", "site.alidade", "-q"});
    const ProgramResult result = run(options);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out + result.err, "");
  }

  Json info(const Words& files) {
    Words words = {"info", "--json"};
    words.insert(words.end(), files.begin(), files.end());
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Json::parse(result.out);
  }

  /// Adds one to a byte of a file.
  void damage(const std::string& name, std::size_t offset) {
    std::string content = read(name);
    ++content.at(offset);
    write(name, content);
  }
};

TEST_F(IndexTest, is_queried_by_more_threads_than_cores_if_memory_does_not_hold_it) {
  write("big.alidade", std::string(1000, ' '));
  const std::string file = (folder / "big.alidade").string();
  const Words render = {"alidade", "render", file, "-o", "picture.png"};
  EXPECT_GE(tools::enough_threads(render, 999), 8);
  EXPECT_FALSE(tools::enough_threads(render, 1000));
  EXPECT_FALSE(tools::enough_threads(Words{"alidade", "convert", file}, 999));
  EXPECT_FALSE(tools::enough_threads(Words{"alidade", "render", file + ".las"}, 999));
}

TEST_F(IndexTest, info_prints_of_an_index_what_it_prints_of_its_source) {
  index_scan();
  Json of_index = info({"site.alidade"}), of_las = info({"site.las"});
  ASSERT_EQ(of_index.at("indexes").size(), 1u);
  const Json& facts = of_index.at("indexes")[0];
  EXPECT_EQ(facts.at("file"), "site.alidade");
  EXPECT_EQ(facts.at("version"), 2);
  EXPECT_EQ(facts.at("bytes"), std::filesystem::file_size(folder / "site.alidade"));
  EXPECT_EQ(facts.at("organisation"), "adaptive");
  EXPECT_GT(facts.at("levels"), 0);
  EXPECT_GT(facts.at("nodes"), 0);
  EXPECT_GT(facts.at("octree_bytes_per_point").get<double>(), 10.0);
  EXPECT_EQ(facts.at("stored_order"), false);
  EXPECT_EQ(facts.at("verified"), false);
  EXPECT_EQ(of_las.at("indexes"), Json::array());
  of_index.erase("indexes");
  of_las.erase("indexes");
  EXPECT_TRUE(of_index.at("files")[0].at("header_box").is_null());
  EXPECT_FALSE(of_las.at("files")[0].at("header_box").is_null());
  of_las.at("files")[0].at("header_box") = nullptr;
  EXPECT_EQ(of_index, of_las);
}

TEST_F(IndexTest, info_takes_an_index_and_another_file_together) {
  index_scan();
  const Json mixed = info({"site.alidade", "site.las"});
  Json of_las = info({"site.las", "site.las"});
  of_las.at("files")[0].at("header_box") = nullptr;
  // The warning is about the duplicate file, which an index does not show.
  EXPECT_EQ(of_las.at("warnings").size(), 1u);
  of_las.at("warnings").clear();
  for (const char* const key :
       {"points", "files", "bounds", "scale", "offset", "rounding_error", "attributes", "crs", "warnings"}) {
    EXPECT_EQ(mixed.at(key), of_las.at(key)) << key;
  }
  EXPECT_EQ(mixed.at("indexes").size(), 1u);
}

TEST_F(IndexTest, info_for_people_names_sources_and_index_facts) {
  index_scan({"--organisation", "layered"});
  const ProgramResult result = run({"info", "site.alidade"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* const part : {"site.alidade", "site.las", "LAS 1.4", "5000", "layered octree", "nodes",
                                 "levels", "per point", "UTM zone 32N"}) {
    EXPECT_TRUE(contains(result.out, part)) << part << " in\n" << result.out;
  }
}

/// Renders a LAS file, and its index under the same name, so that the metadata of the images are the same
/// too.
class IndexImageTest : public IndexTest {
 protected:
  void expect_same_bytes(const std::string& image, const std::string& organisation,
                         const std::string& cloud) {
    SCOPED_TRACE(organisation + " " + image + " " + cloud);
    ASSERT_EQ(
        run({"generate", "courtyard", "--points", "5000", "-o", "cloud", "-q", "--overwrite"}).exit_code, 0);
    write("scene.json", R"({"version": 1, "cloud": {"files": ["cloud"], )" + cloud + "}}");
    const std::string of_las = render(image);
    // An image contains the name of its cloud; the index gets the name of its source.
    ASSERT_EQ(
        run({"index", "cloud", "-o", "cloud.alidade", "--overwrite", "-q", "--organisation", organisation})
            .exit_code,
        0);
    std::filesystem::rename(folder / "cloud.alidade", folder / "cloud");
    EXPECT_TRUE(of_las == render(image));
  }

  std::string render(const std::string& image) {
    const ProgramResult result =
        run({"render", "scene.json", "-o", image, "-q", "--size", "40x30", "--samples", "2", "--overwrite"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read(image);
  }
};

TEST_F(IndexImageTest, of_an_index_has_the_bytes_of_that_of_its_source) {
  expect_same_bytes("picture.exr", "adaptive", R"("color": "rgb", "normals": "smooth")");
  expect_same_bytes("picture.png", "adaptive", R"("color": "rgb", "normals": "smooth")");
  expect_same_bytes("picture.exr", "adaptive", R"("color": "intensity")");
  expect_same_bytes("picture.exr", "adaptive", R"("color": "height")");
}

// The automatic radius and smooth normals look at a sample of the points, which the organisation draws.
TEST_F(IndexImageTest, of_another_organisation_has_the_same_bytes_where_only_queries_decide) {
  for (const char* const organisation : {"fixed", "layered"})
    expect_same_bytes("picture.exr", organisation,
                      R"("color": "height", "normals": "sphere", "radius": 0.5)");
}

TEST_F(IndexTest, several_files_become_one_index) {
  write_square("a.xyz");
  write("b.xyz", "0 0 0\n1 1 1\n");
  ASSERT_EQ(run({"index", "a.xyz", "b.xyz", "-o", "both.alidade"}).exit_code, 0);
  Json of_index = info({"both.alidade"}), of_files = info({"a.xyz", "b.xyz"});
  of_index.erase("indexes");
  of_files.erase("indexes");
  EXPECT_EQ(of_index, of_files);
}

TEST_F(IndexTest, an_index_can_be_made_of_an_index_and_names_the_first_sources) {
  index_scan();
  ASSERT_EQ(run({"index", "site.alidade", "-o", "again.alidade", "-q"}).exit_code, 0);
  EXPECT_EQ(read("again.alidade"), read("site.alidade"));
}

TEST_F(IndexTest, stored_order_and_cell_size_are_kept) {
  index_scan({"--stored-order", "--organisation", "fixed", "--cell-size", "5"});
  const Json facts = info({"site.alidade"}).at("indexes")[0];
  EXPECT_EQ(facts.at("stored_order"), true);
  EXPECT_EQ(facts.at("organisation"), "fixed");
  EXPECT_EQ(run({"info", "--verify", "-q", "site.alidade"}).exit_code, 0);
}

TEST_F(IndexTest, verify_finds_damage_and_names_section_and_byte) {
  index_scan();
  const ProgramResult sound = run({"info", "--verify", "site.alidade"});
  EXPECT_EQ(sound.exit_code, 0) << sound.err;
  EXPECT_TRUE(contains(sound.out, "verified")) << sound.out;
  const std::size_t size = read("site.alidade").size();
  damage("site.alidade", 4096 + 100);
  ProgramResult result = run({"info", "--verify", "site.alidade"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_TRUE(contains(result.err, "site.alidade:byte 4096: corrupt section nodes")) << result.err;
  // Without --verify the command reads nothing of the damaged section.
  EXPECT_EQ(run({"info", "site.alidade"}).exit_code, 0);
  result = run({"render", "--cloud", "site.alidade", "-o", "out.png", "--size", "8x8", "--samples", "1"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "corrupt section nodes")) << result.err;
  for (const std::size_t offset : {std::size_t{0}, std::size_t{50}, size / 2, size - 1}) {
    ASSERT_EQ(run({"index", "site.las", "-o", "site.alidade", "-q", "--overwrite"}).exit_code, 0);
    damage("site.alidade", offset);
    result = run({"info", "--verify", "site.alidade"});
    EXPECT_EQ(result.exit_code, 2) << offset;
    EXPECT_TRUE(contains(result.err, "alidade: error: site.alidade")) << result.err;
  }
}

TEST_F(IndexTest, verify_of_another_file_is_an_error) {
  write_square("square.xyz");
  const ProgramResult result = run({"info", "--verify", "square.xyz"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "square.xyz: no checksums")) << result.err;
  EXPECT_TRUE(contains(run({"info", "--verify", "absent"}).err, "absent: cannot open the file"));
}

TEST_F(IndexTest, existing_index_is_kept_without_overwrite) {
  write_square("square.xyz");
  write("out.alidade", "precious");
  const ProgramResult result = run({"index", "square.xyz", "-o", "out.alidade"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "out.alidade: the file exists")) << result.err;
  EXPECT_EQ(read("out.alidade"), "precious");
  EXPECT_EQ(run({"index", "square.xyz", "-o", "out.alidade", "--overwrite"}).exit_code, 0);
  EXPECT_EQ(info({"out.alidade"}).at("points"), 400);
}

TEST_F(IndexTest, a_name_without_the_extension_of_an_index_is_rejected) {
  write_square("square.xyz");
  const ProgramResult result = run({"index", "square.xyz", "-o", "square.xyz", "--overwrite"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "square.xyz: unknown output format; expected the extension .alidade"))
      << result.err;
  EXPECT_EQ(names(), Words{"square.xyz"});
  EXPECT_EQ(info({"square.xyz"}).at("points"), 400);
}

TEST_F(IndexTest, bad_input_leaves_no_index) {
  write("broken.las", "LASF and nothing more");
  EXPECT_EQ(run({"index", "broken.las", "-o", "out.alidade"}).exit_code, 2);
  EXPECT_EQ(run({"index", "absent.las", "-o", "out.alidade"}).exit_code, 2);
  EXPECT_EQ(names(), Words{"broken.las"});
}

TEST_F(IndexTest, keeps_the_attributes_that_are_wanted) {
  index_scan({"--attributes", "classification,color"});
  EXPECT_EQ(info({"site.alidade"}).at("attributes"), Json({"color", "classification"}));
  const auto size = std::filesystem::file_size(folder / "site.alidade");
  ASSERT_EQ(run({"index", "site.las", "-o", "site.alidade", "--attributes", "none", "--overwrite"}).exit_code,
            0);
  EXPECT_EQ(info({"site.alidade"}).at("attributes"), Json::array());
  EXPECT_LT(std::filesystem::file_size(folder / "site.alidade"), size);
  EXPECT_EQ(run({"query", "site.alidade", "--ray", "690000,5325000,700,0,0,-1", "--radius", "1"}).out,
            run({"query", "site.las", "--ray", "690000,5325000,700,0,0,-1", "--radius", "1"}).out);
  ASSERT_EQ(
      run({"index", "site.las", "-o", "site.alidade", "--attributes", "number_of_returns", "--overwrite"})
          .exit_code,
      0);
  EXPECT_EQ(info({"site.alidade"}).at("attributes"), Json({"return_number", "number_of_returns"}));
}

TEST_F(IndexTest, wrong_options_are_explained) {
  write_square("square.xyz");
  const auto error_of = [&](const Words& options) {
    Words words = {"index", "square.xyz", "-o", "out.alidade"};
    words.insert(words.end(), options.begin(), options.end());
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 2);
    return result.err;
  };
  EXPECT_TRUE(
      contains(error_of({"--organisation", "flat"}), "expected adaptive|fixed|layered, found 'flat'"));
  EXPECT_TRUE(contains(error_of({"--attributes", "color,colour"}),
                       "gps_time, normal, extra_dimensions; found 'colour'"));
  EXPECT_TRUE(contains(error_of({"--cell-size", "2"}), "--cell-size requires --organisation fixed"));
  EXPECT_TRUE(
      contains(error_of({"--organisation", "fixed", "--cell-size", "0"}), "expected a positive length"));
  EXPECT_TRUE(contains(error_of({"--organisation", "fixed", "--cell-size", "-1"}), "--cell-size"));
  EXPECT_EQ(names(), Words{"square.xyz"});
}

TEST_F(IndexTest, a_cloud_without_points_can_be_indexed) {
  write("empty.ply",
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float "
        "z\nend_header\n");
  ASSERT_EQ(run({"index", "empty.ply", "-o", "empty.alidade", "-q"}).exit_code, 0);
  EXPECT_EQ(run({"info", "--verify", "empty.alidade", "-q"}).exit_code, 0);
  EXPECT_EQ(info({"empty.alidade"}).at("points"), 0);
}

}  // namespace
}  // namespace alidade::test
