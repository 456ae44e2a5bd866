// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "tests/support/random.h"

namespace alidade::test {

/// A SELECT over the tables of PrepareFuzzTest, with conditions on dist_ray and dist_plane in many positions
/// and spellings. Some may be pruned and some not.
struct RandomStatement {
  std::string text;
  int parameters = 0;       ///< what to bind: numbers 1, 2, ...
  bool is_ordered = false;  ///< the statement says in which order the rows come
};

RandomStatement random_statement(Random& random);

}  // namespace alidade::test
