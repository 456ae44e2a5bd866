// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include "tests/tools/run_program.h"

namespace alidade::test {

/// A test with the cloud site.csv: a floor (class 2) from -5 to 5 with a wall (class 6) across its middle at
/// x = 0, from y = -3 to 3 and 2 high.
class WallSiteTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    constexpr int k_steps = 25;
    std::string text = "x,y,z,classification\n";
    for (int i = -k_steps; i <= k_steps; ++i) {
      for (int j = -k_steps; j <= k_steps; ++j) text += fmt::format("{},{},0,2\n", 0.2 * i, 0.2 * j);
    }
    for (int j = -30; j <= 30; ++j) {
      for (int k = 1; k <= 20; ++k) text += fmt::format("0,{},{},6\n", 0.1 * j, 0.1 * k);
    }
    write("site.csv", text);
  }
};

}  // namespace alidade::test
