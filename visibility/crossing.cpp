// SPDX-License-Identifier: MIT
#include "visibility/crossing.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <tuple>
#include <vector>

#include "base/ray.h"
#include "octree/query.h"

namespace alidade::visibility {
namespace {

constexpr double k_infinite = std::numeric_limits<double>::infinity();

/// Where a point blocks a line, and the length of the line that counts as one crossing with it.
struct Crossing {
  Blocker blocker;
  double diameter;
};

bool comes_before(const Crossing& one, const Crossing& other) {
  return std::tie(one.blocker.distance, one.blocker.point_id) <
         std::tie(other.blocker.distance, other.blocker.point_id);
}

/// The crossings of one line that are found.
class Crossings {
 public:
  /// Of the crossings of one point, keeps the first.
  void add(const Crossing& crossing) {
    const auto same = std::ranges::find(found_, crossing.blocker.point_id,
                                        [](const Crossing& other) { return other.blocker.point_id; });
    if (same != found_.end()) {
      if (!comes_before(crossing, *same)) return;
      found_.erase(same);
    }
    found_.insert(std::ranges::upper_bound(found_, crossing, comes_before), crossing);
  }

  /// The k-th separate crossing.
  std::optional<Blocker> separate(int k) const {
    int count = 0;
    double end = -k_infinite;
    for (const auto& [blocker, diameter] : found_) {
      if (blocker.distance <= end) continue;
      if (++count == k) return blocker;
      end = blocker.distance + diameter;
    }
    return std::nullopt;
  }

  void clear() { found_.clear(); }

 private:
  std::vector<Crossing> found_;  ///< in their order
};

/// A line whose crossings are being found. The filter of a query for the closest point collects them: it
/// rejects all candidates until the crossings suffice, then admits the next one, which ends the query. During
/// a query the cut only moves nearer, so it never rejects a candidate that it has admitted (CandidateFilter).
class OpenLine {
 public:
  OpenLine(const Occluders& occluders, const ChordLines& lines, std::size_t line)
      : occluders_(&occluders), lines_(&lines), line_(line), chord_(lines.begin[line]) {
    has_ended_ = chord_ == lines.begin[line + 1];
    cut_off();
  }

  std::size_t line() const { return line_; }
  bool has_ended() const { return has_ended_; }
  std::optional<Blocker> blocker() const { return crossings_.separate(occluders_->options().transparency); }

  /// The part of a chord that is queried next.
  Ray ray() const {
    Ray ray = ray_of(*occluders_, chord());
    ray.t_min = std::max(ray.t_min, known_);
    return ray;
  }

  /// Whether collect() needs a candidate of that ray, if it counts.
  bool concerns(const Candidate& candidate) const {
    return candidate.t >= cut_ || position_crossing(*occluders_, chord(), candidate).has_value();
  }

  /// Takes a candidate of that ray. Returns whether the query may end: it and the
  /// candidates after it do not matter.
  bool collect(const Candidate& candidate) {
    if (candidate.t >= cut_) return true;
    const std::optional<double> t = crossing(*occluders_, chord(), candidate);
    if (!t) return false;
    crossings_.add(
        {{candidate.point_id, candidate.position, start() + *t}, 2.0 * width_of(*occluders_, candidate)});
    cut_off();
    return false;
  }

  /// Continues when all candidates of the ray, or those before the cut, were collected.
  void advance() {
    if (cut_ < k_infinite) {
      known_ = cut_;
      cut_ = k_infinite;
      cut_off();
      // A crossing that was found late may have moved the last one that matters farther away.
      if (cut_ > known_) return;
    }
    known_ = -k_infinite;
    cut_ = k_infinite;
    has_ended_ = ++chord_ == lines_->begin[line_ + 1];
    if (has_ended_) return;
    cut_off();
    // Nothing on the next chord comes before its start.
    has_ended_ = cut_ <= reach_before(*occluders_);
  }

 private:
  const SightLine& chord() const { return lines_->chords[chord_]; }
  double start() const { return lines_->starts[chord_]; }

  /// Sets where crossings come after the last one that matters.
  void cut_off() {
    if (has_ended_) return;
    const std::optional<Blocker> last = blocker();
    if (last) cut_ = std::min(cut_, last->distance - start() + reach_before(*occluders_) + k_rounding);
  }

  static constexpr double k_rounding = 1e-6;  // metres

  const Occluders* occluders_;
  const ChordLines* lines_;
  std::size_t line_, chord_;
  Crossings crossings_;
  double known_ = -k_infinite, cut_ = k_infinite;  ///< projections on the chord
  bool has_ended_ = false;
};

/// Answers some of the lines, [from, to).
void find_blockers(const Occluders& occluders, const ChordLines& lines, std::size_t from, std::size_t to,
                   std::span<std::optional<Blocker>> blockers) {
  std::vector<OpenLine> open_lines;
  open_lines.reserve(to - from);
  for (std::size_t line = from; line < to; ++line) open_lines.emplace_back(occluders, lines, line);
  CandidateFilter filter;
  const auto collect = [&](const Candidate& candidate) {
    return open_lines[candidate.query_index].collect(candidate);
  };
  if (occluders.options().counts) {
    filter.of_point = collect;
    filter.of_position = [&](const Candidate& candidate) {
      return open_lines[candidate.query_index].concerns(candidate);
    };
  } else {
    // Of points at one position the first in the order comes first, and the others
    // are not separate crossings.
    filter.of_position = collect;
  }
  std::vector<Ray> rays;
  const auto keep_going = [&] {
    std::erase_if(open_lines, [&](const OpenLine& line) {
      if (line.has_ended()) blockers[line.line()] = line.blocker();
      return line.has_ended();
    });
    return !open_lines.empty();
  };
  while (keep_going()) {
    occluders.check_given_up();
    rays.clear();
    for (const OpenLine& line : open_lines) rays.push_back(line.ray());
    with_query(occluders, [&](const auto& cloud, auto query) {
      query.filter = filter;
      std::vector<decltype(closest(cloud, rays.front(), query))> ends(rays.size());
      closest(cloud, rays, query, ends);
    });
    for (OpenLine& line : open_lines) line.advance();
  }
}

}  // namespace

void find_separate_blockers(const Occluders& occluders, const ChordLines& lines,
                            std::span<std::optional<Blocker>> blockers) {
  constexpr std::size_t k_chords_at_once = 1 << 14;  // their crossings are in memory together
  for (std::size_t from = 0, to = 0; from < blockers.size(); from = to) {
    while (to < blockers.size() && lines.begin[to] - lines.begin[from] < k_chords_at_once) ++to;
    find_blockers(occluders, lines, from, to, blockers);
  }
}

}  // namespace alidade::visibility
