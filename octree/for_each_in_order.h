// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cstddef>

namespace alidade {

/// body(0) .. body(count - 1) in parallel, begun in this order: whoever is free takes the next. For work that
/// uses up memory along the way, of which only a few places at a time should be in use.
template <class Body>
void for_each_in_order(std::size_t count, const Body& body) {
  std::atomic<std::size_t> next = 0;
  tbb::parallel_for(0, tbb::this_task_arena::max_concurrency(), [&](int) {
    for (std::size_t i = next++; i < count; i = next++) body(i);
  });
}

}  // namespace alidade
