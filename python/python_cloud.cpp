// SPDX-License-Identifier: MIT
#include "python/python_cloud.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <cmath>
#include <cstring>
#include <mutex>
#include <optional>
#include <variant>

#include "base/input_file.h"
#include "base/shown_text.h"
#include "base/words.h"
#include "cloud/axis_units.h"
#include "cloud/las/write_las.h"
#include "cloud/ply/write_ply.h"
#include "cloud/point_table.h"
#include "cloud/read_cloud.h"
#include "geo/reproject.h"
#include "jobs/cloud_fields.h"
#include "octree/build.h"
#include "octree/index_file/save_index.h"
#include "octree/spacing.h"
#include "octree/tree_walk.h"
#include "python/docstrings.h"
#include "surface/point_surface.h"

namespace alidade::python {
namespace {

/// Keeps the cloud for as long as an array of its values exists.
py::capsule owner_of(const std::shared_ptr<const CloudData>& data) {
  return py::capsule(new std::shared_ptr<const CloudData>(data),
                     [](void* pointer) { delete static_cast<std::shared_ptr<const CloudData>*>(pointer); });
}

template <class Row, class Value>
py::array rows_of(std::span<const Row> rows, const Value* first, const py::handle& owner) {
  constexpr auto k_width = static_cast<py::ssize_t>(sizeof(Row) / sizeof(Value));
  return view_of(first, {static_cast<py::ssize_t>(rows.size()), k_width}, {sizeof(Row), sizeof(Value)},
                 owner);
}

py::array every(std::span<const ReturnNumbers> returns, std::uint8_t ReturnNumbers::*member,
                const py::handle& owner) {
  return view_of(&(returns.data()->*member), {static_cast<py::ssize_t>(returns.size())},
                 {sizeof(ReturnNumbers)}, owner);
}

/// Colours as an array; those of 8 bits are copied.
py::array array_of(const ColorColumn& colors, const py::handle& owner) {
  if (!colors.deep().empty()) return rows_of(colors.deep(), &colors.deep().data()->x, owner);
  py::array_t<std::uint16_t> array({static_cast<py::ssize_t>(colors.size()), py::ssize_t{3}});
  std::uint16_t* to = array.mutable_data();
  run_free(0, [&] {
    for (const Color16 color : colors) to = std::copy_n(&color.x, 3, to);
  });
  array.attr("flags").attr("writeable") = false;
  return array;
}

/// Calls visit(name, array) for every standard column of the cloud.
template <class Visit>
void for_each_array(const AttributeColumns& columns, const py::handle& owner, const Visit& visit) {
  const auto plain = [&](const char* name, const auto& values) {
    if (!values.empty()) visit(name, [&] { return view_of(values, owner); });
  };
  if (!columns.colors.empty()) visit("color", [&] { return array_of(columns.colors, owner); });
  plain("near_infrared", columns.near_infrared);
  plain("intensity", columns.intensities);
  plain("classification", columns.classifications);
  if (!columns.returns.empty()) {
    visit("return_number", [&] { return every(columns.returns, &ReturnNumbers::number, owner); });
    visit("number_of_returns", [&] { return every(columns.returns, &ReturnNumbers::count, owner); });
  }
  plain("flags", columns.flags);
  plain("scan_angle", columns.scan_angles);
  plain("user_data", columns.user_data);
  plain("point_source_id", columns.point_source_ids);
  plain("gps_time", columns.gps_times);
  if (!columns.normals.empty())
    visit("normal", [&] { return rows_of(columns.normals, &columns.normals.data()->x, owner); });
}

/// Stored numbers as they are; columns with a scale or a nodata value as doubles, NaN for no value.
py::array array_of(const ExtraColumn& column, const py::handle& owner) {
  const ExtraDimension& facts = column.description;
  const std::size_t stride = static_cast<std::size_t>(facts.byte_count);
  const std::size_t count = column.values.size() / stride;
  if (facts.type != ScalarType::bytes && (facts.has_scale || facts.has_offset || facts.no_data)) {
    py::array_t<double> meant(static_cast<py::ssize_t>(count));
    double* const to = meant.mutable_data();
    run_free(0, [&] {
      in_parallel(count, k_array_grain,
                  [&](std::size_t i) { to[i] = meant_number(facts, column.values.data() + i * stride); });
    });
    meant.attr("flags").attr("writeable") = false;
    return meant;
  }
  const std::string type = facts.type == ScalarType::bytes ? fmt::format("V{}", stride)
                                                           : k_types[static_cast<std::size_t>(facts.type)];
  py::array array(py::dtype(type), {static_cast<py::ssize_t>(count)}, {static_cast<py::ssize_t>(stride)},
                  column.values.data(), owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

py::list names_of(const AttributeColumns& columns) {
  py::list names;
  for_each_array(columns, py::none(), [&](const char* name, const auto&) { names.append(name); });
  for (const ExtraColumn& column : columns.extra_dimensions) names.append(text_of(column.description.name));
  return names;
}

py::array column_of(const Cloud& cloud, const py::str& wanted) {
  const AttributeColumns columns = cloud.data()->points.columns();
  const py::capsule owner = owner_of(cloud.data());
  py::object found = py::none();
  for_each_array(columns, owner, [&](const char* name, const auto& make) {
    if (!wanted.equal(py::str(name))) return;
    found = make();
  });
  for (const ExtraColumn& column : columns.extra_dimensions) {
    if (found.is_none() && wanted.equal(text_of(column.description.name))) found = array_of(column, owner);
  }
  if (!found.is_none()) return found;
  const py::str text = py::str("the cloud has no attribute {!r}; it has {}")
                           .format(wanted, py::str(", ").attr("join")(names_of(columns)));
  PyErr_SetObject(PyExc_KeyError, text.ptr());
  throw py::error_already_set();
}

py::object crs_of(const Cloud& cloud) {
  return object_of(cloud.data()->description().crs);
}

py::object open_clouds(const py::object& files, int workers, const py::object& progress,
                       const py::kwargs& fields) {
  const auto data = std::make_shared<CloudData>();
  const auto table = std::make_shared<jobs::FieldTable>("open", &is_interrupted);
  CloudInputs inputs;
  bool partial = false;
  jobs::add_cloud(jobs::Fields(table), inputs);
  jobs::add_partial(jobs::Fields(table), partial);
  try {
    give(*table, "files", files);
    for (const auto& [name, value] : fields) give(*table, py::str(name), value);
    run_watched(workers, progress, [&](const Progress& watch) {
      table->read();
      data->name = inputs.title();
      if (const CloudInput* const index = inputs.only(k_index_format)) {
        if (index->changes_heights())
          throw file_error(index->name, "an index of heights that are not in the unit of x and y",
                           "one that 'alidade index' makes again: it converts them");
        data->points = load_indexed_cloud(inputs, {.read = {.progress = watch}, .build = {}});
      } else {
        data->points.cloud = read_cloud(inputs, {.partial = partial, .region = {}, .progress = watch});
      }
    });
  } catch (const jobs::UsageError& error) {
    throw Error({.problem = table->in_own_words(error.what())});
  } catch (const Error& error) {
    throw Error({.problem = table->in_own_words(error.what())});
  }
  warn(data->points.cloud.warnings);
  if (data->points.index) return py::cast(Index(data, data->points.octree));
  return py::cast(Cloud(std::move(data)));
}

Organisation organisation_of(const std::string& word) {
  if (word == "adaptive") return Organisation::adaptive;
  if (word == "layered") return Organisation::layered;
  throw input_error("unknown organisation", "adaptive or layered", word);
}

Index index_of(const Cloud& cloud, const std::string& organisation, bool surfaces, int workers,
               const py::object& progress) {
  const std::shared_ptr<const CloudData> data = cloud.data();
  Octree octree = data->points.octree;
  const Organisation wanted = organisation_of(organisation);
  if (data->points.index && wanted != octree.view().organisation)
    throw input_error("the index file has another organisation", "that of the file, or a cloud to index",
                      organisation);
  run_watched(workers, progress, [&](const Progress& watch) {
    if (!data->points.index) octree = build(data->points.cloud, {.organisation = wanted, .progress = watch});
    if (surfaces) octree = with_surfaces(with_spacings(octree, k_surface_neighbours, watch), watch);
  });
  return {data, std::move(octree)};
}

/// A copy of a cloud that is mapped, with positions.
PointCloud copy_of(const CloudData& data) {
  const IndexedCloud& mapped = data.points;
  PointCloud cloud = mapped.index->description();
  cloud.lattice = mapped.octree.lattice();
  cloud.records = mapped.index->records();
  cloud.positions = positions_in_order(mapped.octree.view());
  const AttributeColumns& columns = mapped.index->columns();
  for_each_column(cloud, columns, [](Attribute, auto& column, const auto& values) {
    column.assign(values.begin(), values.end());
  });
  cloud.extra_dimensions.clear();
  for (const ExtraColumn& column : columns.extra_dimensions) {
    cloud.extra_dimensions.push_back(column.description);
    cloud.extra_dimensions.back().values.assign(column.values.begin(), column.values.end());
  }
  return cloud;
}

void write(const Cloud& cloud, const std::filesystem::path& file, bool overwrite,
           const py::object& progress) {
  const std::string extension = file_extension(file);
  if (extension != ".las" && extension != ".laz" && extension != ".ply")
    throw file_error(file.string(), "unknown output format", ".las, .laz or .ply");
  std::vector<std::string> warnings;
  run_watched(0, progress, [&](const Progress& watch) {
    const IndexedCloud& stored = cloud.data()->points;
    const PointCloud copy = stored.index ? copy_of(*cloud.data()) : PointCloud();
    const PointCloud& points = stored.index ? copy : stored.cloud;
    if (extension == ".ply") {
      write_ply(file, points, {.overwrite = overwrite, .progress = watch});
    } else {
      write_las(file, points,
                {.overwrite = overwrite, .progress = watch, .warn = [&](const std::string& text) {
                   warnings.push_back(text);
                 }});
    }
  });
  warn(warnings);
}

void save(const Index& index, const std::filesystem::path& file, bool overwrite, const py::object& progress) {
  run_watched(0, progress, [&](const Progress& watch) {
    const IndexedCloud& stored = index.data()->points;
    const PointCloud copy = stored.index ? copy_of(*index.data()) : PointCloud();
    save_index(file, index.octree(), stored.index ? copy : stored.cloud,
               {.overwrite = overwrite, .progress = watch});
  });
}

py::array bounds_of(const Cloud& cloud) {
  const CloudData& data = *cloud.data();
  const Bounds bounds = data.points.index ? data.points.octree.bounds() : data.points.cloud.bounds();
  py::array_t<double> array({2, 3});
  for (int axis = 0; axis < 3; ++axis) {
    array.mutable_at(0, axis) = bounds.min[axis];
    array.mutable_at(1, axis) = bounds.max[axis];
  }
  return array;
}

/// WKT, or the code of a system, which needs GDAL.
Crs read_crs(const std::string& text) {
  return text.starts_with("EPSG:") ? geo::crs_of_text(text) : crs_of_wkt(text);
}

py::array require_rows(const py::handle& given, const std::string& name, std::size_t rows,
                       py::ssize_t width = 0) {
  const py::array array = py::array::ensure(given);
  const bool fits = array && array.ndim() == (width > 0 ? 2 : 1) &&
                    static_cast<std::size_t>(array.shape(0)) == rows &&
                    (width == 0 || array.shape(1) == width);
  if (fits) return array;
  PyErr_Clear();
  throw input_error("attribute '" + name + "' has the wrong shape",
                    width > 0 ? fmt::format("({}, {})", rows, width) : fmt::format("({},)", rows),
                    array ? "shape " + shape_text(array) : "no array");
}

/// An array as another type. Errors: it has no numbers; a whole number does not fit.
template <class T>
py::array_t<T, py::array::c_style | py::array::forcecast> as(const py::array& array,
                                                             const std::string& name) {
  using Typed = py::array_t<T, py::array::c_style | py::array::forcecast>;
  const bool is_number = std::string("buif").find(array.dtype().kind()) != std::string::npos;
  Typed typed = is_number ? Typed::ensure(array) : Typed();
  const bool is_same =
      typed && (std::is_floating_point_v<T> || array.dtype().is(py::dtype::of<T>()) ||
                py::module_::import("numpy").attr("array_equal")(typed, array).template cast<bool>());
  if (is_same) return typed;
  PyErr_Clear();
  throw input_error("attribute '" + name + "' has values that do not fit",
                    "numbers of " + py::str(py::dtype::of<T>()).cast<std::string>(),
                    "dtype " + py::str(array.dtype()).cast<std::string>());
}

template <class T>
void set(std::vector<T>& column, const py::array& array, const std::string& name) {
  const auto typed = as<T>(array, name);
  column.assign(typed.data(), typed.data() + typed.size());
}

void set_colors(PointCloud& cloud, const py::array& array) {
  const bool is_8_bit = array.itemsize() == 1;
  const auto typed = as<std::uint16_t>(array, "color");
  cloud.colors.resize(static_cast<std::size_t>(typed.shape(0)));
  for (std::size_t i = 0; i < cloud.colors.size(); ++i)
    cloud.colors[i] = Color16(typed.data()[3 * i], typed.data()[3 * i + 1], typed.data()[3 * i + 2]) *
                      std::uint16_t(is_8_bit ? 257 : 1);
}

void set_normals(PointCloud& cloud, const py::array& array) {
  const auto typed = as<float>(array, "normal");
  cloud.normals.resize(static_cast<std::size_t>(typed.shape(0)));
  std::memcpy(cloud.normals.data(), typed.data(), sizeof(glm::vec3) * cloud.normals.size());
}

void add_extra(PointCloud& cloud, const py::array& given, const std::string& name) {
  const py::array array = given.dtype().kind() == 'b' ? py::array(given.attr("astype")("u1")) : given;
  const std::string type = fmt::format("{}{}", array.dtype().kind(), array.itemsize());
  const auto* const known = std::ranges::find(k_types, type);
  if (known == std::end(k_types))
    throw input_error("attribute '" + name + "' has values of an unknown kind",
                      "whole numbers of 8 to 64 bits, or floating-point numbers of 32 or 64",
                      "dtype " + py::str(array.dtype()).cast<std::string>());
  ExtraDimension column = plain_dimension(name, static_cast<ScalarType>(known - std::begin(k_types)));
  const py::object native = array.attr("astype")(array.dtype().attr("newbyteorder")("="));
  const py::array packed = py::module_::import("numpy").attr("ascontiguousarray")(native);
  const auto* const bytes = static_cast<const std::uint8_t*>(packed.data());
  column.values.assign(bytes, bytes + packed.nbytes());
  cloud.extra_dimensions.push_back(std::move(column));
}

void set_attribute(PointCloud& cloud, const std::string& name, const py::handle& given) {
  const std::size_t count = cloud.size();
  const bool is_triple = name == "color" || name == "normal";
  const py::array array = require_rows(given, name, count, is_triple ? 3 : 0);
  if (name == "color") return set_colors(cloud, array);
  if (name == "normal") return set_normals(cloud, array);
  if (name == "near_infrared") return set(cloud.near_infrared, array, name);
  if (name == "intensity") return set(cloud.intensities, array, name);
  if (name == "classification") return set(cloud.classifications, array, name);
  if (name == "flags") return set(cloud.flags, array, name);
  if (name == "scan_angle") return set(cloud.scan_angles, array, name);
  if (name == "user_data") return set(cloud.user_data, array, name);
  if (name == "point_source_id") return set(cloud.point_source_ids, array, name);
  if (name == "gps_time") return set(cloud.gps_times, array, name);
  if (name != "return_number" && name != "number_of_returns") return add_extra(cloud, array, name);
  const auto typed = as<std::uint8_t>(array, name);
  cloud.returns.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    (name == "return_number" ? cloud.returns[i].number : cloud.returns[i].count) = typed.data()[i];
}

/// A lattice of this scale, or the finest power of ten that 32 bits hold.
Lattice lattice_for(std::span<const glm::dvec3> positions, std::optional<double> scale) {
  CoordinateSurvey survey;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const glm::dvec3& position = positions[i];
    if (!std::isfinite(position.x) || !std::isfinite(position.y) || !std::isfinite(position.z))
      throw input_error(fmt::format("row {} of xyz is not finite", i), "finite coordinates",
                        fmt::format("{} {} {}", position.x, position.y, position.z));
    survey.bounds.grow(position);
  }
  survey.finite_count = positions.size();
  if (!scale) return fit_lattice(std::array{survey});
  const double step = *scale;
  if (!(step > 0.0) || !std::isfinite(step))
    throw input_error("the scale is out of range", "a number above 0");
  const glm::dvec3 low = survey.bounds.empty() ? glm::dvec3(0.0) : survey.bounds.min;
  return {glm::dvec3(step), {std::floor(low.x), std::floor(low.y), std::floor(low.z)}};
}

/// The cloud of Cloud(xyz, crs=..., scale=..., name=values). Errors: Error that names the array and what is
/// expected.
Cloud cloud_of_arrays(const py::handle& xyz, const std::optional<std::string>& crs,
                      std::optional<double> scale, const py::kwargs& attributes) {
  const Doubles coordinates = numbers_of(xyz, "xyz", {3});
  if (coordinates.ndim() != 2)
    throw input_error("xyz has the wrong shape", "(n, 3)", "shape " + shape_text(coordinates));
  const std::span<const glm::dvec3> positions = as_positions(coordinates);
  auto data = std::make_shared<CloudData>();
  data->name = "the cloud";
  PointCloud& cloud = data->points.cloud;
  cloud.lattice = lattice_for(positions, scale);
  cloud.positions.resize(positions.size());
  run_free(0, [&] {
    in_parallel(positions.size(), k_array_grain, [&](std::size_t i) {
      const auto steps = to_lattice(cloud.lattice, positions[i]);
      if (!steps)
        throw input_error(fmt::format("row {} of xyz does not fit into 32 bits of the scale", i),
                          "a larger scale", fmt::format("{}", cloud.lattice.scale.x));
      cloud.positions[i] = *steps;
    });
  });
  if (crs) cloud.crs = read_crs(*crs);
  if (heights_in_plane_unit(cloud.crs, {}, "crs").factor != 1.0)
    throw input_error("the reference system has heights in another unit than x and y",
                      "z in the unit of x and y, and a system that says so", crs_name(cloud.crs));
  for (const auto& [name, values] : attributes) set_attribute(cloud, name.cast<std::string>(), values);
  return Cloud(std::move(data));
}

}  // namespace

py::array Cloud::xyz() {
  if (!xyz_.is_none()) return xyz_;
  const std::size_t count = data_->size();
  py::array_t<double> array({static_cast<py::ssize_t>(count), py::ssize_t{3}});
  auto* const rows = reinterpret_cast<glm::dvec3*>(array.mutable_data());
  run_free(0, [&] {
    const PointCloud& cloud = data_->points.cloud;
    const std::vector<LatticePosition> stored = data_->points.index
                                                    ? positions_in_order(data_->points.octree.view())
                                                    : std::vector<LatticePosition>();
    const std::vector<LatticePosition>& positions = data_->points.index ? stored : cloud.positions;
    in_parallel(count, k_array_grain,
                [&](std::size_t i) { rows[i] = to_world(data_->lattice(), positions[i]); });
  });
  array.attr("flags").attr("writeable") = false;
  xyz_ = array;
  return array;
}

py::object object_of(const Crs& crs) {
  if (!crs.wkt.empty()) return text_of(crs.wkt);
  const std::vector<std::string> codes = epsg_codes(crs);
  if (codes.empty()) return py::none();
  // "EPSG:25832+7837", as PROJ writes compound systems.
  std::vector<std::string> numbers;
  for (const std::string& code : codes) numbers.push_back(code.substr(code.rfind(':') + 1));
  return py::str(fmt::format("EPSG:{}", fmt::join(numbers, "+")));
}

void warn(const std::vector<std::string>& warnings, int level) {
  for (const std::string& warning : warnings)
    if (PyErr_WarnEx(PyExc_UserWarning, line_text(warning).c_str(), level) != 0)
      throw py::error_already_set();
}

void add_cloud(py::module_& module) {
  py::class_<Cloud> cloud(module, "Cloud", k_cloud_doc);
  py::class_<Index, Cloud> index(module, "Index", k_index_doc);
  cloud
      .def(py::init(&cloud_of_arrays), py::arg("xyz"), py::kw_only(), py::arg("crs") = py::none(),
           py::arg("scale") = py::none())
      .def("__len__", [](const Cloud& self) { return self.data()->size(); })
      .def("__getitem__", &column_of)
      .def("__contains__",
           [](const Cloud& self, const py::object& name) {
             return names_of(self.data()->points.columns()).contains(name);
           })
      .def("__repr__",
           [](const Cloud& self) {
             return fmt::format("<alidade.{} of {} points>",
                                dynamic_cast<const Index*>(&self) != nullptr ? "Index" : "Cloud",
                                self.data()->size());
           })
      .def(
          "keys", [](const Cloud& self) { return names_of(self.data()->points.columns()); }, k_keys_doc)
      .def_property_readonly("xyz", &Cloud::xyz, k_xyz_doc)
      .def_property_readonly("bounds", &bounds_of, k_bounds_doc)
      .def_property_readonly("crs", &crs_of, k_crs_doc)
      .def_property_readonly(
          "scale",
          [](const Cloud& self) {
            const glm::dvec3& scale = self.data()->lattice().scale;
            return py::make_tuple(scale.x, scale.y, scale.z);
          },
          k_scale_doc)
      .def("index", &index_of, k_make_index_doc, py::kw_only(), py::arg("organisation") = "adaptive",
           py::arg("surfaces") = false, py::arg("workers") = -1, py::arg("progress") = py::none())
      .def("write", &write, k_write_doc, py::arg("file"), py::kw_only(), py::arg("overwrite") = false,
           py::arg("progress") = py::none());
  index.def("save", &save, k_save_doc, py::arg("file"), py::kw_only(), py::arg("overwrite") = false,
            py::arg("progress") = py::none());
  add_queries(index);
  module.def("open", &open_clouds, k_open_doc, py::arg("files"), py::kw_only(), py::arg("workers") = -1,
             py::arg("progress") = py::none());
}

}  // namespace alidade::python
