// SPDX-License-Identifier: MIT
#include "geo/reproject.h"

#include <tbb/enumerable_thread_specific.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "geo/crs_library.h"
#include "geo/gdal_reference.h"

namespace alidade::geo {
namespace {

constexpr const char* k_systems = "a reference system such as EPSG:25832";

GdalReference reference_of_text(const std::string& text) {
  GdalReference reference(OSRNewSpatialReference(nullptr));
  if (OSRSetFromUserInput(reference.get(), text.c_str()) != OGRERR_NONE)
    throw input_error("unknown reference system", expected_system(text, k_systems), "'" + text + "'");
  OSRSetAxisMappingStrategy(reference.get(), OAMS_TRADITIONAL_GIS_ORDER);
  return reference;
}

GdalReference reference_of_file(const Crs& crs, const std::filesystem::path& file) {
  const std::string wkt = library_wkt(crs);
  if (wkt.empty())
    throw file_error(file, "cannot reproject: the reference system is unknown",
                     "--crs EPSG:n, which states it");
  GdalReference reference = reference_of_wkt(wkt);
  if (!reference || OSRIsLocal(reference.get()) != 0)
    throw file_error(file, "cannot reproject: the reference system says nowhere where on Earth it is",
                     "--crs EPSG:n, which states another", crs_name(crs));
  OSRSetAxisMappingStrategy(reference.get(), OAMS_TRADITIONAL_GIS_ORDER);
  return reference;
}

std::string text_of(const GdalReference& reference) {
  // LAS requires the first kind, which does not support all systems.
  for (const char* const format : {"FORMAT=WKT1", "FORMAT=WKT2"}) {
    std::string wkt = wkt_in_format(reference.get(), format);
    if (!wkt.empty()) return wkt;
  }
  throw Error({.problem = "the reference system cannot be written as WKT"});
}

/// Whether z of a system is a height that it defines: by a vertical part, or above the ellipsoid as in
/// EPSG:4979.
bool has_heights(const GdalReference& reference) {
  return OSRIsGeocentric(reference.get()) == 0 && OSRGetAxesCount(reference.get()) == 3;
}

/// The system with the vertical part of the other one, if only that has one.
std::string with_heights_of(const GdalReference& plane, const GdalReference& other) {
  const std::string wkt = text_of(plane);
  if (has_heights(plane)) return wkt;
  const std::string all = text_of(other);
  const GdalReference heights = reference_of_wkt(std::string(wkt_node(all, {"VERT_CS[", "VERTCRS["}))),
                      both(OSRNewSpatialReference(nullptr));
  if (!heights) return wkt;
  const std::string name = std::string(OSRGetName(plane.get())) + " + " + OSRGetName(heights.get());
  return OSRSetCompoundCS(both.get(), name.c_str(), plane.get(), heights.get()) == OGRERR_NONE ? text_of(both)
                                                                                               : wkt;
}

/// The unit of z in a system: of its heights, else of x and y, else metres.
LengthUnit height_unit_of(const GdalReference& reference) {
  const AxisUnits units = stated_units(crs_of_wkt(text_of(reference)));
  return units.heights ? *units.heights : units.plane.value_or(k_metre);
}

/// The system with heights in the unit of x and y.
GdalReference with_one_unit(GdalReference reference) {
  const Crs crs = crs_of_wkt(text_of(reference));
  const AxisUnits units = stated_units(crs);
  if (!units.plane || !units.heights || *units.plane == *units.heights) return reference;
  return reference_of_text(with_height_unit(crs, *units.plane).wkt);
}

/// Moves positions by a transformation. Each thread uses its own copy of it.
class Mover {
 public:
  explicit Mover(GdalTransformation transformation)
      : transformation_(std::move(transformation)),
        copies_([this] { return GdalTransformation(OCTClone(transformation_.get())); }) {}

  void operator()(std::span<glm::dvec3> positions) {
    constexpr std::size_t k_at_once = 4096;
    in_blocks(positions.size(), k_at_once, [&](std::size_t begin, std::size_t end) {
      const QuietGdal quiet;
      const std::size_t count = end - begin;
      std::vector<double> x(count), y(count), z(count);
      for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3& position = positions[begin + i];
        x[i] = position.x, y[i] = position.y, z[i] = position.z;
      }
      std::vector<int> is_moved(count);
      OCTTransformEx(copies_.local().get(), static_cast<int>(count), x.data(), y.data(), z.data(),
                     is_moved.data());
      constexpr double k_nowhere = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < count; ++i)
        positions[begin + i] = is_moved[i] ? glm::dvec3(x[i], y[i], z[i]) : glm::dvec3(k_nowhere);
    });
  }

 private:
  GdalTransformation transformation_;
  tbb::enumerable_thread_specific<GdalTransformation> copies_;
};

}  // namespace

