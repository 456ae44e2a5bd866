// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>

namespace alidade::test {

/// What a test says that skips because data is absent: which, and how many of its cases are left out.
/// tests/support/count_skipped.sh adds them up.
inline std::string absent(const std::string& data, std::size_t cases = 1) {
  return std::to_string(cases) + (cases == 1 ? " case" : " cases") + " skipped: " + data + " is not there";
}

}  // namespace alidade::test
