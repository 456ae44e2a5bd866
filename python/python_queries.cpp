// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>
#include <cmath>
#include <limits>
#include <numbers>

#include "octree/query.h"
#include "python/docstrings.h"
#include "python/python_cloud.h"

namespace alidade::python {
namespace {

/// Rays as arrays: (..., 6), or origins and directions (..., 3). One of these may have shape (3,) and then
/// applies to all rays.
class RayArrays {
 public:
  RayArrays(const py::object& rays, const py::object& origins, const py::object& directions,
            const py::object& t_min, const py::object& t_max) {
    if (rays.is_none() == (origins.is_none() || directions.is_none()))
      throw input_error("rays are missing, or given twice", "either rays, or origins and directions");
    if (!rays.is_none()) {
      first_ = numbers_of(rays, "rays", {6});
      shape_ = leading_shape(first_);
      columns_.count = static_cast<std::size_t>(first_.size() / 6);
      columns_.origins = {first_.data(), 6};
      columns_.directions = {first_.data() + 3, 6};
    } else {
      first_ = numbers_of(origins, "origins", {3});
      second_ = numbers_of(directions, "directions", {3});
      const bool is_one_origin = first_.ndim() == 1, is_one_direction = second_.ndim() == 1;
      shape_ = leading_shape(is_one_origin ? second_ : first_);
      if (!is_one_origin && !is_one_direction && leading_shape(second_) != shape_)
        throw input_error("origins and directions have different shapes", "equal shapes, or one of them (3,)",
                          shape_text(first_) + " and " + shape_text(second_));
      columns_.count = static_cast<std::size_t>((is_one_origin ? second_ : first_).size() / 3);
      columns_.origins = {first_.data(), is_one_origin ? 0u : 3u};
      columns_.directions = {second_.data(), is_one_direction ? 0u : 3u};
    }
    t_min_ = real_numbers(t_min, "t_min");
    t_max_ = real_numbers(
        t_max.is_none() ? py::object(py::float_(std::numeric_limits<double>::infinity())) : t_max, "t_max");
    columns_.t_min = column_of(t_min_, "t_min");
    columns_.t_max = column_of(t_max_, "t_max");
  }

  std::size_t size() const { return columns_.count; }
  const Shape& shape() const { return shape_; }

  const RayColumns& columns() const { return columns_; }
  Ray operator[](std::size_t i) const { return columns_.ray(i); }

  /// Copies the rays begin to end - 1 to `rays`, in parallel.
  void copy(std::size_t begin, std::size_t end, std::vector<Ray>& rays) const {
    rays.resize(end - begin);
    in_parallel(end - begin, k_array_grain, [&](std::size_t i) { rays[i] = (*this)[begin + i]; });
  }

 private:
  /// Errors: neither one number nor one for each ray, in their shape.
  RayColumns::Column column_of(const Doubles& limits, const char* name) const {
    if (limits.size() == 1 && limits.ndim() <= 1) return {limits.data(), 0};
    if (Shape(limits.shape(), limits.shape() + limits.ndim()) != shape_)
      throw input_error(fmt::format("{} has the wrong shape", name),
                        fmt::format("one number, or shape ({})", fmt::join(shape_, ", ")),
                        "shape " + shape_text(limits));
    return {limits.data(), 1};
  }

