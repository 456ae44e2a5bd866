// SPDX-License-Identifier: MIT
#include "tests/tools/units_site.h"

namespace alidade::test {
namespace {

TEST_F(UnitsTest, change_compares_epochs_of_either_unit) {
  const Words words{"--no-sight", "--json", "-o", "change.las", "--overwrite"};
  const auto same_share = [&](const std::string& before, const std::string& after) {
    Words all{"change", before, after};
    all.insert(all.end(), words.begin(), words.end());
    const ProgramResult result = run(all);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const Json answer = Json::parse(result.out)["after"];
    return double(answer["classes"]["same"]["points"]) / double(answer["points"]);
  };
  EXPECT_GT(same_share("feet.las", "metres.las"), 0.9);
  EXPECT_GT(same_share("metres.las", "feet.las"), 0.9);
  write_site("none.las", "", 0.01);
  EXPECT_TRUE(contains(error({"change", "none.las", "feet.las", "--no-sight", "-o", "x.las"}),
                       "none.las: no reference system, and the heights of AFTER are converted"));
  std::string other = k_oregon;
  other.replace(other.find(R"(UNIT["metre",1])"), 15, R"(UNIT["foot",0.3048])");
  other.replace(other.find(R"(,AUTHORITY["EPSG","2991"])"), 24, "");
  write_site("plane.las", k_oregon, 0.01);
  write_site("other.las", other, 0.01);
  EXPECT_TRUE(contains(error({"change", "plane.las", "other.las", "--no-sight", "-o", "x.las"}),
                       "AFTER is in another reference system than BEFORE"));
}

}  // namespace
}  // namespace alidade::test
