// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "octree/query.h"
#include "renderer/load_cloud.h"
#include "renderer/scene.h"
#include "surface/surface_cloud.h"

// What rays meet where points are discs of their sheets: DiscQuery (surface/surface_cloud.h) defines where.
//
// Blended: the discs that count beside the first one are those of points within whose radius the first
// crossing lies, if they belong to its sheet: their normal deviates by at most 32 degrees, and their plane
// passes within a quarter of the radius plus 4 mm of the crossing. Of them t (where the ray crosses their
// plane), normal and colour are averaged, weighted by
//
//   exp(-8 d^2 / r^2)
//
// with the distance d of the point from the first crossing and its radius r. Colours of categories, such as
// classes, are not: between ground and building lies no third class. The hit has that of the disc with the
// greatest weight. Planes that the ray crosses more than r from the first crossing do not count, nor does a
// mean t outside the limits or a normal that faces away. Rays that leave a sheet meet discs that are not
// blended: what they find is spread over many of them.

namespace alidade::renderer {

/// The colour of a point, or black if the cloud has no colours.
inline Color16 color_of(const ColorColumn& colors, std::uint64_t point_id) {
  return colors.empty() ? Color16(0) : colors[point_id];
}

/// The colours of hits, read one after another: those of points that rays meet are far apart in memory.
template <class Hits>
class ColorsAhead {
 public:
  ColorsAhead(const ColorColumn& colors, const Hits& hits) : colors_(colors), hits_(hits) {
    for (std::size_t i = 0; i < k_ahead; ++i) fetch_one(i);
  }
  /// To be called before hit i is read.
  void fetch(std::size_t i) const { fetch_one(i + k_ahead); }
  Color16 of(std::uint64_t point_id) const { return color_of(colors_, point_id); }

 private:
  static constexpr std::size_t k_ahead = 16;

  void fetch_one(std::size_t i) const {
    if (i >= hits_.size() || !hits_[i]) return;
    if (!colors_.deep().empty()) __builtin_prefetch(colors_.deep().data() + hits_[i]->point_id);
    if (!colors_.shallow().empty()) __builtin_prefetch(colors_.shallow().data() + hits_[i]->point_id);
  }

  const ColorColumn& colors_;
  const Hits& hits_;
};

/// Where a ray meets the cloud. Small, since there are thousands at a time.
struct DiscHit {
  double t = 0.0;              ///< metres
  std::uint64_t point_id = 0;  ///< of the first crossing
  SheetOrigin sheet{};  ///< for rays that leave from there; its normal shows to the side the ray came from
  Color16 color{0};     ///< display value
};

/// How far a hit is to be trusted.
struct HitTrust {
  /// Standard deviation of t from that of the surface that was scanned, metres. It follows from how the
  /// planes of the sheet differ and how thick it is; from what the ray would meet before if discs and spheres
  /// were wider; and, unless points of the sheet surround the hit, from what lies behind. Infinite where that
  /// is nothing.
  double sigma = 0.0;
  std::uint32_t support = 0;  ///< points that the surface there is made of
};

/// The cloud of a scene as discs. Keeps references to the cloud, which must outlive it and have discs.
/// Safe to use from many threads.
class DiscCloud {
 public:
  DiscCloud(const LoadedCloud& cloud, bool blends);

  /// The first hit of each ray in its interval. All of one length.
  void closest(std::span<const Ray> rays, std::span<const SheetOrigin> origins,
               std::span<std::optional<DiscHit>> hits) const;
  /// Whether there is one.
  void blocked(std::span<const Ray> rays, std::span<const SheetOrigin> origins,
               std::span<std::uint8_t> answers) const;

  /// Of what rays from the air hit first; support 0 of those that hit nothing.
  void trust(std::span<const Ray> rays, std::span<HitTrust> answers) const;

 private:
  struct Rim;
  struct Neighbour;
  struct Neighbours;
  struct Blended;
  struct SheetSums;

  /// For rays that begin there.
  SurfaceQuery query_of(std::span<const SheetOrigin> origins) const;
  DiscHit disc_hit(const Ray& ray, const SurfaceHit& first) const;
  /// The discs that may share in hits within `reach` metres of a position.
  void find_neighbours(const glm::dvec3& position, double reach, Neighbours& around) const;
  /// Over the discs of the sheet around a hit on one of them.
  SheetSums sums(const Ray& ray, const DiscHit& hit, std::span<const Neighbour> around) const;
  /// Blends hits on one disc.
  void blend(std::span<const Ray> rays, std::span<const Blended> blended,
             std::span<std::optional<DiscHit>> hits, Neighbours& room) const;
  /// How far a hit is to be trusted that is not at a rim.
  HitTrust trust_amid(const Ray& ray, const SurfaceHit& first, Neighbours& room) const;
  /// The hit as that of a rim, unless points of its sheet surround it. before: t where the ray begins.
  std::optional<Rim> rim(const Ray& ray, std::size_t number, const SurfaceHit& first, double before) const;

  const SurfaceCloud surfaces_;
  const SurfaceQuery query_;
  const ColorColumn colors_;
  const bool blends_, are_categories_;  ///< the colours
};

}  // namespace alidade::renderer
