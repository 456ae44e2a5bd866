// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace alidade::test {

/// How often the program has taken memory with new. For programs that memory_taken.cpp is linked to.
std::size_t memory_taken();

}  // namespace alidade::test