  Doubles first_, second_, t_min_, t_max_;  ///< what the columns refer to
  Shape shape_;
  RayColumns columns_;
};

/// Conditions that all queries of this module accept.
struct Conditions {
  py::object where = py::none();
  std::optional<std::vector<int>> classes;
  std::optional<int> max_level;
  int workers = -1;
};

/// A filter by a mask and by classes; empty: all points. `kept` keeps alive what it reads.
CandidateFilter filter_of(const Index& index, const Conditions& conditions, py::object& kept) {
  const std::size_t count = index.data()->size();
  const std::uint8_t* mask = nullptr;
  if (!conditions.where.is_none()) {
    const py::array array = py::array::ensure(conditions.where);
    if (!array || array.ndim() != 1 || static_cast<std::size_t>(array.shape(0)) != count ||
        array.dtype().kind() != 'b') {
      PyErr_Clear();
      throw input_error(
          "where is not a mask of the points", fmt::format("bool of shape ({},)", count),
          array ? fmt::format("{} of shape {}", py::str(array.dtype()).cast<std::string>(), shape_text(array))
                : "no array");
    }
    auto packed = py::array_t<bool, py::array::c_style | py::array::forcecast>(array);
    mask = reinterpret_cast<const std::uint8_t*>(packed.data());
    kept = std::move(packed);
  }
  std::array<bool, 256> wanted{};
  if (conditions.classes) {
    for (const int number : *conditions.classes) {
      if (number < 0 || number > 255)
        throw input_error("class out of range", "0 to 255", std::to_string(number));
      wanted[static_cast<std::size_t>(number)] = true;
    }
  }
  const std::span<const std::uint8_t> classes = index.data()->points.columns().classifications;
  if (conditions.classes && classes.empty() && count > 0)
    throw input_error("classes were given, but the cloud has none",
                      "a cloud with the attribute classification");
  if (mask == nullptr && !conditions.classes) return {};
  return [=, has_classes = conditions.classes.has_value()](const Candidate& point) {
    return (mask == nullptr || mask[point.point_id] != 0) &&
           (!has_classes || wanted[classes[point.point_id]]);
  };
}

template <class Query>
void apply(const Index& index, const Conditions& conditions, Query& query, py::object& kept) {
  query.filter = filter_of(index, conditions, kept);
  if (conditions.max_level) query.max_level = *conditions.max_level;
}

/// The named measure; the default is that of 'alidade query'.
Measure measure_of(const std::optional<std::string>& given, double radius) {
  if (!given) return std::isfinite(radius) ? Measure::entry : Measure::distance;
  const std::string& word = *given;
  if (word == "entry") return Measure::entry;
  if (word == "distance") return Measure::distance;
  if (word == "t") return Measure::t;
  throw input_error("unknown measure", "entry, distance or t", word);
}

/// Columns of answers of one shape, with values for targets without answer.
struct HitArrays {
  explicit HitArrays(const Shape& shape) : index(shape), t(shape), distance(shape), entry(shape) {
    columns = {index.mutable_data(), t.mutable_data(), distance.mutable_data(), entry.mutable_data()};
  }

  void set(std::size_t i, const Hit& hit) { columns.set(i, hit); }
  py::object tuple() const { return answer_type("Hits")(index, t, distance, entry); }
  py::object tuple(const py::array& offsets) const {
    return answer_type("HitLists")(index, offsets, t, distance, entry);
  }

  py::array_t<std::int64_t> index;
  py::array_t<double> t, distance, entry;
  HitColumns columns;
};

struct NeighbourArrays {
  explicit NeighbourArrays(const Shape& shape) : index(shape), distance(shape) {
    columns = {index.mutable_data(), distance.mutable_data()};
  }
  void set(std::size_t i, const PointHit& hit) { columns.set(1, i, {&hit, 1}); }
  py::object tuple() const { return answer_type("Neighbours")(index, distance); }
  py::object tuple(const py::array& offsets) const {
    return answer_type("NeighbourLists")(index, offsets, distance);
  }

