// SPDX-License-Identifier: MIT
#include "visibility/points/placement.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numeric>
#include <queue>

#include "base/error.h"

namespace alidade::visibility {
namespace {

void check(const Coverage& coverage, std::size_t count, std::span<const double> weights) {
  check_that(count > 0, "invalid number of positions", "at least 1");
  check_that(weights.empty() || weights.size() == coverage.targets(),
             "the number of weights differs from the number of targets", std::to_string(coverage.targets()),
             std::to_string(weights.size()));
  const auto wrong =
      std::ranges::find_if(weights, [](double weight) { return !(weight >= 0.0 && std::isfinite(weight)); });
  if (wrong != weights.end())
    check_that(false, "invalid target weight", "at least 0", std::to_string(*wrong));
}

/// The targets seen by the chosen candidates, and the gain of a further one. Sums run over the targets in
/// their order: rounding never makes a sum of fewer terms larger, so computed gains do not grow, either.
class Covered {
 public:
  Covered(const Coverage& coverage, std::span<const double> weights)
      : coverage_(coverage), weights_(weights), words_((coverage.targets() + 63) / 64) {}

  double gain(std::size_t candidate) const {
    const std::span<const std::uint64_t> row = coverage_.row(candidate);
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
      std::uint64_t added = row[i] & ~words_[i];
      if (weights_.empty()) {
        count += static_cast<std::size_t>(std::popcount(added));
        continue;
      }
      for (; added != 0; added &= added - 1)
        sum += weights_[64 * i + static_cast<std::size_t>(std::countr_zero(added))];
    }
    return weights_.empty() ? static_cast<double>(count) : sum;
  }

  void add(std::size_t candidate) {
    const std::span<const std::uint64_t> row = coverage_.row(candidate);
    for (std::size_t i = 0; i < row.size(); ++i) words_[i] |= row[i];
  }

 private:
  const Coverage& coverage_;
  std::span<const double> weights_;
  std::vector<std::uint64_t> words_;
};

/// A candidate with its gain at the time when so many were chosen.
struct Offer {
  double gain;
  std::size_t candidate;
  std::size_t chosen;
  /// Whether `other` is to be examined first.
  bool operator<(const Offer& other) const {
    return gain < other.gain || (gain == other.gain && candidate > other.candidate);
  }
};

double sum_of_largest(std::vector<double> gains, std::size_t count) {
  count = std::min(count, gains.size());
  std::ranges::sort(gains, std::greater());
  return std::accumulate(gains.begin(), gains.begin() + static_cast<std::ptrdiff_t>(count), 0.0);
}

std::vector<double> all_gains(const Coverage& coverage, const Covered& covered) {
  std::vector<double> gains(coverage.candidates());
  for (std::size_t i = 0; i < gains.size(); ++i) gains[i] = covered.gain(i);
  return gains;
}

std::vector<Row> rows_of(const Placement& placement, std::span<const Observer> candidates) {
  std::vector<Row> rows;
  for (const ChosenPosition& chosen : placement.positions) {
    const Observer& observer = candidates[chosen.candidate];
    Row row;
    row["place"] = rows.size() + 1;
    row["candidate"] = chosen.candidate;
    row["name"] = observer.name;
    row["x"] = observer.position.x;
    row["y"] = observer.position.y;
    row["z"] = observer.position.z;
    row["gain"] = chosen.gain;
    row["covered"] = chosen.covered;
    row["share"] = chosen.covered / placement.total;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

Placement choose_places(const Coverage& coverage, std::size_t count, std::span<const double> weights) {
  check(coverage, count, weights);
  Placement placement;
  placement.total = weights.empty() ? static_cast<double>(coverage.targets())
                                    : std::accumulate(weights.begin(), weights.end(), 0.0);
  Covered covered(coverage, weights);
  const std::vector<double> alone = all_gains(coverage, covered);
  std::priority_queue<Offer> offers;
  for (std::size_t i = 0; i < alone.size(); ++i) offers.push({alone[i], i, 0});
  double sum = 0.0;
  // No choice covers more than all targets, or than what is covered at any time plus the largest gains of as
  // many candidates as requested, as if these saw no target twice.
  double bound = std::min(placement.total, sum_of_largest(alone, count));
  std::size_t next_bound = 1;
  while (placement.positions.size() < count && !offers.empty()) {
    const Offer offer = offers.top();
    offers.pop();
    if (offer.chosen < placement.positions.size()) {
      offers.push({covered.gain(offer.candidate), offer.candidate, placement.positions.size()});
      continue;
    }
    if (offer.gain <= 0.0) break;
    covered.add(offer.candidate);
    sum += offer.gain;
    placement.positions.push_back({offer.candidate, offer.gain, sum});
    // Not after each choice, since the gains of all candidates take a pass over the bits.
    if (placement.positions.size() != next_bound) continue;
    bound = std::min(bound, sum + sum_of_largest(all_gains(coverage, covered), count));
    next_bound *= 2;
  }
  bound = std::min(bound, sum + sum_of_largest(all_gains(coverage, covered), count));
  placement.best_possible = std::max(bound, sum);
  return placement;
}

bool write_placement(const Placement& placement, std::span<const Observer> candidates, RowForm form,
                     const RowFileHead& head, const ToLonLat& to_lon_lat, const std::filesystem::path& file,
                     bool overwrite) {
  PositionTable table{.list = "places", .rows = rows_of(placement, candidates), .positions = {}};
  for (const ChosenPosition& chosen : placement.positions)
    table.positions.push_back(candidates[chosen.candidate].position);
  const Row totals{{"total", placement.total}, {"best_possible", placement.best_possible}};
  return write_positions(table, totals, form, head, to_lon_lat, file, overwrite);
}

}  // namespace alidade::visibility
