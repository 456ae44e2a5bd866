// SPDX-License-Identifier: MIT
#include "visibility/points/coverage.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/checkpoint.h"
#include "base/error.h"
#include "geo/raster.h"

namespace alidade {
namespace {

constexpr std::size_t k_lines_at_once = 1 << 18;

/// Some of the targets, those that lie within reach and view, and the lines to these.
struct Views {
  std::vector<std::size_t> targets;
  std::vector<SightLine> lines;
};

/// A block of the targets. `ends`: where the lines to them end; empty if they end on the points themselves,
/// which depends on who looks.
struct TargetBlock {
  std::span<const PlacementTarget> targets;
  std::span<const SightEnd> ends;
};

std::vector<SightEnd> raised_ends(const Occluders& occluders, std::span<const PlacementTarget> targets,
                                  double height) {
  std::vector<SightEnd> ends(targets.size());
  tbb::parallel_for(std::size_t{0}, targets.size(), [&](std::size_t i) {
    ends[i] = end_near_surface(occluders, targets[i].position + glm::dvec3(0.0, 0.0, height));
  });
  return ends;
}

Views views_of(const Occluders& occluders, const Observer& observer, const TargetBlock& block) {
  const std::span<const PlacementTarget> targets = block.targets;
  const std::span<const SightEnd> ends = block.ends;
  const FieldOfView field(observer);
  const SightEnd eye = end_near_surface(occluders, observer.position);
  Views views;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const glm::dvec3& place = ends.empty() ? targets[i].position : ends[i].position;
    if (field.reaches(place - observer.position)) views.targets.push_back(i);
  }
  views.lines.resize(views.targets.size());
  tbb::parallel_for(std::size_t{0}, views.lines.size(), [&](std::size_t i) {
    const std::size_t number = views.targets[i];
    const PlacementTarget& target = targets[number];
    views.lines[i] = sight_line(
        eye, ends.empty() ? end_on_point(occluders, target.point_id, target.position, observer.position)
                          : ends[number]);
  });
  return views;
}

/// A bit for each target, as Coverage::row() has them.
std::vector<std::uint64_t> seen_by(const Occluders& occluders, const Observer& observer,
                                   const TargetBlock& block) {
  const Views views = views_of(occluders, observer, block);
  std::vector<std::uint8_t> hidden(views.lines.size());
  blocked(occluders, views.lines, hidden);
  std::vector<std::uint64_t> words((block.targets.size() + 63) / 64);
  for (std::size_t i = 0; i < hidden.size(); ++i) {
    const std::size_t target = views.targets[i];
    if (hidden[i] == 0) words[target / 64] |= std::uint64_t{1} << (target % 64);
  }
  return words;
}

}  // namespace

void check_coverage(std::size_t candidates, std::size_t targets) {
  const std::uint64_t row_bytes = std::uint64_t{8} * ((targets + 63) / 64);
  std::uint64_t bytes = 0;
  if (__builtin_mul_overflow(std::uint64_t{candidates}, row_bytes, &bytes) ||
      __builtin_add_overflow(bytes, std::uint64_t{sizeof(SightEnd)} * targets, &bytes))
    bytes = std::numeric_limits<std::uint64_t>::max();
  check_memory(bytes, "who of the candidates sees which of the targets");
}

Coverage::Coverage(std::size_t candidates, std::size_t targets)
    : candidates_(candidates), targets_(targets), row_words_((targets + 63) / 64) {
  check_coverage(candidates, targets);
  words_.resize(candidates_ * row_words_);
}

Coverage see_targets(const Occluders& occluders, std::span<const Observer> candidates,
                     std::span<const PlacementTarget> targets, double height, const Progress& progress,
                     FinishedParts* parts) {
  if (!(height >= 0.0 && std::isfinite(height))) {
    throw Error(
        {.problem = "bad height of targets", .expected = "0 or more", .found = std::to_string(height)});
  }
  static_assert(k_lines_at_once % 64 == 0);
  Coverage coverage(candidates.size(), targets.size());
  const std::size_t blocks = (targets.size() + k_lines_at_once - 1) / k_lines_at_once;
  const auto block = [&](std::uint64_t part) {
    const std::size_t first = part % blocks * k_lines_at_once;
    return targets.subspan(first, std::min(k_lines_at_once, targets.size() - first));
  };
  // Of each block, from when it is first looked at.
  std::vector<std::vector<SightEnd>> ends(blocks);
  std::uint64_t done = 0;
  run_parts(
      parts, std::uint64_t{candidates.size()} * blocks,
      [&](std::uint64_t part, PartWriter& writer) {
        std::vector<SightEnd>& block_ends = ends[part % blocks];
        if (height > 0.0 && block_ends.empty()) block_ends = raised_ends(occluders, block(part), height);
        const std::vector<std::uint64_t> words =
            seen_by(occluders, candidates[part / blocks], {block(part), block_ends});
        writer.put_all(words);
      },
      [&](std::uint64_t part, PartReader& reader) {
        const std::size_t count = block(part).size();
        std::vector<std::uint64_t> words((count + 63) / 64);
        reader.take_all(words);
        reader.require(count % 64 == 0 || words.back() >> (count % 64) == 0);
        coverage.set_words(part / blocks, part % blocks * (k_lines_at_once / 64), words);
        report(progress, done += count, std::uint64_t{candidates.size()} * targets.size());
      });
  return coverage;
}

}  // namespace alidade
