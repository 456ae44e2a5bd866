// SPDX-License-Identifier: MIT
#include "surface/surface_fitter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "octree/spacing.h"
#include "octree/tree_walk.h"
#include "surface/local_plane.h"
#include "surface/packed_surface.h"
#include "surface/point_surface.h"
#include "surface/simd/moments.h"

namespace alidade {
namespace {

using packed_surface::k_edge_directions;

// In spacings.
constexpr double k_reach = 2.5, k_least_support = 1.5;
/// What lies within this of a line in some direction determines how far the sheet reaches there: some nine
/// points between the edge and the reach.
constexpr double k_half_width = 1.2;

const std::array<glm::vec2, k_edge_directions>& float_directions() {
  static const std::array<glm::vec2, k_edge_directions> all = [] {
    std::array<glm::vec2, k_edge_directions> made{};
    std::ranges::transform(packed_surface::edge_directions(), made.begin(),
                           [](const glm::dvec2& d) { return glm::vec2(d); });
    return made;
  }();
  return all;
}

constexpr double k_least_sheet_trust = 0.8;  // of one of two sheets

/// The number of the length in packed_surface::k_lengths that is nearest.
std::uint32_t nearest_length(double length) {
  using packed_surface::k_lengths;
  const auto above = std::ranges::lower_bound(k_lengths, length);
  if (above == k_lengths.begin()) return 0;
  if (above == k_lengths.end()) return packed_surface::k_length_mask;
  const auto index = static_cast<std::uint32_t>(above - k_lengths.begin());
  return length - k_lengths[index - 1] < k_lengths[index] - length ? index - 1 : index;
}

/// The number of the least length that is not smaller, or of the greatest.
std::uint32_t length_above(double length) {
  using packed_surface::k_lengths;
  const auto above = std::ranges::lower_bound(k_lengths, length);
  return above == k_lengths.end() ? packed_surface::k_length_mask
                                  : static_cast<std::uint32_t>(above - k_lengths.begin());
}

/// A surface in 32 bits (surface/packed_surface.h). unit: PointLayers::surface_unit, metres.
std::uint32_t pack(const PointSurface& surface, double unit) {
  using namespace packed_surface;
  if (!surface.exists) return 0;
  const glm::uvec2 normal = pack_normal(surface.normal, k_side_steps);
  // Packing keeps the upper one of the two normals.
  const bool turned = surface.normal.z < 0.0;
  const bool below = (surface.height < 0.0) != turned;
  return k_exists | normal.x << k_first_side | normal.y << k_second_side | (below ? k_below : 0u) |
         nearest_length(std::fabs(surface.height) / unit) << k_height |
         length_above(surface.thickness / unit);
}

/// The points within reach of a position.
class PointsNear {
 public:
  /// points: of a ball with this reach.
  PointsNear(const simd::LocalSums& sums, const simd::BallPoints& points, double reach)
      : sums_(sums), points_(points), reach_(reach) {}

  double reach() const { return reach_; }

  LocalPlane plane() const { return plane_of(sums_.moments(points_), reach_); }
  simd::Moments of_layer(const simd::Layer& layer) const { return sums_.of_layer(points_, layer); }
  simd::HeightSums heights(const simd::Level& level) const { return sums_.heights(points_, level); }
  simd::Extents extents(const simd::Layer& layer, const simd::Fan& fan) const {
    return sums_.extents(points_, layer, fan);
  }

  /// The plane that is `height` below the position. Metres.
  simd::Level level(const glm::dvec3& normal, double height) const {
    return {glm::vec3(normal), static_cast<float>(-height / reach())};
  }

