// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cloud/crs.h"
#include "compare/batch.h"
#include "compare/comparison.h"
#include "compare/report/page.h"
#include "geo/raster_file.h"
#include "geo/sun.h"
#include "geo/vector_file.h"
#include "image/image_file.h"
#include "image/legend.h"
#include "renderer/picture_metadata.h"
#include "renderer/sky.h"
#include "visibility/horizon/skyline.h"
#include "visibility/observers.h"
#include "visibility/points/placement.h"
#include "visibility/raster/map_picture.h"
#include "visibility/sky/sun_path.h"

namespace alidade::tools {

// Image formats, map formats and reference systems come through OpenImageIO and GDAL, which bring some 250
// libraries: loading them takes longer, and more memory, than all the work of most commands. So they stand in
// a module beside the program, and only who needs them loads it.

/// The function of that name in the module, which stays loaded. Errors: the module is not where the program
/// was built or installed, or it lacks a library.
void* load_module_function(const char* name);

/// The same as a pointer to a function of that type.
template <class Function>
Function load_module_function(const char* name) {
  return reinterpret_cast<Function>(load_module_function(name));
}

// What the program has the module do for it (load_module.h): writing pictures and legends, reading the
// picture of a sky, and the reference systems (GDAL) that a sun by date and place is turned with.

/// write_image() of image/image_file.h.
using ImageWriter = void (*)(const image::Film& film, const image::OutputSettings& output,
                             const renderer::ImageMetadata& metadata, bool overwrite);

/// Errors, here and below: those of load_module_function().
ImageWriter load_image_writer();

/// write_legend() of image/legend.h.
using LegendWriter = void (*)(const image::ColorKey& key, const std::filesystem::path& file,
                              const std::optional<glm::ivec2>& size, bool overwrite);

/// The same for legends.
LegendWriter load_legend_writer();

/// read_sky_image() of image/read_picture.h, into `pixels`.
using SkyImageReader = void (*)(const std::filesystem::path& file, image::SkyPixels& pixels);
SkyImageReader load_sky_image_reader();

/// place_sun() and describe() of geo/sun.h.
using SunPlacer = void (*)(const geo::SunByTime& by_time, const std::optional<geo::SceneMap>& map,
                           geo::PlacedSun& placed, std::string& description);
SunPlacer load_sun_placer();

// What the module knows of reference systems (tools/image_module.h).

/// lon_lat() of geo/earth.h, into `answers`. Errors, here and below: those of
/// load_module_function().
using LonLatTransformer = void (*)(const Crs& crs, const std::vector<glm::dvec3>& places,
                                   std::optional<std::vector<glm::dvec3>>& answers);
LonLatTransformer load_lon_lat();

/// metres_per_unit() of geo/earth.h, into `metres`.
using UnitMeasure = void (*)(const Crs& crs, std::optional<double>& metres);
UnitMeasure load_metres_per_unit();

// What the commands of visibility have the module do for them (tools/image_module.h).

/// write_raster() of geo/raster_file.h. Errors, here and below: those of load_module_function().
using RasterWriter = void (*)(const std::filesystem::path& file, const geo::RasterContents& contents,
                              bool overwrite);
RasterWriter load_raster_writer();

/// write_map_picture() of visibility/raster/map_picture.h.
using MapDrawer = void (*)(const visibility::MapPicture& picture, const visibility::Ground& ground,
                           const std::filesystem::path& file, bool overwrite);
MapDrawer load_map_drawer();

/// write_coverage_picture() of visibility/points/placement.h, through the module (tools/image_module.h).
using CoverageWriter = void (*)(const visibility::Placement& placement, const std::filesystem::path& file,
                                bool overwrite);
CoverageWriter load_coverage_writer();

// What the commands of visibility have the module do for them (tools/image_module.h).

/// read_observers() of visibility/read_observers.h, into `observers`. Errors, here and below: those of
/// load_module_function().
using ObserverReader = void (*)(const std::filesystem::path& path, const geo::ObserverReference& reference,
                                std::vector<visibility::GivenObserver>& observers);
ObserverReader load_observer_reader();

/// to_cloud_reference() of visibility/read_observers.h, for observers that say no system themselves.
using ObserverTransformer = void (*)(const geo::ObserverReference& reference,
                                     std::vector<visibility::GivenObserver>& observers);
ObserverTransformer load_observer_transformer();

// What the commands of horizon, sky and sun have the module do for them (tools/image_module.h).

/// write_skyline() of visibility/horizon/skyline.h. Errors, here and below: those of load_module_function().
using SkylineWriter = void (*)(const visibility::DepthStrip& strip,
                               std::span<const visibility::HorizonDirection> horizon,
                               const visibility::SkylineTexts& texts, const std::filesystem::path& file,
                               bool overwrite);
SkylineWriter load_skyline_writer();

/// place_schedule() of visibility/sky/sun_path.h, and its answer.
using SchedulePlacer = bool (*)(const Crs& crs, const glm::dvec2& center,
                                const std::optional<glm::dvec2>& latitude_longitude,
                                visibility::SunSchedule& schedule);
SchedulePlacer load_schedule_placer();

/// sun_steps() of visibility/sky/sun_path.h.
using SunStepper = void (*)(const visibility::SunSchedule& schedule, const Progress& progress,
                            std::vector<visibility::SunStep>& steps);
SunStepper load_sun_stepper();

// What `alidade compare` has the module do for it (tools/image_module.h): everything that reads or writes
// pictures.

/// compare_files() of compare/comparison.h. Errors, here and below: those of load_module_function().
using FileComparer = void (*)(const std::filesystem::path& reference, const std::filesystem::path& test,
                              const compare::ComparisonOptions& options, const Progress& progress,
                              compare::Comparison& comparison);
FileComparer load_file_comparer();

/// compare_pairs() of compare/batch.h.
using PairComparer = void (*)(const std::vector<compare::ImagePair>& pairs,
                              const compare::BatchOptions& options, const Progress& progress,
                              std::vector<compare::PairOutcome>& outcomes);
PairComparer load_pair_comparer();

/// report_page() of compare/report/page.h.
using ReportMaker = void (*)(const compare::Comparison& comparison, const compare::Verdict& verdict,
                             image::PicturePacking packing, const compare::Verdict& warnings,
                             std::string& page);
ReportMaker load_report_maker();

/// write_difference() of compare/difference_map.h.
using DifferenceWriter = void (*)(const compare::DifferenceMap& map, const std::filesystem::path& file,
                                  bool overwrite);
DifferenceWriter load_difference_writer();

}  // namespace alidade::tools
