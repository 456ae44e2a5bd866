// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cloud/select_points.h"

namespace alidade {

/// The edges of polygons, sorted into strips from south to north, to ask about many places.
class PolygonStrips {
 public:
  /// Places up to `border` outside count as on the border. Corners are finite.
  PolygonStrips(std::span<const PlanePolygon> polygons, double border);

  /// Whether a place lies in one of the polygons or on a border.
  bool contains(const glm::dvec2& place) const;

 private:
  struct Edge {
    glm::dvec2 a, b;
    std::size_t polygon;
  };

  std::size_t strip_of(double y) const;
  /// Where the edges of each strip begin in `strip_edges_`, and behind the last where they end.
  std::vector<std::size_t> strip_places() const;
  bool on_border(const Edge& edge, const glm::dvec2& place) const;

  std::vector<Edge> edges_;  ///< those of one polygon stand together
  double border_;
  glm::dvec2 low_, high_;  ///< box of all edges with their border
  std::size_t strip_count_ = 1;
  std::vector<std::size_t> places_;       ///< see strip_places()
  std::vector<std::size_t> strip_edges_;  ///< of each strip, in the order of `edges_`
};

}  // namespace alidade
