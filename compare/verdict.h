// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "compare/metric.h"

namespace alidade {

/// Which values go beyond a limit. The limit itself never does.
enum class LimitKind {
  worse,  ///< '=': above it where lower is better (errors), below it where higher is better (PSNR, SSIM)
  below,  ///< '<'
  above   ///< '>'
};

/// A limit on a figure (compare/metric.h).
struct Threshold {
  std::string metric;
  LimitKind kind = LimitKind::worse;
  double limit = 0.0;
};

/// "flip=0.05,psnr<30": thresholds between commas, each a name, one of = < > and a number or inf. Errors: an
/// empty list, an unknown name (with the nearest known one), anything else behind the name, NaN.
std::vector<Threshold> parse_thresholds(const std::string& text);

/// "flip=0.05", as it is read.
std::string to_text(const Threshold& threshold);

/// A threshold and what was measured.
struct JudgedThreshold {
  Threshold threshold;
  double value = 0.0;
  bool fails_below = false;  ///< which side of the limit fails
  bool fails = false;
};

struct Verdict {
  std::vector<JudgedThreshold> judged;  ///< in the order of the thresholds

  bool pass() const;
};

/// Judges a comparison; without thresholds it passes. NaN fails: what cannot be measured is not good enough.
/// Errors: a threshold on what these pictures do not have (no depth layer, alignment not asked for).
Verdict judge(const Comparison& comparison, const std::vector<Threshold>& thresholds);

}  // namespace alidade
