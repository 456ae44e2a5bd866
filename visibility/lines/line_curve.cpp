// SPDX-License-Identifier: MIT
#include "visibility/lines/line_curve.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/exact_math.h"
#include "base/ray.h"
#include "octree/distance.h"
#include "octree/path_index.h"
#include "octree/query.h"

namespace alidade::visibility {
namespace {

constexpr int k_pieces = 24;

/// A straight part of a line.
struct Piece {
  SightLine line;
  double t_begin = 0.0, t_end = 0.0;
  double lead = 0.0;  ///< metres by which the sight line starts before the piece
};

/// Spheres that hold the start of a sight line do not block it. So that neither of two pieces misses those
/// around their joint, the second starts before it by the width of the widest.
Piece inner_piece(const LineCurve& curve, const TubePosition& tube, double t_begin, double t_end,
                  double widest_sphere) {
  const glm::dvec3 begin = curve.position(t_begin, tube), end = curve.position(t_end, tube);
  Piece piece{sight_line(chord_end(begin), chord_end(end)), t_begin, t_end};
  if (t_begin > curve.begin()) {
    piece.lead = std::min(widest_sphere, piece.line.length);
    piece.line.from.position = begin - piece.lead * piece.line.direction;
    piece.line.length += piece.lead;
  }
  // What the nearer end of the whole line lies on does not block. Nothing else depends on `to`.
  piece.line.to = t_begin + t_end < curve.length() ? curve.from() : curve.to();
  return piece;
}

void add_pieces(const CurveLine& line, double widest_sphere, std::vector<Piece>& pieces) {
  const LineCurve& curve = *line.curve;
  const std::vector<double> joints = curve.joints(line.tube);
  if (joints.size() == 2) {
    SightEnd from = curve.from(), to = curve.to();
    from.position = curve.position(joints[0]);
    to.position = curve.position(joints[1]);
    pieces.push_back({sight_line(from, to), joints[0], joints[1]});
    return;
  }
  for (std::size_t i = 0; i + 1 < joints.size(); ++i)
    pieces.push_back(inner_piece(curve, line.tube, joints[i], joints[i + 1], widest_sphere));
}

/// Where a piece is blocked, along the chord of the whole line.
double t_of(const Piece& piece, const Blocker& blocker) {
  const double share = (blocker.distance - piece.lead) / (piece.line.length - piece.lead);
  return std::clamp(piece.t_begin + share * (piece.t_end - piece.t_begin), piece.t_begin, piece.t_end);
}

/// The middle line as the path of queries.
struct Middle {
  const LineCurve& curve;
  std::vector<double> joints;
  Path path;

  explicit Middle(const LineCurve& line) : curve(line), joints(line.joints()) {
    std::vector<glm::dvec3> vertices;
    for (const double t : joints) vertices.push_back(curve.position(t));
    path = make_path(vertices);
  }

