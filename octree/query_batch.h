// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "octree/check_query.h"
#include "octree/query.h"

// Many targets at once: in parallel, answered in their order, with errors that name the target.

namespace alidade {

/// Calls work(i) for all targets, in parallel, `grain` of them one after another once they are checked.
/// Errors: in the first block that has any, the first invalid target, or else what `work` throws.
template <class Target, class Work>
void for_each_target(std::span<const Target> targets, std::size_t grain, const Work& work) {
  in_blocks(targets.size(), grain, [&](std::size_t first, std::size_t end) {
    check_range(targets, first, end);
    for (std::size_t i = first; i < end; ++i) work(i);
  });
}

/// Answers of all targets. find_one(i, answers) appends those of target i. Errors: as for_each_target().
template <class Answer, class Target, class FindOne>
Answers<Answer> answer_all(std::span<const Target> targets, std::size_t grain, const FindOne& find_one) {
  Answers<Answer> result;
  result.begin.resize(targets.size() + 1);
  std::vector<std::vector<Answer>> parts((targets.size() + grain - 1) / grain);
  for_each_target(targets, grain, [&](std::size_t i) {
    std::vector<Answer>& part = parts[i / grain];
    find_one(i, part);
    result.begin[i + 1] = part.size();
  });
  // So far `begin` counts from the start of each part.
  std::size_t before = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (std::size_t i = p * grain; i < std::min((p + 1) * grain, targets.size()); ++i)
      result.begin[i + 1] += before;
    before += parts[p].size();
  }
  result.all.reserve(before);
  for (std::vector<Answer>& part : parts) {
    result.all.insert(result.all.end(), part.begin(), part.end());
    std::vector<Answer>().swap(part);
  }
  return result;
}

}  // namespace alidade
