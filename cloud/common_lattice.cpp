// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "cloud/cloud_source.h"
#include "cloud/fit_lattice.h"

namespace alidade {
namespace {

std::string text_of(const glm::dvec3& value) {
  return fmt::format("{}, {}, {}", value.x, value.y, value.z);
}

[[noreturn]] void refuse_lattice(const CloudSource& odd, const CloudSource& other) {
  const Lattice own = *odd.reader->lattice(), lattice = *other.reader->lattice();
  throw Error(
      {.file = odd.path().string(),
       .problem = "does not share the lattice of " + other.path().string(),
       .expected = fmt::format("scale {} and an offset that differs by whole steps (as PLY, by alidade "
                               "convert, it would be rounded to that)",
                               text_of(lattice.scale)),
       .found = fmt::format("scale {} and offset {}", text_of(own.scale), text_of(own.offset))});
}

/// Errors: of the files with points and a lattice, one does not share that of `first`.
void check_lattices(const std::vector<CloudSource>& sources, const CloudSource& first) {
  const Lattice lattice = *first.reader->lattice();
  std::size_t agreeing = 0, differing = 0;
  const CloudSource* odd = nullptr;
  for (const CloudSource& source : sources) {
    if (!source.has_lattice || source.point_count() == 0) continue;
    if (steps_between(*source.reader->lattice(), lattice)) {
      ++agreeing;
    } else if (differing++ == 0) {
      odd = &source;
    }
  }
  if (odd == nullptr) return;
  if (agreeing < differing) refuse_lattice(first, *odd);
  refuse_lattice(*odd, first);
}

}  // namespace

Lattice common_lattice(const std::vector<CloudSource>& sources) {
  const CloudSource* first = nullptr;
  for (const CloudSource& source : sources) {
    // The lattice of a file without points binds nobody, unless there is no other.
    if (!source.has_lattice || (first && (first->point_count() > 0 || source.point_count() == 0))) continue;
    first = &source;
  }
  if (!first) {
    std::vector<CoordinateSurvey> surveys;
    for (const CloudSource& source : sources) surveys.push_back(source.survey);
    return fit_lattice(surveys);
  }
  check_lattices(sources, *first);
  const Lattice lattice = *first->reader->lattice();
  for (const CloudSource& source : sources) {
    if (source.has_lattice || source.point_count() == 0) continue;
    const Bounds& bounds = source.survey.bounds;
    if (to_lattice(lattice, bounds.min) && to_lattice(lattice, bounds.max)) continue;
    throw Error({.file = source.path().string(),
                 .problem = "lies too far away for the lattice of " + first->path().string(),
                 .found = fmt::format("a box from {} to {}", text_of(bounds.min), text_of(bounds.max))});
  }
  return lattice;
}

}  // namespace alidade