  py::array_t<std::int64_t> index;
  py::array_t<double> distance;
  PointHitColumns columns;
};

/// All answers, one target after the other: those of target i are offsets[i] to offsets[i + 1] - 1.
template <class Arrays, class Query, class Targets>
py::object all_answers(const Index& index, const Query& query, int workers, std::size_t count,
                       const Targets& targets) {
  using Answer = std::remove_cvref_t<decltype(find(index.octree(), targets(0, 0), query).all[0])>;
  std::vector<Answer> all;
  py::array_t<std::int64_t> offsets(static_cast<py::ssize_t>(count) + 1);
  std::int64_t* const begins = offsets.mutable_data();
  begins[0] = 0;
  in_pieces(workers, count, [&](std::size_t begin, std::size_t end) {
    auto answers = find(index.octree(), targets(begin, end), query);
    for (std::size_t i = begin; i < end; ++i)
      begins[i + 1] = static_cast<std::int64_t>(all.size() + answers.begin[i - begin + 1]);
    if (all.empty()) {
      all = std::move(answers.all);
    } else {
      all.insert(all.end(), answers.all.begin(), answers.all.end());
    }
  });
  Arrays arrays({static_cast<py::ssize_t>(all.size())});
  run_free(workers,
           [&] { in_parallel(all.size(), k_array_grain, [&](std::size_t i) { arrays.set(i, all[i]); }); });
  return arrays.tuple(offsets);
}

/// Of answers with k rows for each target.
Shape with_rows(Shape shape, std::size_t k) {
  shape.push_back(static_cast<py::ssize_t>(k));
  return shape;
}

std::size_t require_k(std::int64_t k) {
  if (k < 1) throw input_error("k is out of range", "1 or more", std::to_string(k));
  return static_cast<std::size_t>(k);
}

struct RayCall {
  const Index& index;
  RayArrays rays;
  RayQuery query;
  py::object kept;
  int workers;

