// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <optional>

#include "base/ray.h"
#include "python/python_arrays.h"

namespace alidade::python {

/// A number for each target, or the same for all.
class PerTarget {
 public:
  /// Errors: neither one number nor one for each target, in their shape.
  PerTarget(const py::handle& given, const char* name, const Shape& shape)
      : array_(real_numbers(given, name)) {
    const bool is_one = array_.size() == 1 && array_.ndim() <= 1;
    if (!is_one && Shape(array_.shape(), array_.shape() + array_.ndim()) != shape)
      throw input_error(fmt::format("{} has the wrong shape", name),
                        fmt::format("one number, or shape ({})", fmt::join(shape, ", ")),
                        "shape " + shape_text(array_));
    values_ = array_.data();
    stride_ = is_one ? 0 : 1;
  }

  double operator[](std::size_t i) const { return values_[stride_ * i]; }

 private:
  Doubles array_;
  const double* values_;
  std::size_t stride_;
};

/// Rays as arrays: (..., 6), or origins and directions (..., 3), one of which may have shape (3,) and then applies to all rays.
class RayArrays {
 public:
  RayArrays(const py::object& rays, const py::object& origins, const py::object& directions,
            const py::object& t_min, const py::object& t_max) {
    if (rays.is_none() == (origins.is_none() || directions.is_none()))
      throw input_error("rays are missing, or given twice", "either rays, or origins and directions");
    if (!rays.is_none()) {
      first_ = numbers_of(rays, "rays", {6});
      shape_ = leading_shape(first_);
      count_ = static_cast<std::size_t>(first_.size() / 6);
      origin_ = first_.data();
      direction_ = origin_ + 3;
      origin_stride_ = direction_stride_ = 6;
    } else {
      first_ = numbers_of(origins, "origins", {3});
      second_ = numbers_of(directions, "directions", {3});
      const bool is_one_origin = first_.ndim() == 1, is_one_direction = second_.ndim() == 1;
      shape_ = leading_shape(is_one_origin ? second_ : first_);
      if (!is_one_origin && !is_one_direction && leading_shape(second_) != shape_)
        throw input_error("origins and directions have different shapes", "equal shapes, or one of them (3,)",
                          shape_text(first_) + " and " + shape_text(second_));
      count_ = static_cast<std::size_t>((is_one_origin ? second_ : first_).size() / 3);
      origin_ = first_.data();
      direction_ = second_.data();
      origin_stride_ = is_one_origin ? 0 : 3;
      direction_stride_ = is_one_direction ? 0 : 3;
    }
    t_min_.emplace(t_min, "t_min", shape_);
    t_max_.emplace(t_max.is_none() ? py::object(py::float_(std::numeric_limits<double>::infinity())) : t_max,
                   "t_max", shape_);
  }

  std::size_t size() const { return count_; }
  const Shape& shape() const { return shape_; }

  Ray operator[](std::size_t i) const {
    const double* const o = origin_ + origin_stride_ * i;
    const double* const d = direction_ + direction_stride_ * i;
    try {
      return make_ray({o[0], o[1], o[2]}, {d[0], d[1], d[2]}, (*t_min_)[i], (*t_max_)[i]);
    } catch (const Error& error) {
      Error::Parts parts = error.parts();
      parts.problem = fmt::format("ray {}: {}", i, parts.problem);
      throw Error(parts);
    }
  }

  /// Those from begin to end - 1, in parallel.
  void copy(std::size_t begin, std::size_t end, std::vector<Ray>& rays) const {
    rays.resize(end - begin);
    for_each_index(begin, end, [&](std::size_t i) { rays[i - begin] = (*this)[i]; });
  }

 private:
  Doubles first_, second_;
  Shape shape_;
  std::size_t count_ = 0;
  const double *origin_ = nullptr, *direction_ = nullptr;
  std::size_t origin_stride_ = 0, direction_stride_ = 0;
  std::optional<PerTarget> t_min_, t_max_;
};

}  // namespace alidade::python
