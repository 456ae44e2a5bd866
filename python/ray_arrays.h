// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>

#include "octree/ray_columns.h"
#include "python/python_arrays.h"

namespace alidade::python {

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
    for_each_index(begin, end, [&](std::size_t i) { rays[i - begin] = (*this)[i]; });
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

}  // namespace alidade::python