 private:
  const simd::LocalSums& sums_;
  const simd::BallPoints& points_;
  const double reach_;
};

/// Heights of two sheets above a position, along a normal. Metres.
struct Sheets {
  double lower = 0.0, upper = 0.0;
};

/// Estimated from the moments of the points' heights; empty if they look like one sheet.
std::optional<Sheets> two_sheets(const PointsNear& points, const LocalPlane& plane) {
  const simd::HeightSums sums = points.heights(points.level(plane.normal, plane.height));
  const double reach = points.reach();
  const double mean = sums.powers[0] / sums.weight;
  const double second = sums.powers[1] / sums.weight, third = sums.powers[2] / sums.weight,
               fourth = sums.powers[3] / sums.weight;
  const double square = mean * mean, variance = second - square;
  // Below this, heights are rounding.
  if (!(variance > 1e-10)) return std::nullopt;
  const double third_central = third - 3.0 * mean * second + 2.0 * mean * square;
  const double fourth_central = fourth - 4.0 * mean * third + 6.0 * square * second - 3.0 * square * square;
  const double skewness = third_central / (variance * std::sqrt(variance));
  const double kurtosis = fourth_central / (variance * variance);
  // 1 for two sharp values, 0.56 for an even spread, 0.33 for a bell curve. Candidates for two sheets are
  // examined closely.
  constexpr double k_two_values = 0.4;
  if (!(skewness * skewness + 1.0 > k_two_values * kurtosis)) return std::nullopt;
  const double middle = reach * mean - plane.height, half = 0.5 * reach * std::sqrt(variance);
  const double root = std::sqrt(skewness * skewness + 4.0);
  return Sheets{middle + half * (skewness - root), middle + half * (skewness + root)};
}

/// The plane of the sheet that the position is on, where there are two; otherwise `plane`.
LocalPlane choose_sheet(const PointsNear& points, const LocalPlane& plane) {
  const std::optional<Sheets> sheets = two_sheets(points, plane);
  if (!sheets) return plane;
  const double gap = sheets->upper - sheets->lower;
  const bool on_upper = std::fabs(sheets->upper) < std::fabs(sheets->lower);
  LocalPlane sheet = plane;
  sheet.height = -(on_upper ? sheets->upper : sheets->lower);
  const auto limit = static_cast<float>(0.5 * gap / points.reach());
  // The first plane leans towards both sheets, the second hardly.
  for (int pass = 0; pass < 2; ++pass) {
    sheet = plane_of(points.of_layer({points.level(sheet.normal, sheet.height), limit}), points.reach());
    if (sheet.trust < k_least_sheet_trust) return plane;
  }
  // Sheets of a plate are parallel to it.
  constexpr double k_apart = 8.0, k_parallel = 0.95;
  const bool is_parallel = std::fabs(glm::dot(sheet.normal, plane.normal)) > k_parallel;
  return is_parallel && gap > k_apart * sheet.thickness ? sheet : plane;
}

/// Heights above a sheet up to which a point is part of it.
double sheet_limit(double thickness, double length) {
  constexpr double k_thicknesses = 4.0, k_share = 1e-3;
  return k_thicknesses * thickness + k_share * length;
}

/// Whether a point is so far off the sheet of its neighbours that it is no part of it.
bool off_sheet(const LocalPlane& plane, double reach) {
  return std::fabs(plane.height) > sheet_limit(plane.thickness, reach);
}

/// The surface of a point off the sheet of its neighbours: that of the others, as on the ground at the foot
/// of a wall with many more points; or one of its own beside the sheet. None where it is far off with few
/// others, like a bird above a field: its distance to its neighbours would make a wide disc of it.
PointSurface surface_beside(const PointsNear& points, double spacing, const LocalPlane& sheet) {
  constexpr double k_far = 0.5;  // spacings
  const double reach = points.reach();
  // A third of what a sheet with this spacing has within reach; one that ends here has half.
  const double few = k_surface_neighbours / 3.0 * (reach / spacing) * (reach / spacing);
  const auto limit = static_cast<float>(sheet_limit(sheet.thickness, reach) / reach);
  const simd::Moments others =
      points.of_layer({points.level(sheet.normal, sheet.height), limit, simd::Layer::Side::beyond});
  const bool is_far = std::fabs(sheet.height) > k_far * spacing;
  if (is_far && others.count < few) return {};
  const LocalPlane plane = plane_of(others, reach);
  if (plane.trust >= k_least_surface_trust && !off_sheet(plane, reach))
    return {true, plane.normal, plane.height, plane.thickness};
  if (is_far) return {};
  return {true, sheet.normal, 0.0, sheet.thickness};
}

/// How far the sheet's points within k_reach spacings of a point reach in each direction, in spacings; 0 if
/// there are none.
simd::Extents sheet_extents(const PointsNear& points, const PointSurface& surface) {
  const double reach = points.reach();
  const auto limit = static_cast<float>(sheet_limit(surface.thickness, reach / k_reach) / reach);
  const PlaneAxes axes = axes_across(surface.normal);
  simd::Extents extents = points.extents({points.level(surface.normal, surface.height), limit},
                                         {glm::vec3(axes.first), glm::vec3(axes.second), float_directions(),
                                          static_cast<float>(k_half_width / k_reach)});
  for (float& extent : extents) extent *= static_cast<float>(k_reach);
  return extents;
}

/// The edge of a point's sheet as edge_of() unpacks it.
std::uint8_t fit_sheet_edge(const PointsNear& points, const PointSurface& surface) {
  const simd::Extents extents = sheet_extents(points, surface);
  int best = -1;
  for (int i = 0; i < k_edge_directions; ++i) {
    const bool has_support = extents[(i + k_edge_directions / 2) % k_edge_directions] >= k_least_support;
    if (has_support && (best < 0 || extents[i] < extents[best])) best = i;
  }
  if (best < 0) return 0;
  const int level = static_cast<int>(std::lround(extents[best] / packed_surface::k_edge_step)) + 1;
  return level > packed_surface::k_edge_levels ? 0
                                               : static_cast<std::uint8_t>(k_edge_directions * level + best);
}

/// Finds the points around positions that are close together: the nodes they are in are found once for many.
class Neighbourhood {
 public:
  explicit Neighbourhood(const Octree& octree)
      : tree_(octree.view()), sums_(simd::local_sums(octree.instruction_set())) {}

