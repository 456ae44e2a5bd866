// SPDX-License-Identifier: MIT
#include "compare/photographs/robust_line.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace alidade {
namespace {

constexpr int k_starts = 64, k_first_steps = 2, k_most_steps = 50;
constexpr std::size_t k_finalists = 8, k_least_pairs = 4;

struct Line {
  double scale = 0.0, offset = 0.0;
};

/// A line and the sum of the squares of the smaller half of its residuals.
struct Trial {
  Line line;
  double cost = 0.0;
};

/// Mixes a counter into 64 bits; S. Vigna, splitmix64 (2015).
std::uint64_t mixed(std::uint64_t counter) {
  std::uint64_t z = (counter + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

class LineFitter {
 public:
  LineFitter(std::span<const LinePair> pairs, LineKind kind)
      : pairs_(pairs), kind_(kind), weights_(pairs.size()), residuals_(pairs.size()) {
    std::vector<double> heights;
    heights.reserve(pairs.size());
    for (const LinePair& pair : pairs) heights.push_back(std::abs(pair.y));
    const double middle = median(heights);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double sum = heights[i] + middle;
      weights_[i] = sum > 0.0 ? 1.0 / sum : 1.0;
    }
  }

  std::optional<RobustLine> fit() {
    std::vector<Trial> trials;
    for (int start = 0; start < k_starts; ++start) {
      std::optional<Line> line = through(mixed(2 * static_cast<std::uint64_t>(start)),
                                         mixed(2 * static_cast<std::uint64_t>(start) + 1));
      for (int step = 0; step < k_first_steps && line; ++step) line = concentrated(*line);
      if (line) trials.push_back({*line, cost(*line)});
    }
    if (trials.empty()) return {};
    std::ranges::stable_sort(trials, {}, &Trial::cost);
    if (trials.size() > k_finalists) trials.resize(k_finalists);
    for (Trial& trial : trials) finish(trial);
    return reweighted(std::ranges::min_element(trials, {}, &Trial::cost)->line);
  }

 private:
  std::size_t half() const { return pairs_.size() / 2 + 1; }

  /// Least squares over the pairs that `takes`; empty if they do not tell.
  template <typename Takes>
  std::optional<Line> least_squares(const Takes& takes) const {
    double w = 0.0, wx = 0.0, wy = 0.0;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (!takes(i)) continue;
      const double weight = weights_[i] * weights_[i];
      w += weight;
      wx += weight * pairs_[i].x;
      wy += weight * pairs_[i].y;
    }
    if (!(w > 0.0)) return {};
    const bool is_free = kind_ == LineKind::free;
    const double middle_x = is_free ? wx / w : 0.0, middle_y = is_free ? wy / w : 0.0;
    double xx = 0.0, xy = 0.0, size = 0.0;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (!takes(i)) continue;
      const double weight = weights_[i] * weights_[i];
      const double x = pairs_[i].x - middle_x;
      xx += weight * x * x;
      xy += weight * x * (pairs_[i].y - middle_y);
      size += weight * pairs_[i].x * pairs_[i].x;
    }
    // Of one value up to rounding: any slope would do.
    constexpr double k_least_spread = 1e-10;
    if (!(xx > k_least_spread * size) || !(xx > 0.0)) return {};
    const double scale = xy / xx;
    return Line{scale, middle_y - scale * middle_x};
  }

  /// The line through one or two pairs, as the random numbers choose them.
  std::optional<Line> through(std::uint64_t first, std::uint64_t second) const {
    const std::size_t a = first % pairs_.size(), b = second % pairs_.size();
    const LinePair &one = pairs_[a], &two = pairs_[b];
    if (kind_ == LineKind::through_zero) {
      if (one.x == 0.0) return {};
      return Line{one.y / one.x, 0.0};
    }
    if (one.x == two.x) return {};
    const double scale = (two.y - one.y) / (two.x - one.x);
    return Line{scale, one.y - scale * one.x};
  }

  /// Fills residuals_ with magnitudes and returns the largest one of the smaller half.
  double measure(const Line& line) {
    for (std::size_t i = 0; i < pairs_.size(); ++i)
      residuals_[i] = weights_[i] * std::abs(pairs_[i].y - line.scale * pairs_[i].x - line.offset);
    sorted_ = residuals_;
    const auto last = sorted_.begin() + static_cast<std::ptrdiff_t>(half() - 1);
    std::ranges::nth_element(sorted_, last);
    return *last;
  }

  std::optional<Line> concentrated(const Line& line) {
    const double limit = measure(line);
    return least_squares([&](std::size_t i) { return residuals_[i] <= limit; });
  }

  double cost(const Line& line) {
    const double limit = measure(line);
    double sum = 0.0;
    std::size_t count = 0;
    for (const double residual : residuals_) {
      if (!(residual < limit)) continue;
      sum += residual * residual;
      ++count;
    }
    // Equal residuals at the limit are all the same to the sum.
    return sum + static_cast<double>(half() - count) * limit * limit;
  }

  void finish(Trial& trial) {
    for (int step = 0; step < k_most_steps; ++step) {
      const std::optional<Line> next = concentrated(trial.line);
      if (!next) return;
      const double next_cost = cost(*next);
      if (!(next_cost < trial.cost)) return;
      trial = {*next, next_cost};
    }
  }

  std::optional<RobustLine> reweighted(const Line& line) {
    // The median of normal residuals' magnitudes is 0.6745 standard deviations. Residuals are relative, so a
    // hundred thousandth is nothing that anyone sees.
    constexpr double k_deviations = 2.5, k_least_deviation = 1e-5;
    const double limit = k_deviations * std::max(measure(line) / 0.6745, k_least_deviation);
    const std::optional<Line> all = least_squares([&](std::size_t i) { return residuals_[i] <= limit; });
    if (!all) return {};
    measure(*all);
    const auto inliers =
        std::ranges::count_if(residuals_, [&](double residual) { return residual <= limit; });
    return RobustLine{all->scale, all->offset,
                      static_cast<double>(inliers) / static_cast<double>(pairs_.size())};
  }

  std::span<const LinePair> pairs_;
  LineKind kind_;
  std::vector<double> weights_, residuals_, sorted_;
};

}  // namespace

std::optional<RobustLine> fit_robust_line(std::span<const LinePair> pairs, LineKind kind) {
  if (pairs.size() < k_least_pairs) return {};
  return LineFitter(pairs, kind).fit();
}

}  // namespace alidade
