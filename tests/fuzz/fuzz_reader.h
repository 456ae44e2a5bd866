// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>

#include "base/error.h"
#include "cloud/cloud_reader.h"
#include "cloud/lattice.h"

namespace alidade::test {

/// Any bytes through a reader: an Error, or a cloud that agrees with its survey and has at most
/// `largest_ratio` points for each byte of input.
template <class Open>
void fuzz_opened(const Open& open, const std::uint8_t* data, std::size_t size, std::size_t largest_ratio) {
  try {
    const std::unique_ptr<CloudReader> reader =
        open(InputFile(std::as_bytes(std::span(data, size)), "input"));
    const CoordinateSurvey survey = reader->survey({});
    PointCloud cloud;
    cloud.lattice = fit_lattice({&survey, 1});
    reader->rest();
    reader->read(cloud, AttributeSet::all(), {}, {});
    if (cloud.size() != survey.finite_count || cloud.size() > largest_ratio * size) std::abort();
    for (const ExtraDimension& dimension : cloud.extra_dimensions) {
      if (dimension.values.size() != cloud.size() * static_cast<std::size_t>(dimension.byte_count))
        std::abort();
    }
    // The survey's bounds must be those of the points, to within a step of the lattice.
    const Bounds bounds = cloud.bounds();
    for (int axis = 0; axis < 3 && cloud.size() > 0; ++axis) {
      const double step = cloud.lattice.scale[axis] * (1.0 + 1e-9) +
                          1e-9 * std::abs(survey.bounds.max[axis]) + 1e-9 * std::abs(survey.bounds.min[axis]);
      if (!(std::abs(bounds.min[axis] - survey.bounds.min[axis]) <= step)) std::abort();
      if (!(std::abs(bounds.max[axis] - survey.bounds.max[axis]) <= step)) std::abort();
    }
  } catch (const Error&) {
  }
}

/// fuzz_opened() by a function of cloud_reader.h, with and without reading over damage.
inline void fuzz_damaged(std::unique_ptr<CloudReader> (*open)(InputFile, Damage), const std::uint8_t* data,
                         std::size_t size, std::size_t largest_ratio) {
  for (const Damage damage : {Damage::reject, Damage::read_over}) {
    fuzz_opened([&](InputFile file) { return open(std::move(file), damage); }, data, size, largest_ratio);
  }
}

}  // namespace alidade::test