  /// The positions of the next points.
  void enter(const Bounds& box) { next_ = box; }

  /// Valid until the next call.
  PointsNear points(const glm::dvec3& position, double reach) {
    if (reach != gathered_reach_ || position != gathered_at_) {
      gathered_reach_ = 0.0;  // if it fails
      // Nodes of a much longer reach would take longer than the walk.
      constexpr double k_longest = 4.0;
      const bool found = box_.contains(position) && reach <= reach_ && reach_ <= k_longest * reach;
      if (!found) find(position, reach);
      sums_.gather(tree_, {position, reach, &nodes_}, points_);
      gathered_at_ = position;
      gathered_reach_ = reach;
    }
    return {sums_, points_, reach};
  }

 private:
  void find(const glm::dvec3& position, double reach) {
    // For the spacings of the next points, and for those of them that are near.
    constexpr double k_slack = 1.25, k_side = 2.0;
    reach_ = 0.0;  // if it fails
    box_.min = glm::max(next_.min, position - k_side * reach);
    box_.max = glm::min(next_.max, position + k_side * reach);
    sums_.find_nodes(tree_, box_, k_slack * reach, nodes_);
    reach_ = k_slack * reach;
  }

  const TreeView& tree_;
  const simd::LocalSums& sums_;
  Bounds next_, box_;
  double reach_ = 0.0;
  std::vector<Frame> nodes_;
  simd::BallPoints points_;
  glm::dvec3 gathered_at_{0.0};
  double gathered_reach_ = 0.0;
};

struct FittedSurface {
  PointSurface surface;
  bool may_end = true;  ///< whether an edge of the sheet may be near
};

/// usual: what spacings of the cloud are like, metres.
FittedSurface fit_surface(Neighbourhood& around, const glm::dvec3& position, double spacing, double usual) {
  constexpr double k_reaches[] = {k_reach, 1.5, 1.1, 5.0};
  // Near an edge the mean of a sheet's points lies farther inward, in reaches, than it does by chance.
  constexpr double k_centered = 0.1;
  // Around a lone point, such as a bird or a stray return, points lie much denser than it does itself, and on
  // more than one sheet; at the border of a dense part of a sheet only denser.
  constexpr double k_dense = 3.0, k_lone = 5.0, k_thick = 0.1;
  // Few of some points in the air, such as stray returns, lie near one plane by chance, and the disc would be
  // wide.
  constexpr double k_sparse = 4.0, k_thin = 0.07;
  if (!(spacing > 0.0 && std::isfinite(spacing))) return {};
  const bool is_sparse = spacing > k_sparse * usual;
  for (const double factor : std::span(k_reaches).first(is_sparse ? 1 : std::size(k_reaches))) {
    const double reach = factor * spacing;
    const PointsNear points = around.points(position, reach);
    const LocalPlane fitted = points.plane();
    // 1 where the sheet continues as it is within one spacing.
    const double density = fitted.count / (k_surface_neighbours * factor * factor);
    const bool is_thick = fitted.thickness > k_thick * spacing;
    if (factor == k_reach && density > k_lone && is_thick) return {};
    if (is_sparse && fitted.thickness > k_thin * spacing) return {};
    if ((density > k_dense && is_thick) || fitted.trust < k_least_surface_trust) continue;
    // Few points pass for two sheets by chance.
    const LocalPlane plane = factor < k_reach ? fitted : choose_sheet(points, fitted);
    if (off_sheet(plane, reach)) return {surface_beside(points, spacing, plane)};
    const bool may_end = factor != k_reach || plane.off_center > k_centered * reach;
    return {{true, plane.normal, plane.height, plane.thickness}, may_end};
  }
  return {};
}

/// FitLeaf.
class SurfaceFitter {
 public:
  SurfaceFitter(const Octree& octree, double unit)
      : tree_(octree.view()), layers_(octree.layers()), around_(octree), unit_(unit) {}

