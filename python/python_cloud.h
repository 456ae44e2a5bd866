// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cloud/crs.h"
#include "image/film.h"
#include "jobs/field_table.h"
#include "octree/index_file/index_file.h"
#include "python/python_arrays.h"

// The classes Cloud and Index of the module.

namespace alidade::python {

/// NumPy's names of ScalarType, in its order.
inline constexpr const char* k_types[] = {"V", "u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"};

/// A cloud in memory or in a mapped index file. Immutable.
struct CloudData {
  IndexedCloud points;  ///< the octree only of an index file, whose points it has
  std::string name;     ///< for messages

  std::size_t size() const { return points.index ? points.octree.size() : points.cloud.size(); }
  const Lattice& lattice() const { return points.index ? points.octree.lattice() : points.cloud.lattice; }
  /// Coordinate reference system and other metadata of the files.
  const PointCloud& description() const { return points.index ? points.index->description() : points.cloud; }
};

/// Points and their attributes as arrays.
class Cloud {
 public:
  explicit Cloud(std::shared_ptr<const CloudData> data) : data_(std::move(data)) {}
  virtual ~Cloud() = default;

  const std::shared_ptr<const CloudData>& data() const { return data_; }
  /// (n, 3), world coordinates; computed at the first call.
  py::array xyz();

 private:
  std::shared_ptr<const CloudData> data_;
  py::object xyz_ = py::none();
};

/// A cloud with its octree.
class Index : public Cloud {
 public:
  Index(std::shared_ptr<const CloudData> data, Octree octree)
      : Cloud(std::move(data)), octree_(std::move(octree)) {}

  const Octree& octree() const { return octree_; }

 private:
  Octree octree_;
};

/// Gives a field a value of Python: numbers, texts, bool for flags, sequences for lists and for fields with
/// several values. None and False leave it as it is. Errors: those of FieldTable::give(); TypeError.
void give(jobs::FieldTable& table, const std::string& name, const py::handle& value);

/// A reference system as WKT, or "EPSG:n"; None if it is unknown.
py::object object_of(const Crs& crs);

/// The layers of a film by name, and as "image" its colours as PNG shows them; none of an empty film.
py::dict arrays_of(const image::Film& film, const image::OutputSettings& output);

/// Warnings of Python. `level`: 1 for the caller of a function of the module, 2 for the caller's caller.
void warn(const std::vector<std::string>& warnings, int level = 1);

/// Declares both classes and open().
void add_cloud(py::module_& module);
/// Declares the queries of Index.
void add_queries(py::class_<Index, Cloud>& index);
/// Declares render(), visible(), viewshed() and compare().
void add_images(py::module_& module);

}  // namespace alidade::python
