// SPDX-License-Identifier: MIT
#include "cloud/polygon_strips.h"

#include <algorithm>
#include <limits>

namespace alidade {
namespace {

constexpr std::size_t k_most_strips = 1 << 16;
/// An edge stands in this many strips on average at most.
constexpr std::size_t k_most_strips_per_edge = 4;

}  // namespace

PolygonStrips::PolygonStrips(std::span<const PlanePolygon> polygons, double border)
    : border_(border),
      low_(std::numeric_limits<double>::infinity()),
      high_(-std::numeric_limits<double>::infinity()) {
  for (std::size_t polygon = 0; polygon < polygons.size(); ++polygon) {
    for (const std::vector<glm::dvec2>& ring : polygons[polygon].rings) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        edges_.push_back({ring[i], ring[i + 1 < ring.size() ? i + 1 : 0], polygon});
        for (int axis = 0; axis < 2; ++axis) {
          low_[axis] = std::min(low_[axis], ring[i][axis] - border_);
          high_[axis] = std::max(high_[axis], ring[i][axis] + border_);
        }
      }
    }
  }
  strip_count_ = std::clamp<std::size_t>(edges_.size(), 1, k_most_strips);
  places_ = strip_places();
  // Edges that run from south to north stand in all strips: fewer of these then.
  while (strip_count_ > 1 && places_.back() > k_most_strips_per_edge * edges_.size()) {
    strip_count_ /= 2;
    places_ = strip_places();
  }
  strip_edges_.resize(places_.back());
  std::vector<std::size_t> next = places_;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const auto [south, north] = std::minmax(edges_[i].a.y, edges_[i].b.y);
    for (std::size_t strip = strip_of(south - border_); strip <= strip_of(north + border_); ++strip)
      strip_edges_[next[strip]++] = i;
  }
}

std::size_t PolygonStrips::strip_of(double y) const {
  const double strip = (y - low_.y) / (high_.y - low_.y) * static_cast<double>(strip_count_);
  // Also for polygons without height, whose quotient is no number.
  if (!(strip > 0.0)) return 0;
  return strip < static_cast<double>(strip_count_) ? static_cast<std::size_t>(strip) : strip_count_ - 1;
}

std::vector<std::size_t> PolygonStrips::strip_places() const {
  // Edges that begin in a strip and those that have ended before it: what lies between are the strip's.
  std::vector<std::size_t> begun(strip_count_, 0), ended(strip_count_ + 1, 0);
  for (const Edge& edge : edges_) {
    const auto [south, north] = std::minmax(edge.a.y, edge.b.y);
    ++begun[strip_of(south - border_)];
    ++ended[strip_of(north + border_) + 1];
  }
  std::vector<std::size_t> places(strip_count_ + 1, 0);
  std::size_t present = 0;
  for (std::size_t strip = 0; strip < strip_count_; ++strip) {
    present += begun[strip] - ended[strip];
    places[strip + 1] = places[strip] + present;
  }
  return places;
}

bool PolygonStrips::on_border(const Edge& edge, const glm::dvec2& place) const {
  for (int axis = 0; axis < 2; ++axis) {
    if (place[axis] < std::min(edge.a[axis], edge.b[axis]) - border_ ||
        place[axis] > std::max(edge.a[axis], edge.b[axis]) + border_)
      return false;
  }
  const glm::dvec2 along = edge.b - edge.a, from = place - edge.a;
  const double length = along.x * along.x + along.y * along.y;
  const double share =
      length > 0.0 ? std::clamp((from.x * along.x + from.y * along.y) / length, 0.0, 1.0) : 0.0;
  const glm::dvec2 beside = from - share * along;
  return beside.x * beside.x + beside.y * beside.y <= border_ * border_;
}

bool PolygonStrips::contains(const glm::dvec2& place) const {
  if (!(place.x >= low_.x && place.x <= high_.x && place.y >= low_.y && place.y <= high_.y)) return false;
  const std::size_t strip = strip_of(place.y);
  bool inside = false;
  std::size_t polygon = 0;
  for (std::size_t i = places_[strip]; i < places_[strip + 1]; ++i) {
    const Edge& edge = edges_[strip_edges_[i]];
    if (edge.polygon != polygon) {
      if (inside) return true;
      polygon = edge.polygon;
    }
    if (on_border(edge, place)) return true;
    // The southern end belongs to an edge and the northern does not, so that a corner is passed once.
    if ((edge.a.y <= place.y) == (edge.b.y <= place.y)) continue;
    const double crossing = edge.a.x + (place.y - edge.a.y) / (edge.b.y - edge.a.y) * (edge.b.x - edge.a.x);
    if (crossing > place.x) inside = !inside;
  }
  return inside;
}

}  // namespace alidade