  const LeafSurfaces& operator()(const Leaf& leaf) {
    Bounds box;
    for (std::uint32_t i = 0; i < leaf.count; ++i)
      box.grow(to_world(tree_.lattice, position_of(tree_, leaf, i)));
    around_.enter(box);
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      const LatticePosition position = position_of(tree_, leaf, i);
      // Points of one position have one surface, and mostly come one after another.
      if (!known_ || position != last_) {
        known_ = false;  // if the fit fails
        fit(to_world(tree_.lattice, position), spacing_at(layers_, leaf.first + i));
      }
      known_ = true;
      last_ = position;
      fitted_.surfaces[i] = packed_;
      fitted_.edges[i] = edge_;
    }
    return fitted_;
  }

 private:
  void fit(const glm::dvec3& position, double spacing) {
    const FittedSurface fitted = fit_surface(around_, position, spacing, unit_);
    packed_ = pack(fitted.surface, unit_);
    const PointSurface surface = unpack_surface(packed_, unit_);
    edge_ = fitted.may_end && surface.exists
                ? fit_sheet_edge(around_.points(position, k_reach * spacing), surface)
                : std::uint8_t{0};
  }

  const TreeView& tree_;
  const PointLayers& layers_;
  Neighbourhood around_;
  const double unit_;  ///< automatic_radius()
  bool known_ = false;
  LatticePosition last_{};
  std::uint32_t packed_ = 0;
  std::uint8_t edge_ = 0;
  LeafSurfaces fitted_;
};

}  // namespace

FitLeaf surface_fitter(const Octree& octree, double unit) {
  return [fitter = std::make_shared<SurfaceFitter>(octree, unit)](const Leaf& leaf) -> const LeafSurfaces& {
    return (*fitter)(leaf);
  };
}

}  // namespace alidade
