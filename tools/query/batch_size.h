// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>

namespace alidade {

/// How many targets to ask at once, so that threads have work, answers stay few enough to hold, and a batch
/// is done soon: between batches progress is told and the program can be interrupted.
class BatchSize {
 public:
  /// Targets of the next batch.
  std::size_t targets() const { return targets_; }

  /// Answers of one target that are asked for at first. A target that has more is asked again alone.
  std::size_t answers_per_target() const { return std::max(k_most_answers / targets_, k_least_limit); }

  /// Learns from a batch, which took so many seconds.
  void learn(std::size_t targets, std::size_t answers, double seconds) {
    if (targets == 0) return;
    const std::size_t mean = answers / targets + 1;
    const double in_time = k_wanted_seconds * static_cast<double>(targets) / std::max(seconds, 1e-6);
    const auto wanted =
        static_cast<std::size_t>(std::min(in_time, static_cast<double>(k_wanted_answers / mean)));
    targets_ = std::clamp(wanted, k_least_targets, std::min(4 * targets_, k_most_targets));
  }

 private:
  static constexpr std::size_t k_least_targets = 8, k_most_targets = 1 << 15;
  static constexpr std::size_t k_wanted_answers = 1 << 18, k_most_answers = 1 << 20;
  static constexpr std::size_t k_least_limit = 32;
  static constexpr double k_wanted_seconds = 0.2;

  std::size_t targets_ = 32;
};

}  // namespace alidade
