// SPDX-License-Identifier: MIT
#include "base/error.h"
#include "cloud/cloud_source.h"
#include "cloud/crs_name.h"

namespace alidade {
namespace {

[[noreturn]] void refuse_crs(const CloudSource& odd, const CloudSource& other) {
  throw Error({.file = odd.path().string(),
               .problem = "states another coordinate reference system than " + other.path().string(),
               .expected = crs_name(other.facts.crs) +
                           " (transform the file to it, or leave it out and read it by itself)",
               .found = crs_name(odd.facts.crs)});
}

}  // namespace

Crs common_crs(const std::vector<CloudSource>& sources) {
  const CloudSource* first = nullptr;
  for (const CloudSource& source : sources) {
    // What a file without points says binds nobody, unless there is no other.
    if (source.facts.crs.empty() || (first && (first->point_count() > 0 || source.point_count() == 0)))
      continue;
    first = &source;
  }
  if (first == nullptr) return {};
  std::size_t agreeing = 0, differing = 0;
  const CloudSource* odd = nullptr;
  for (const CloudSource& source : sources) {
    if (source.facts.crs.empty() || source.point_count() == 0) continue;
    if (compare_crs(source.facts.crs, first->facts.crs) != CrsAgreement::different) {
      ++agreeing;
    } else if (differing++ == 0) {
      odd = &source;
    }
  }
  if (odd == nullptr) return first->facts.crs;
  if (agreeing < differing) refuse_crs(*first, *odd);
  refuse_crs(*odd, *first);
}

}  // namespace alidade