Crs crs_of_text(const std::string& text) {
  const QuietGdal quiet;
  return crs_of_wkt(text_of(reference_of_text(text)));
}

std::string projjson_of(const Crs& crs) {
  const QuietGdal quiet;
  const GdalReference reference = reference_of_wkt(wkt_of(crs));
  if (!reference) return "";
  const char* const options[] = {"MULTILINE=NO", nullptr};
  char* json = nullptr;
  const bool is_exported = OSRExportToPROJJSON(reference.get(), &json, options) == OGRERR_NONE;
  const std::string kept = is_exported && json != nullptr ? json : "";
  CPLFree(json);
  return kept;
}

ReferenceChange change_reference(const ReferenceRequest& request, const std::filesystem::path& file,
                                 const FileFacts& facts) {
  const QuietGdal quiet;
  const Crs& own = facts.crs;
  ReferenceChange change{.crs = own};
  if (!request.stated.empty()) {
    change.crs = crs_of_text(request.stated);
    if (!own.empty() && compare_systems(own, change.crs) == CrsAgreement::different)
      change.warnings.push_back(file.string() + ": the file states the reference system " + crs_name(own) +
                                "; " + crs_name(change.crs) + " is used instead");
  }
  if (request.wanted.empty()) return change;
  if (const auto problem = implausible_crs(change.crs, facts.box.value_or(Bounds())))
    throw file_error(file, "cannot reproject: " + *problem, "--crs EPSG:n, which states the right system");
  GdalReference to = reference_of_text(request.wanted);
  const GdalReference from = reference_of_file(change.crs, file);
  if (request.has_one_unit) to = with_one_unit(std::move(to));
  const AxisUnits units = axis_units(change.crs, library_wkt(change.crs));
  const std::optional<LengthUnit> stated = height_unit_of_file(change.crs, units, request.height_unit, file);
  const bool to_heights = has_heights(to), from_centre = OSRIsGeocentric(from.get()) != 0,
             to_centre = OSRIsGeocentric(to.get()) != 0;
  const LengthUnit unit = height_unit_of(to),
                   before = from_centre ? k_metre : stated.value_or(height_unit_of(from));
  change.crs = crs_of_wkt(with_heights_of(to, from));
  if (!to_heights) change.crs = with_height_unit(change.crs, unit);
  // PROJ converts heights where both systems have them, and else returns them unchanged, or in metres.
  const bool follows = from_centre ? to_heights : has_heights(from) && (to_heights || to_centre);
  if (!follows && before != unit) {
    change.height_factor = before.metres / unit.metres;
    change.heights_note = fmt::format("heights are converted from {} to {}", before.name, unit.name);
    if (!stated && !from_centre)
      change.heights_note += fmt::format(", as if in {}; --vertical-unit states another",
                                         units.plane ? "the unit of x and y" : "metres");
  }
  // If the wanted system has no heights, those of a compound one must not be transformed by a grid.
  if (!to_heights && !to_centre) OSRStripVertical(from.get());
  if (OSRIsSame(from.get(), to.get()) != 0) return change;
  GdalTransformation transformation = transformation_between(from, to);
  if (!transformation)
    throw file_error(file, "no transformation to " + request.wanted, {}, CPLGetLastErrorMsg());
  const auto mover = std::make_shared<Mover>(std::move(transformation));
  // The z of geocentric positions becomes a height only when they move.
  const double factor = from_centre ? std::exchange(change.height_factor, 1.0) : 1.0;
  change.move = [mover, factor](std::span<glm::dvec3> positions) {
    (*mover)(positions);
    for (glm::dvec3& position : positions) position.z *= factor;
  };
  return change;
}

std::string metric_system(const Crs& crs, const glm::dvec3& position, const std::filesystem::path& file) {
  const QuietGdal quiet;
  const GdalReference from = reference_of_file(crs, file);
  if (OSRIsProjected(from.get()) != 0) return "";
  const GdalReference globe = globe_reference();
  const GdalTransformation transformation = transformation_between(from, globe);
  glm::dvec3 there = position;
  const bool has_image =
      transformation && OCTTransform(transformation.get(), 1, &there.x, &there.y, &there.z);
  if (!has_image || !(std::fabs(there.y) <= 90.0))
    throw file_error(file, "cannot choose a zone of UTM: the points lie nowhere on Earth",
                     "--reproject EPSG:n");
  // Source: EPSG registry, 326zz and 327zz (UTM north and south), 5041 and 5042 (UPS).
  if (there.y > 84.0) return "EPSG:5041";
  if (there.y < -80.0) return "EPSG:5042";
  const int zone = std::clamp(static_cast<int>(std::floor((there.x + 180.0) / 6.0)) + 1, 1, 60);
  return "EPSG:" + std::to_string((there.y < 0.0 ? 32700 : 32600) + zone);
}

}  // namespace alidade::geo
