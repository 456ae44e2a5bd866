// SPDX-License-Identifier: MIT
#include "base/instruction_set.h"

#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>

#include "base/error.h"

namespace alidade {
namespace {

struct KnownSet {
  InstructionSet instruction_set;
  std::string_view name;
  std::int64_t target;
};

constexpr std::array<KnownSet, 4> k_known_sets{{{InstructionSet::scalar, "scalar", 0},
                                                {InstructionSet::sse4, "sse4", HWY_SSE4},
                                                {InstructionSet::avx2, "avx2", HWY_AVX2},
                                                {InstructionSet::avx512, "avx512", HWY_AVX3}}};

}  // namespace

std::vector<InstructionSet> available_instruction_sets() {
  const std::int64_t usable = hwy::SupportedTargets() & HWY_TARGETS;
  std::vector<InstructionSet> sets;
  for (const KnownSet& known : k_known_sets) {
    if (known.instruction_set == InstructionSet::scalar || (usable & known.target) != 0) {
      sets.push_back(known.instruction_set);
    }
  }
  return sets;
}

std::string_view name(InstructionSet instruction_set) {
  for (const KnownSet& known : k_known_sets) {
    if (known.instruction_set == instruction_set) return known.name;
  }
  return "best";
}

InstructionSet best_instruction_set() {
  const std::vector<InstructionSet> sets = available_instruction_sets();
  const char* wanted = std::getenv("ALIDADE_INSTRUCTION_SET");
  if (!wanted || !*wanted) return sets.back();
  std::string names;
  for (const InstructionSet set : sets) {
    if (name(set) == wanted) return set;
    names += (names.empty() ? "" : ", ") + std::string(name(set));
  }
  throw Error({.file = "ALIDADE_INSTRUCTION_SET",
               .problem = "unsupported instruction set",
               .expected = "one of " + names,
               .found = wanted});
}

InstructionSet usable(InstructionSet requested) {
  if (requested == InstructionSet::best) return best_instruction_set();
  const std::vector<InstructionSet> sets = available_instruction_sets();
  if (std::ranges::find(sets, requested) == sets.end()) {
    throw Error(
        {.problem = "instruction set " + std::string(name(requested)) + " is not available on this machine"});
  }
  return requested;
}

}  // namespace alidade
