// SPDX-License-Identifier: MIT
#include "base/instruction_set.h"

#include <hwy/targets.h>
#if HWY_ARCH_X86
#include <cpuid.h>
#endif

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
  std::int64_t target;  ///< of Highway; 0: always compiled
};

#if HWY_ARCH_X86
/// Which not every __builtin_cpu_supports() knows.
bool has_f16c_and_lzcnt() {
  constexpr unsigned k_f16c = 1u << 29, k_lzcnt = 1u << 5;
  unsigned a, b, c, d;
  return __get_cpuid(1, &a, &b, &c, &d) != 0 && (c & k_f16c) != 0 &&
         __get_cpuid(0x80000001u, &a, &b, &c, &d) != 0 && (c & k_lzcnt) != 0;
}
#endif

/// Whether processor and system support what Highway's target of this name compiles to, each with what the
/// narrower ones have. hwy::SupportedTargets() answers the same, but the library that has it measures clocks
/// when it is loaded, which takes 4 ms of every start.
bool has_instructions(InstructionSet instruction_set) {
#if HWY_ARCH_X86
  const bool sse4 =
      __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("pclmul") && __builtin_cpu_supports("aes");
  const bool avx2 = sse4 && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                    __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") && has_f16c_and_lzcnt();
  const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
                      __builtin_cpu_supports("avx512cd");
  if (instruction_set == InstructionSet::sse4) return sse4;
  if (instruction_set == InstructionSet::avx2) return avx2;
  if (instruction_set == InstructionSet::avx512) return avx512;
#endif
  return instruction_set == InstructionSet::scalar;
}

constexpr std::array<KnownSet, 4> k_known_sets{{{InstructionSet::scalar, "scalar", 0},
                                                {InstructionSet::sse4, "sse4", HWY_SSE4},
                                                {InstructionSet::avx2, "avx2", HWY_AVX2},
                                                {InstructionSet::avx512, "avx512", HWY_AVX3}}};

}  // namespace

std::vector<InstructionSet> available_instruction_sets() {
  std::vector<InstructionSet> sets;
  for (const KnownSet& known : k_known_sets) {
    const bool is_compiled = known.target == 0 || (HWY_TARGETS & known.target) != 0;
    if (is_compiled && has_instructions(known.instruction_set)) sets.push_back(known.instruction_set);
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
