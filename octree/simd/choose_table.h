// SPDX-License-Identifier: MIT
#pragma once

#include <hwy/highway.h>

#include "base/instruction_set.h"

// ALIDADE_CHOOSE_TABLE(instruction_set, table): returns `table` of the namespace that Highway compiled for an
// instruction set, from a function in alidade::simd. Which of its two scalar targets Highway compiles depends
// on the compiler.

#if HWY_TARGETS & HWY_AVX3
#define ALIDADE_CASE_AVX512(table) \
  case InstructionSet::avx512:     \
    return N_AVX3::table;
#else
#define ALIDADE_CASE_AVX512(table)
#endif
#if HWY_TARGETS & HWY_AVX2
#define ALIDADE_CASE_AVX2(table) \
  case InstructionSet::avx2:     \
    return N_AVX2::table;
#else
#define ALIDADE_CASE_AVX2(table)
#endif
#if HWY_TARGETS & HWY_SSE4
#define ALIDADE_CASE_SSE4(table) \
  case InstructionSet::sse4:     \
    return N_SSE4::table;
#else
#define ALIDADE_CASE_SSE4(table)
#endif
#if HWY_TARGETS & HWY_SCALAR
#define ALIDADE_CASE_SCALAR(table) \
  default:                         \
    return N_SCALAR::table;
#else
#define ALIDADE_CASE_SCALAR(table) \
  default:                         \
    return N_EMU128::table;
#endif

#define ALIDADE_CHOOSE_TABLE(instruction_set, table) \
  switch (instruction_set) {                         \
    ALIDADE_CASE_AVX512(table)                       \
    ALIDADE_CASE_AVX2(table)                         \
    ALIDADE_CASE_SSE4(table)                         \
    ALIDADE_CASE_SCALAR(table)                       \
  }
