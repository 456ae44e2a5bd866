// SPDX-License-Identifier: MIT
#include "tests/tools/cases.h"

namespace alidade::test {
namespace {

TEST_F(CasesTest, changes_that_gave_wrong_answers_in_silence_give_the_right_ones) {
  const auto cases = shared_data("../cases");
  if (!cases) GTEST_SKIP() << "2 cases were skipped: ../shared/cases beside the repository is not there";
  const Step change = {{"change", "@m3c2/C_before.csv", "@m3c2/C_after.csv", "--no-sight", "--normal-radius",
                        "1.1", "--cylinder-radius", "2", "--max-distance", "2", "-o", "change.las"}};
  const std::vector<Case> all = {
      {"m3c2", {change}, {"moved"}, {"same"}},
      {"m3c2, distances",
       {change, sql("change.las",
                    "SELECT sum(change = 0) AS same, sum(change = 1 AND abs(m3c2distance - 0.5) > 0.1) AS "
                    "wrong, sum(change = 1) > 1000 AS many FROM points")},
       {"same,wrong,many\n0,0,1\n"},
       {}}};
  for (const Case& each : all) check(each, *cases);
}

}  // namespace
}  // namespace alidade::test
