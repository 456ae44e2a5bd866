// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "base/bounds.h"
#include "base/instruction_set.h"
#include "octree/octree.h"
#include "octree/tree_walk.h"
#include "surface/packed_surface.h"

namespace alidade::simd {

/// The points within reach of a position, those at the reach itself left out.
struct Ball {
  glm::dvec3 position;
  double reach;  ///< metres, > 0
  /// Found for a box and a reach that contain this ball (LocalSums::find_nodes); null: the walk begins at the
  /// root. Does not change an answer.
  const std::vector<Frame>* nodes = nullptr;
};

/// The points of a ball, a column each: offsets p from its position in units of the reach, and 1 - |p|^2.
/// Followed by zeros up to a whole number of vectors. The ball of a stray may hold the whole cloud: of more
/// than k_most_in_block points the sums gather one block after another.
struct BallPoints {
  static constexpr std::size_t k_most_in_block = std::size_t{1} << 14;

  std::vector<float> x, y, z, closeness;
  std::size_t count = 0;
  /// Null: all points of the ball are here. Otherwise tree and ball that they are gathered from again.
  const TreeView* tree = nullptr;
  Ball ball{};
};

/// Sums over the points of a ball; the weight of a point is (1 - |p|^2)^2.
struct Moments {
  float weight = 0.0f;
  float count = 0.0f;  ///< of points
  std::array<float, 3> first{};
  std::array<float, 6> second{};  ///< xx xy xz yy yz zz
};

/// What heights are measured from. The height of a point is p along the direction, less the level.
struct Level {
  glm::vec3 direction;  ///< of length 1
  float level;
};

/// Some of a ball's points: those whose heights are within a limit, which is inclusive, or those beyond it.
struct Layer {
  enum class Side { within, beyond };

  Level level;
  float limit;
  Side side = Side::within;
};

/// Sums of powers of heights over the same points with the same weights.
struct HeightSums {
  float weight = 0.0f;
  std::array<float, 4> powers{};  ///< of h, h^2, h^3, h^4
};

/// How far points reach in each of these directions; 0 if there are none.
using Extents = std::array<float, packed_surface::k_edge_directions>;

/// Directions in a plane, and the points that count in each: those within a distance of a line along it.
struct Fan {
  glm::vec3 first_axis, second_axis;  ///< of the plane: of length 1, at right angles
  const std::array<glm::vec2, packed_surface::k_edge_directions>& directions;
  float half_width;
};

/// What points around a position add up to, compiled for one instruction set. Unlike in queries, floats are
/// the answer; so all sets add the same numbers in the same order, in sixteen columns however many lanes
/// there are, and no product is fused with a sum.
struct LocalSums {
  /// Replaces `nodes` by those with leaves within reach of a box, in the order of a walk. They serve all
  /// balls that have their position in the box and at most this reach.
  void (*find_nodes)(const TreeView& tree, const Bounds& box, double reach, std::vector<Frame>& nodes);
  /// Replaces `points`, in the order of a walk. Tree and Ball::nodes must outlive their sums.
  void (*gather)(const TreeView& tree, const Ball& ball, BallPoints& points);
  Moments (*moments)(const BallPoints& points);
  Moments (*of_layer)(const BallPoints& points, const Layer& layer);
  HeightSums (*heights)(const BallPoints& points, const Level& level);
  Extents (*extents)(const BallPoints& points, const Layer& layer, const Fan& fan);
};

/// For an available instruction set (not `best`).
const LocalSums& local_sums(InstructionSet instruction_set);

}  // namespace alidade::simd
