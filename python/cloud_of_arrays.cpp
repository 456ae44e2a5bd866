// SPDX-License-Identifier: MIT
#include <dlfcn.h>
#include <fmt/format.h>
#include <cmath>
#include <cstring>

#include "cloud/axis_units.h"
#include "python/python_cloud.h"

namespace alidade::python {
namespace {

/// The WKT of a code of EPSG, by GDAL if it is installed: the module itself works without it.
std::string wkt_of(int code) {
  using Handle = void*;
  Handle const library = ::dlopen("libgdal.so.32", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr)
    throw input_error("codes of EPSG need GDAL", "the Debian package libgdal32, or the system as WKT",
                      fmt::format("EPSG:{}", code));
  const auto create = reinterpret_cast<Handle (*)(const char*)>(::dlsym(library, "OSRNewSpatialReference"));
  const auto import = reinterpret_cast<int (*)(Handle, int)>(::dlsym(library, "OSRImportFromEPSG"));
  const auto write = reinterpret_cast<int (*)(Handle, char**)>(::dlsym(library, "OSRExportToWkt"));
  const auto destroy = reinterpret_cast<void (*)(Handle)>(::dlsym(library, "OSRDestroySpatialReference"));
  const auto free_text = reinterpret_cast<void (*)(void*)>(::dlsym(library, "VSIFree"));
  Handle const system = create(nullptr);
  char* text = nullptr;
  const bool is_known = import(system, code) == 0 && write(system, &text) == 0;
  const std::string wkt = is_known ? text : "";
  free_text(text);
  destroy(system);
  if (!is_known)
    throw input_error("unknown coordinate reference system", "a code of EPSG", fmt::format("EPSG:{}", code));
  return wkt;
}

/// WKT, or the code of a system.
Crs read_crs(const std::string& text) {
  Crs crs;
  crs.wkt = text;
  if (!text.starts_with("EPSG:")) return crs;
  const int code = std::atoi(text.c_str() + 5);
  if (code < 1 || text != fmt::format("EPSG:{}", code))
    throw input_error("unknown coordinate reference system", "WKT, or EPSG:n", text);
  crs.wkt = wkt_of(code);
  return crs;
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

/// An array as another type. Errors: it is no array of numbers; a whole number does not fit.
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

}  // namespace

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
    for_each_index(0, positions.size(), [&](std::size_t i) {
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

}  // namespace alidade::python
