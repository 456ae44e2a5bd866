// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_FLIP_MATH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_FLIP_MATH_INL_H
#undef ALIDADE_FLIP_MATH_INL_H
#else
#define ALIDADE_FLIP_MATH_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace alidade::compare::simd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using FloatLanes = hn::CappedTag<float, 16>;
using FloatVector = hn::Vec<FloatLanes>;
using IntLanes = hn::RebindToSigned<FloatLanes>;

HWY_INLINE FloatVector set(float value) {
  return hn::Set(FloatLanes(), value);
}

/// To 0 .. 1; NaN becomes 0. (Which of two operands a lane's maximum takes with NaN depends on the machine.)
HWY_INLINE FloatVector clamped(FloatVector value) {
  return hn::IfThenElseZero(hn::Gt(value, hn::Zero(FloatLanes())), hn::Min(value, set(1.0f)));
}

/// Relative error below 2e-7 for x in [1e-3, 2]. Source: Halley's method, twice, from the exponent divided by
/// three.
HWY_INLINE FloatVector cube_root(FloatVector x) {
  const IntLanes ints;
  const auto third = hn::Mul(hn::ConvertTo(FloatLanes(), hn::BitCast(ints, x)), set(1.0f / 3.0f));
  auto y = hn::BitCast(FloatLanes(), hn::Add(hn::ConvertTo(ints, third), hn::Set(ints, 709921077)));
  for (int i = 0; i < 2; ++i) {
    const auto cube = hn::Mul(hn::Mul(y, y), y);
    const auto twice = hn::Add(cube, cube);
    y = hn::Mul(y, hn::Div(hn::Add(cube, hn::Add(x, x)), hn::Add(twice, x)));
  }
  return y;
}

/// Error below 2e-7 of the larger of 1 and the result, for x in [1e-37, 1e37]. Series: as binary_logarithm().
HWY_INLINE FloatVector log2_of(FloatVector x) {
  const IntLanes ints;
  const auto bits = hn::BitCast(ints, x);
  // The bits of sqrt(1/2): mantissas lie on both sides of 1.
  const auto exponent = hn::ShiftRight<23>(hn::Sub(bits, hn::Set(ints, 0x3f3504f3)));
  const auto mantissa = hn::BitCast(FloatLanes(), hn::Sub(bits, hn::ShiftLeft<23>(exponent)));
  const auto s = hn::Div(hn::Sub(mantissa, set(1.0f)), hn::Add(mantissa, set(1.0f)));
  const auto s2 = hn::Mul(s, s);
  constexpr float k_twice_log2e = 2.88539008f;
  auto sum = set(k_twice_log2e / 9.0f);
  for (const float divisor : {7.0f, 5.0f, 3.0f, 1.0f})
    sum = hn::Add(hn::Mul(sum, s2), set(k_twice_log2e / divisor));
  return hn::Add(hn::ConvertTo(FloatLanes(), exponent), hn::Mul(s, sum));
}

/// 2^y, for y clamped to [-126, 126]. Relative error below 2e-7. Source: Taylor series around the nearest
/// integer.
HWY_INLINE FloatVector exp2_of(FloatVector y) {
  const IntLanes ints;
  y = hn::Min(hn::Max(y, set(-126.0f)), set(126.0f));
  // Conversion cuts off, towards 0 on every machine; so the number is made positive first.
  const auto whole = hn::Sub(hn::ConvertTo(ints, hn::Add(y, set(128.5f))), hn::Set(ints, 128));
  const auto x = hn::Mul(hn::Sub(y, hn::ConvertTo(FloatLanes(), whole)), set(0.693147181f));
  auto sum = set(1.0f / 5040.0f);
  for (const float factor : {1.0f / 720.0f, 1.0f / 120.0f, 1.0f / 24.0f, 1.0f / 6.0f, 0.5f, 1.0f, 1.0f})
    sum = hn::Add(hn::Mul(sum, x), set(factor));
  const auto power = hn::ShiftLeft<23>(hn::Add(whole, hn::Set(ints, 127)));
  return hn::Mul(sum, hn::BitCast(FloatLanes(), power));
}

/// base^exponent for base in [0, 1e30] and exponent in [0, 1]; 0^0 = 1.
HWY_INLINE FloatVector power(FloatVector base, FloatVector exponent) {
  constexpr float k_nearly_zero = 1e-30f;
  const auto zero = hn::Zero(FloatLanes());
  const auto result = exp2_of(hn::Mul(log2_of(hn::Max(base, set(k_nearly_zero))), exponent));
  const auto is_zero = hn::And(hn::Le(base, zero), hn::Gt(exponent, zero));
  return hn::IfThenElse(is_zero, zero, result);
}

}  // namespace HWY_NAMESPACE
}  // namespace alidade::compare::simd
HWY_AFTER_NAMESPACE();

#endif
