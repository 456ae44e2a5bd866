// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace alidade::simd {

/// Order of a target's answers (octree/query_targets.h), as the standard algorithms take it.
template <class Target>
struct Precedes {
  const Target& target;
  bool operator()(const typename Target::Answer& a, const typename Target::Answer& b) const {
    return target.precedes(a, b);
  }
};

/// The k first of the answers given to it, behind those that a list already has. Some more than k are kept,
/// so that the list is rarely gone through.
template <class Target>
class FirstAnswers {
 public:
  using Answer = typename Target::Answer;

  FirstAnswers(const Target& target, std::size_t k, std::vector<Answer>& answers)
      : target_(target), k_(k), answers_(answers), first_(answers.size()) {
    constexpr std::size_t k_most_at_once = 256;
    const std::size_t room = first_ + std::min(k, k_most_at_once) + k_few;
    if (answers.capacity() < room) answers.reserve(std::max(2 * answers.capacity(), room));
  }

  void insert(const Answer& answer) {
    answers_.push_back(answer);
    if (answers_.size() - first_ < 2 * k_ + k_few) return;
    std::nth_element(begin(), begin() + static_cast<std::ptrdiff_t>(k_ - 1), answers_.end(),
                     Precedes<Target>{target_});
    answers_.resize(first_ + k_);
    limit_ = target_.measured(answers_.back());
  }

  /// No answer of a greater measure is one of the k first.
  double limit() const { return limit_; }

  /// Puts them in order.
  void finish() {
    std::sort(begin(), answers_.end(), Precedes<Target>{target_});
    if (answers_.size() - first_ > k_) answers_.resize(first_ + k_);
  }

 private:
  static constexpr std::size_t k_few = 16;

  auto begin() { return answers_.begin() + static_cast<std::ptrdiff_t>(first_); }

  const Target& target_;
  const std::size_t k_;
  std::vector<Answer>& answers_;
  const std::size_t first_;
  double limit_ = std::numeric_limits<double>::infinity();
};

}  // namespace alidade::simd
