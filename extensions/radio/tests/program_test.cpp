// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "tests/tools/resume_test.h"
#include "tests/tools/wall_site.h"

namespace alidade::test {
namespace {

using Json = nlohmann::json;

class RadioTest : public WallSiteTest {
 protected:
  ProgramResult lines(std::vector<std::string> words) {
    words.insert(words.begin(), {"visibility", "lines", "site.csv", "-q"});
    return run(words);
  }
};

TEST_F(RadioTest, a_frequency_adds_the_zone_and_json_what_obstructs_it) {
  // The wall's top is at z = 2 and the zone of 8 m at 2.4 GHz half a metre wide: a tenth lies below its
  // middle.
  write("pairs.csv", "from_x,from_y,from_z,to_x,to_y,to_z\n-4,0,2,4,0,2\n-4,0,9,4,0,9\n");
  ASSERT_EQ(lines({"--pairs", "pairs.csv", "--frequency", "2.4GHz", "--radius", "0.1", "-o", "links.json"})
                .exit_code,
            0);
  const Json file = Json::parse(read("links.json"));
  EXPECT_EQ(file["command"],
            "alidade visibility lines site.csv --pairs pairs.csv --frequency 2.4GHz "
            "--radius 0.1");
  const Json& link = file["lines"][0];
  EXPECT_NEAR(link["fresnel_radius"], 0.4998, 1e-3);
  EXPECT_NEAR(link["fresnel_obstructed"], 0.61, 0.03);
  EXPECT_EQ(link["fresnel_class"], 6);
  EXPECT_EQ(link["obstructions"]["classes"][0]["class"], 6);
  EXPECT_EQ(file["lines"][1]["fresnel_clear"], true);
  EXPECT_EQ(file["lines"][1]["from"], "from 2");
  ASSERT_EQ(lines({"--pairs", "pairs.csv", "--frequency", "2400MHz", "--radius", "0.1", "-o", "same.json"})
                .exit_code,
            0);
  EXPECT_EQ(Json::parse(read("same.json"))["lines"], file["lines"]);
}

TEST_F(RadioTest, results_do_not_depend_on_threads) {
  write("positions.csv", "x,y,z,name\n-4,0,1,a\n4,0,1,b\n-4,0,3,c\n3,2,2,d\n-1,-2,0.5,e\n");
  for (const std::string threads : {"1", "3"}) {
    ASSERT_EQ(lines({"--places", "positions.csv", "--frequency", "5.8", "--threads", threads, "-o",
                     "lines" + threads + ".json"})
                  .exit_code,
              0);
  }
  EXPECT_EQ(read("lines1.json"), read("lines3.json"));
}

TEST_F(RadioTest, what_cannot_be_done_is_an_error) {
  write("positions.csv", "x,y,z,name\n-4,0,1,west\n4,0,1,east\n");
  const ProgramResult frequency =
      lines({"--places", "positions.csv", "--frequency", "5kHz", "-o", "lines.csv"});
  EXPECT_EQ(frequency.exit_code, 2);
  EXPECT_NE(frequency.err.find("expected 1MHz to 1000GHz"), std::string::npos) << frequency.err;
  const ProgramResult through = run({"visibility", "lines", "site.csv", "--places", "positions.csv",
                                     "--frequency", "5", "--transparency", "2", "-o", "lines.csv"});
  EXPECT_EQ(through.exit_code, 2);
  EXPECT_NE(through.err.find("transparency requires straight lines"), std::string::npos) << through.err;
  EXPECT_EQ(through.err.find("measuring spacings"), std::string::npos) << through.err;
  // On a flat Earth lines may pass surfaces, but zones are solid.
  EXPECT_EQ(lines({"--places", "positions.csv", "--frequency", "5", "--transparency", "2",
                   "--earth-radius-factor", "off", "-o", "lines.csv"})
                .exit_code,
            0);
}

TEST_F(RadioTest, ends_a_million_kilometres_away_take_no_time) {
  write("positions.csv", "x,y,z,name\n-4,0,1,west\n4,0,1,east\n1e6,0,1,far\n1e9,10,1e5,farther\n");
  const ProgramResult result = lines(
      {"--places", "positions.csv", "--frequency", "1", "--earth-radius-factor", "1", "-o", "lines.json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(Json::parse(read("lines.json"))["lines"].size(), 6u);
}

TEST_F(RadioTest, the_manual_has_the_columns_behind_those_of_lines) {
  const ProgramResult result = run({"visibility", "lines", "--help"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* const part : {"--frequency", "fresnel_cut_off", "5.8GHz"})
    EXPECT_NE(result.out.find(part), std::string::npos) << part;
}

TEST_F(ResumeTest, links_killed_at_many_moments_give_the_bytes_of_an_uninterrupted_run) {
  std::string positions = "x,y,z\n";
  for (int i = 0; i < 12; ++i)
    positions += std::to_string(100.0 + 0.1 * i) + "," + std::to_string(200.0 + 0.07 * i) + ",5.3\n";
  write("positions.csv", positions);
  kill_and_resume({"visibility", "lines", "square.xyz", "--places", "positions.csv", "--frequency", "60GHz"},
                  {"-o", "lines.json"}, 12);
}

}  // namespace
}  // namespace alidade::test