  /// For find(): a range of rays.
  auto targets() const {
    return [this](std::size_t begin, std::size_t end) {
      std::vector<Ray> some;
      rays.copy(begin, end, some);
      return some;
    };
  }
};

/// Declares a query of rays: run(RayCall).
template <class Run>
auto ray_query(const Run& run) {
  return [run](const Index& index, const py::object& rays, const py::object& origins,
               const py::object& directions, std::optional<double> radius,
               const std::optional<std::string>& measure, const py::object& t_min, const py::object& t_max,
               const py::object& where, const std::optional<std::vector<int>>& classes,
               std::optional<int> max_level, int workers, std::int64_t k) {
    RayCall call{index, RayArrays(rays, origins, directions, t_min, t_max), {}, py::none(), workers};
    call.query.radius = radius.value_or(k_unlimited_radius);
    call.query.measure = measure_of(measure, call.query.radius);
    call.query.k = k == 0 ? k_all : require_k(k);
    apply(index, {where, classes, max_level, workers}, call.query, call.kept);
    return run(call);
  };
}

/// Declares a query of rays without k: run(RayCall).
template <class Run>
auto plain_ray_query(const Run& run) {
  return [query = ray_query(run)](const Index& index, const py::object& rays, const py::object& origins,
                                  const py::object& directions, std::optional<double> radius,
                                  const std::optional<std::string>& measure, const py::object& t_min,
                                  const py::object& t_max, const py::object& where,
                                  const std::optional<std::vector<int>>& classes,
                                  std::optional<int> max_level, int workers) {
    return query(index, rays, origins, directions, radius, measure, t_min, t_max, where, classes, max_level,
                 workers, 0);
  };
}

py::object closest_hits(RayCall& call) {
  const HitArrays hits(call.rays.shape());
  run_interruptible(call.workers, [&](const Progress& progress) {
    closest(call.index.octree(), call.rays.columns(), call.query, hits.columns, progress);
  });
  return hits.tuple();
}

py::object occlusions(RayCall& call) {
  py::array_t<bool> answers(call.rays.shape());
  auto* const bytes = reinterpret_cast<std::uint8_t*>(answers.mutable_data());
  run_interruptible(call.workers, [&](const Progress& progress) {
    occluded(call.index.octree(), call.rays.columns(), call.query, {bytes, call.rays.size()}, progress);
  });
  return answers;
}

py::object counts(RayCall& call) {
  py::array_t<std::int64_t> answers(call.rays.shape());
  std::vector<Ray> rays;
  std::vector<std::size_t> some;
  in_pieces(call.workers, call.rays.size(), [&](std::size_t begin, std::size_t end) {
    call.rays.copy(begin, end, rays);
    some.resize(rays.size());
    count(call.index.octree(), rays, call.query, some);
    std::ranges::copy(some, answers.mutable_data() + begin);
  });
  return answers;
}

py::object first_hits(RayCall& call) {
  const std::size_t k = call.query.k;
  if (k == k_all) require_k(0);
  const HitArrays hits(with_rows(call.rays.shape(), k));
  in_pieces(call.workers, call.rays.size(), [&](std::size_t begin, std::size_t end) {
    const auto answers = find(call.index.octree(), call.targets()(begin, end), call.query);
    in_parallel(end - begin, k_array_grain, [&](std::size_t i) {
      const std::span<const Hit> of_ray = answers[i];
      const std::size_t first = k * (begin + i);
      for (std::size_t j = 0; j < k; ++j)
        j < of_ray.size() ? hits.columns.set(first + j, of_ray[j]) : hits.columns.set_none(first + j);
    });
  });
  return hits.tuple();
}

py::object all_hits(RayCall& call) {
  return all_answers<HitArrays>(call.index, call.query, call.workers, call.rays.size(), call.targets());
}

py::object nearest_points(const Index& index, const py::handle& xyz, std::int64_t k,
                          std::optional<double> radius, const py::object& where,
                          const std::optional<std::vector<int>>& classes, std::optional<int> max_level,
                          int workers) {
  const Doubles array = numbers_of(xyz, "xyz", {3});
  const std::span<const glm::dvec3> positions = as_positions(array);
  PointQuery query{.radius = radius.value_or(k_unlimited_radius), .k = require_k(k)};
  py::object kept;
  apply(index, {where, classes, max_level, workers}, query, kept);
  const NeighbourArrays neighbours(with_rows(leading_shape(array), query.k));
  run_interruptible(workers, [&](const Progress& progress) {
    find(index.octree(), positions, query, neighbours.columns, progress);
  });
  return neighbours.tuple();
}

py::object points_within(const Index& index, const py::handle& xyz, double radius, const py::object& where,
                         const std::optional<std::vector<int>>& classes, std::optional<int> max_level,
                         int workers) {
  const Doubles array = numbers_of(xyz, "xyz", {3});
  const std::span<const glm::dvec3> positions = as_positions(array);
  PointQuery query{.radius = radius};
  py::object kept;
  apply(index, {where, classes, max_level, workers}, query, kept);
  return all_answers<NeighbourArrays>(
      index, query, workers, positions.size(),
      [&](std::size_t begin, std::size_t end) { return positions.subspan(begin, end - begin); });
}

py::object in_box(const Index& index, const py::handle& boxes, const py::object& where,
                  const std::optional<std::vector<int>>& classes, std::optional<int> max_level, int workers) {
  static_assert(sizeof(Bounds) == 6 * sizeof(double));
  const Doubles array = numbers_of(boxes, "boxes", {6});
  const std::span<const Bounds> bounds(reinterpret_cast<const Bounds*>(array.data()),
                                       static_cast<std::size_t>(array.size() / 6));
  PointQuery query;
  py::object kept;
  apply(index, {where, classes, max_level, workers}, query, kept);
  const py::object lists = all_answers<NeighbourArrays>(
      index, query, workers, bounds.size(),
      [&](std::size_t begin, std::size_t end) { return bounds.subspan(begin, end - begin); });
  return answer_type("PointLists")(lists.attr("index"), lists.attr("offsets"));
}

py::object in_cone(const Index& index, const py::handle& rays, double angle, double radius,
                   const py::object& t_max, const py::object& where,
                   const std::optional<std::vector<int>>& classes, std::optional<int> max_level,
                   int workers) {
  const RayArrays axes(rays.cast<py::object>(), py::none(), py::none(), py::float_(0.0), t_max);
  ConeQuery query{.measure = Measure::t};
  py::object kept;
  apply(index, {where, classes, max_level, workers}, query, kept);
  return all_answers<HitArrays>(index, query, workers, axes.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<Cone> cones;
    for (std::size_t i = begin; i < end; ++i) {
      const Ray axis = axes[i];
      cones.push_back(
          make_cone(axis.origin, axis.direction, angle * std::numbers::pi / 180.0, radius, 0.0, axis.t_max));
    }
    return cones;
  });
}

py::object along(const Index& index, const py::handle& path, double radius, const py::object& where,
                 const std::optional<std::vector<int>>& classes, std::optional<int> max_level, int workers) {
  const Doubles array = numbers_of(path, "path", {3});
  if (array.ndim() != 2)
    throw input_error("path has the wrong shape", "(m, 3)", "shape " + shape_text(array));
  const std::span<const glm::dvec3> vertices = as_positions(array);
  PathQuery query{.radius = radius};
  py::object kept;
  apply(index, {where, classes, max_level, workers}, query, kept);
  std::vector<PathHit> hits;
  run_free(workers, [&] {
    hits = find(index.octree(), make_path({vertices.begin(), vertices.end()}), query);
  });
  const Shape shape{static_cast<py::ssize_t>(hits.size())};
  py::array_t<std::int64_t> indices(shape), segments(shape);
  py::array_t<double> t(shape), distances(shape);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    indices.mutable_data()[i] = static_cast<std::int64_t>(hits[i].point_id);
    segments.mutable_data()[i] = static_cast<std::int64_t>(hits[i].segment);
    t.mutable_data()[i] = hits[i].t;
    distances.mutable_data()[i] = hits[i].distance;
  }
  return answer_type("PathHits")(indices, segments, t, distances);
}

}  // namespace

