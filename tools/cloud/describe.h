// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "cloud/point_cloud.h"

namespace alidade {

/// How the box in a file's header differs from that of its points, in words for people: how far it lies
/// beyond them ("wider"), how far they lie beyond it ("leaves out"). Empty if no face is off by more than a
/// hundredth of a step of the lattice, or if there are no points. Half a step is common and told, too: who
/// crops by the box loses points.
std::optional<std::string> header_box_text(const Bounds& stated, const Bounds& points,
                                           const Lattice& lattice);

/// Box of the rows [begin, end) of a cloud, of those of them that it has. Cost: linear.
Bounds bounds_of_rows(const PointCloud& cloud, std::size_t begin, std::size_t end);

}  // namespace alidade
