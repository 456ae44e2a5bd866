// SPDX-License-Identifier: MIT

#include <dlfcn.h>
#include <filesystem>

#include "base/error.h"
#include "tools/image_module.h"

namespace alidade::tools {
namespace {

/// Where the module is: beside the program as it is built, or where both are installed.
std::filesystem::path module_file() {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::canonical("/proc/self/exe", error).parent_path();
  const std::filesystem::path installed = folder / ALIDADE_MODULE_FOLDER / ALIDADE_IMAGE_MODULE;
  return std::filesystem::exists(installed, error) ? installed : folder / ALIDADE_IMAGE_MODULE;
}

[[noreturn]] void fail(const std::filesystem::path& file) {
  const char* const reason = ::dlerror();
  throw Error({.file = file.string(),
               .problem = "pictures and maps cannot be read or written without this part of the program",
               .found = reason != nullptr ? reason : "nothing"});
}

}  // namespace

void* load_module_function(const char* name) {
  const std::filesystem::path file = module_file();
  void* const module = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) fail(file);
  void* const function = ::dlsym(module, name);
  if (function == nullptr) fail(file);
  return function;
}

ImageWriter load_image_writer() {
  return load_module_function<ImageWriter>("alidade_write_image");
}

LegendWriter load_legend_writer() {
  return load_module_function<LegendWriter>("alidade_write_legend");
}

SkyImageReader load_sky_image_reader() {
  return load_module_function<SkyImageReader>("alidade_read_sky_image");
}

SunPlacer load_sun_placer() {
  return load_module_function<SunPlacer>("alidade_place_sun");
}

LonLatTransformer load_lon_lat() {
  return load_module_function<LonLatTransformer>("alidade_lon_lat");
}

UnitMeasure load_metres_per_unit() {
  return load_module_function<UnitMeasure>("alidade_metres_per_unit");
}

RasterWriter load_raster_writer() {
  return load_module_function<RasterWriter>("alidade_write_raster");
}

MapDrawer load_map_drawer() {
  return load_module_function<MapDrawer>("alidade_write_map_picture");
}

CoverageWriter load_coverage_writer() {
  return load_module_function<CoverageWriter>("alidade_write_coverage_picture");
}

ObserverReader load_observer_reader() {
  return load_module_function<ObserverReader>("alidade_read_observers");
}

ObserverTransformer load_observer_transformer() {
  return load_module_function<ObserverTransformer>("alidade_transform_observers");
}

SkylineWriter load_skyline_writer() {
  return load_module_function<SkylineWriter>("alidade_write_skyline");
}

SchedulePlacer load_schedule_placer() {
  return load_module_function<SchedulePlacer>("alidade_place_schedule");
}

SunStepper load_sun_stepper() {
  return load_module_function<SunStepper>("alidade_sun_steps");
}

FileComparer load_file_comparer() {
  return load_module_function<FileComparer>("alidade_compare_files");
}

PairComparer load_pair_comparer() {
  return load_module_function<PairComparer>("alidade_compare_pairs");
}

ReportMaker load_report_maker() {
  return load_module_function<ReportMaker>("alidade_report_page");
}

DifferenceWriter load_difference_writer() {
  return load_module_function<DifferenceWriter>("alidade_write_difference");
}

}  // namespace alidade::tools