void add_queries(py::class_<Index, Cloud>& index) {
  const auto add_ray_query = [&](const char* name, const char* manual, const auto& query,
                                 const py::object& measure, const auto&... more) {
    index.def(name, query, manual, py::arg("rays") = py::none(), py::kw_only(),
              py::arg("origins") = py::none(), py::arg("directions") = py::none(),
              py::arg("radius") = py::none(), py::arg("measure") = measure, py::arg("t_min") = 0.0,
              py::arg("t_max") = py::none(), py::arg("where") = py::none(), py::arg("classes") = py::none(),
              py::arg("max_level") = py::none(), py::arg("workers") = -1, more...);
  };
  const py::str distance = "distance";
  add_ray_query("closest", k_closest_doc, plain_ray_query(closest_hits), py::none());
  add_ray_query("occluded", k_occluded_doc, plain_ray_query(occlusions), distance);
  add_ray_query("count", k_count_doc, ray_query(counts), distance, py::arg("k") = 0);
  add_ray_query("nearest", k_nearest_doc, ray_query(first_hits), distance, py::arg("k") = 1);
  add_ray_query("within", k_within_doc, ray_query(all_hits), py::none(), py::arg("k") = 0);
  const py::arg_v where = py::arg("where") = py::none(), classes = py::arg("classes") = py::none(),
                  max_level = py::arg("max_level") = py::none(), workers = py::arg("workers") = -1;
  index
      .def("nearest_points", &nearest_points, k_nearest_points_doc, py::arg("xyz"), py::arg("k") = 1,
           py::kw_only(), py::arg("radius") = py::none(), where, classes, max_level, workers)
      .def("points_within", &points_within, k_points_within_doc, py::arg("xyz"), py::arg("radius"),
           py::kw_only(), where, classes, max_level, workers)
      .def("in_box", &in_box, k_in_box_doc, py::arg("boxes"), py::kw_only(), where, classes, max_level,
           workers)
      .def("in_cone", &in_cone, k_in_cone_doc, py::arg("rays"), py::arg("angle"), py::kw_only(),
           py::arg("radius") = 0.0, py::arg("t_max") = py::none(), where, classes, max_level, workers)
      .def("along", &along, k_along_doc, py::arg("path"), py::arg("radius"), py::kw_only(), where, classes,
           max_level, workers);
}

}  // namespace alidade::python