  /// t along the chord from t along the path.
  double chord_t(std::size_t segment, double path_t) const {
    const double begin = path.vertex_t[segment], length = path.vertex_t[segment + 1] - begin;
    return joints[segment] + (path_t - begin) / length * (joints[segment + 1] - joints[segment]);
  }
};

bool may_block(const Occluders& occluders, std::uint64_t point_id) {
  const OccluderOptions& options = occluders.options();
  if (options.counts && !options.counts(point_id)) return false;
  return options.shape != OccluderShape::disc || occluders.surface(point_id).exists;
}

/// Leaves out points whose nearest point of the path is one of its ends: they are not beside it.
CandidateFilter beside(const Occluders& occluders, const Middle& middle) {
  return [&occluders, &middle](const Candidate& point) {
    if (!(point.t > 0.0 && point.t < middle.path.vertex_t.back())) return false;
    for (const SightEnd* const end : {&middle.curve.from(), &middle.curve.to()}) {
      if (distance(end->position, point.position) <= end->own_reach) return false;
    }
    return may_block(occluders, point.point_id);
  };
}

/// The ray of a straight line: queries with rays are ten times as fast as those with paths.
std::optional<Ray> ray_of(const Middle& middle) {
  return middle.joints.size() == 2 ? std::optional(segment_of(middle.path, 0).line) : std::nullopt;
}

LinePoint line_point(const Middle& middle, const Hit& hit) {
  return {hit.point_id, hit.position, middle.chord_t(0, hit.t), hit.distance};
}

LinePoint line_point(const Middle& middle, const PathHit& hit) {
  return {hit.point_id, hit.position, middle.chord_t(hit.segment, hit.t), hit.distance};
}

/// Those of the hits that lie in the zone.
template <class Hits>
std::vector<LinePoint> within_zone(const Middle& middle, const Hits& hits) {
  std::vector<LinePoint> points;
  for (const auto& hit : hits) {
    const LinePoint point = line_point(middle, hit);
    if (point.distance <= middle.curve.zone_radius(point.t)) points.push_back(point);
  }
  return points;
}

}  // namespace

LineCurve::LineCurve(const SightEnd& from, const SightEnd& to, const LineOptions& options,
                     double middle_radius)
    : from_(from), to_(to), earth_radius_(options.earth_radius), middle_radius_(middle_radius) {
  const SightLine line = sight_line(from, to);
  length_ = line.length;
  along_ = line.direction;
  begin_ = std::min(options.end_margin, length_);
  end_ = length_ - begin_;
  if (begin_ > 0.0) {
    from_ = {from_.position};
    to_ = {to_.position};
  }
  const glm::dvec3 level = glm::cross(along_, glm::dvec3(0.0, 0.0, 1.0));
  across_ = level == glm::dvec3(0.0) ? glm::dvec3(1.0, 0.0, 0.0) : unit_direction(level);
  up_ = glm::cross(across_, along_);
}

double LineCurve::zone_radius(double t) const {
  return length_ > 0.0 ? 2.0 * middle_radius_ * std::sqrt(std::max(t * (length_ - t), 0.0)) / length_ : 0.0;
}

glm::dvec3 LineCurve::position(double t, const TubePosition& tube) const {
  glm::dvec3 position = t == length_ ? to_.position : from_.position + t * along_;
  if (std::isfinite(earth_radius_)) position.z -= t * (length_ - t) / (2.0 * earth_radius_);
  if (tube.share == 0.0) return position;
  const SineCosine around = sine_cosine_of_turns(tube.turns);
  return position + tube.share * zone_radius(t) * (around.cosine * across_ + around.sine * up_);
}

std::vector<double> LineCurve::joints(const TubePosition& tube) const {
  if (!(begin_ < end_)) return {};
  std::vector<double> joints{begin_};
  if (std::isfinite(earth_radius_) || tube.share > 0.0) {
    // Equal steps of the angle that an ellipse is drawn by: dense where it bends.
    for (int i = 1; i < k_pieces; ++i) {
      const double t = 0.5 * length_ * (1.0 - sine_cosine_of_turns(0.5 * i / k_pieces).cosine);
      if (t > begin_ && t < end_) joints.push_back(t);
    }
  }
  joints.push_back(end_);
  return joints;
}

std::vector<std::optional<CurveCrossings>> crossings(const Occluders& occluders,
                                                     std::span<const CurveLine> lines) {
  std::vector<Piece> pieces;
  std::vector<std::size_t> ends;
  for (const CurveLine& line : lines) {
    add_pieces(line, occluders.typical_radius(), pieces);
    ends.push_back(pieces.size());
  }
  std::vector<SightLine> sight_lines(pieces.size());
  std::ranges::transform(pieces, sight_lines.begin(), &Piece::line);
  std::vector<std::optional<Blocker>> blockers(pieces.size());
  first_blockers(occluders, sight_lines, blockers);
  std::vector<std::optional<CurveCrossings>> answers(lines.size());
  for (std::size_t line = 0, i = 0; line < lines.size(); ++line) {
    for (; i < ends[line]; ++i) {
      if (!blockers[i]) continue;
      const double t = t_of(pieces[i], *blockers[i]);
      if (!answers[line]) answers[line] = CurveCrossings{{blockers[i]->point_id, blockers[i]->position, t}};
      answers[line]->last_t = t;
    }
  }
  return answers;
}

std::optional<LinePoint> nearest_point(const Occluders& occluders, const LineCurve& curve) {
  if (!(curve.begin() < curve.end())) return std::nullopt;
  const Middle middle(curve);
  const CandidateFilter filter = beside(occluders, middle);
  if (const std::optional<Ray> ray = ray_of(middle)) {
    const std::optional<Hit> hit =
        closest(occluders.octree(), *ray, {.measure = Measure::distance, .filter = filter});
    return hit ? std::optional(line_point(middle, *hit)) : std::nullopt;
  }
  const std::vector<PathHit> hits =
      find(occluders.octree(), middle.path, {.measure = Measure::distance, .k = 1, .filter = filter});
  return hits.empty() ? std::nullopt : std::optional(line_point(middle, hits.front()));
}

std::vector<LinePoint> points_in_zone(const Occluders& occluders, const LineCurve& curve) {
  if (!(curve.begin() < curve.end())) return {};
  const Middle middle(curve);
  const CandidateFilter filter = beside(occluders, middle);
  // Wide enough for the whole zone; within_zone() then tests each point.
  const double radius = curve.zone_radius(0.5 * curve.length());
  if (const std::optional<Ray> ray = ray_of(middle)) {
    return within_zone(
        middle, find(occluders.octree(), *ray, {.radius = radius, .measure = Measure::t, .filter = filter}));
  }
  return within_zone(middle, find(occluders.octree(), middle.path, {.radius = radius, .filter = filter}));
}

}  // namespace alidade::visibility
