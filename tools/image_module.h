// SPDX-License-Identifier: MIT
#pragma once

#include "compare/batch.h"
#include "compare/comparison.h"
#include "compare/difference_map.h"
#include "compare/report/report_page.h"
#include "geo/crs_library.h"
#include "geo/earth.h"
#include "geo/geopackage.h"
#include "geo/raster_file.h"
#include "geo/remote_file.h"
#include "geo/reproject.h"
#include "geo/sun.h"
#include "geo/vector_file.h"
#include "image/image_file.h"
#include "image/legend.h"
#include "image/read_image.h"
#include "visibility/horizon/skyline_image.h"
#include "visibility/photos/photo_file.h"
#include "visibility/points/coverage_image.h"
#include "visibility/raster/map_image.h"
#include "visibility/read_observers.h"
#include "visibility/sky/sun_path.h"

namespace alidade::tools {

/// The functions of the libraries that need OpenImageIO or GDAL, which bring some 250 libraries: loading
/// these takes longer, and more memory, than all the work of most commands. So the functions are in a module
/// beside the program, and only a command that needs one loads it. Their contracts are those of their
/// headers. Only the module makes an ImageModule: the program would have to link the functions.
struct ImageModule {
  decltype(&image::library_version) image_library = &image::library_version;
  decltype(&geo::library_versions) map_libraries = &geo::library_versions;
  decltype(&image::write_image) write_image = &image::write_image;
  decltype(&image::write_legend) write_legend = &image::write_legend;
  decltype(&image::write_depth_map) write_depth_map = &image::write_depth_map;
  decltype(&image::write_depth_mask) write_depth_mask = &image::write_depth_mask;
  decltype(&image::read_sky_image) read_sky_image = &image::read_sky_image;
  decltype(&image::photo_size) photo_size = &image::photo_size;
  decltype(&image::read_photo) read_photo = &image::read_photo;
  decltype(&geo::place_sun) place_sun = &geo::place_sun;
  decltype(&geo::describe) describe_sun = &geo::describe;
  decltype(&geo::open_remote_file) open_remote_file = &geo::open_remote_file;
  decltype(&geo::remote_traffic) remote_traffic = &geo::remote_traffic;
  decltype(&geo::write_geopackage) write_geopackage = &geo::write_geopackage;
  decltype(&geo::write_raster) write_raster = &geo::write_raster;
  decltype(&geo::is_raster) is_raster = &geo::is_raster;
  decltype(&geo::read_heights) read_heights = &geo::read_heights;
  decltype(&geo::compare_systems) compare_systems = &geo::compare_systems;
  decltype(&geo::library_wkt) library_wkt = &geo::library_wkt;
  decltype(&geo::read_polygons) read_polygons = &geo::read_polygons;
  decltype(&geo::lon_lat) lon_lat = &geo::lon_lat;
  decltype(&geo::change_reference) change_reference = &geo::change_reference;
  decltype(&geo::projjson_of) projjson_of = &geo::projjson_of;
  decltype(&geo::metric_system) metric_system = &geo::metric_system;
  decltype(&geo::metres_per_unit) metres_per_unit = &geo::metres_per_unit;
  decltype(&visibility::read_observers) read_observers = &visibility::read_observers;
  decltype(&visibility::read_objects) read_objects = &visibility::read_objects;
  decltype(&visibility::to_cloud_reference) to_cloud_reference = &visibility::to_cloud_reference;
  decltype(&visibility::write_map_image) write_map_image = &visibility::write_map_image;
  decltype(&visibility::write_coverage_image) write_coverage_image = &visibility::write_coverage_image;
  decltype(&visibility::write_photos) write_photos = &visibility::write_photos;
  decltype(&visibility::write_skyline) write_skyline = &visibility::write_skyline;
  decltype(&visibility::place_schedule) place_schedule = &visibility::place_schedule;
  decltype(&visibility::sun_steps) sun_steps = &visibility::sun_steps;
  decltype(&visibility::sun_curves) sun_curves = &visibility::sun_curves;
  decltype(&visibility::sun_periods) sun_periods = &visibility::sun_periods;
  decltype(&compare::compare_files) compare_files = &compare::compare_files;
  decltype(&compare::compare_pairs) compare_pairs = &compare::compare_pairs;
  decltype(&compare::report_page) report_page = &compare::report_page;
  decltype(&compare::write_difference) write_difference = &compare::write_difference;
};

/// Loads the module, which stays loaded. Errors: the module is missing where the program was built or
/// installed, or lacks a library; those of RemoteMap::check_all(), which the module cannot call for the
/// program: files that the module writes might be wrong.
const ImageModule& image_module();

/// image_module() without the errors of RemoteMap::check_all().
const ImageModule& loaded_image_module();

}  // namespace alidade::tools
