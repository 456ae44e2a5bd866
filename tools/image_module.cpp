// SPDX-License-Identifier: MIT
// The module that image_module() loads.
#include "tools/image_module.h"

extern "C" const alidade::tools::ImageModule* alidade_image_module() {
  using namespace alidade;
  static constexpr tools::ImageModule k_module = {
      .write_image = &renderer::write_image,
      .write_legend = &image::write_legend,
      .read_sky_image = &image::read_sky_image,
      .place_sun = &geo::place_sun,
      .describe_sun = &geo::describe,
      .write_raster = &geo::write_raster,
      .read_polygons = &geo::read_polygons,
      .lon_lat = &geo::lon_lat,
      .metres_per_unit = &geo::metres_per_unit,
      .read_observers = &visibility::read_observers,
      .to_cloud_reference = &visibility::to_cloud_reference,
      .write_map_picture = &visibility::write_map_picture,
      .write_coverage_picture = &visibility::write_coverage_picture,
      .write_skyline = &visibility::write_skyline,
      .place_schedule = &visibility::place_schedule,
      .sun_steps = &visibility::sun_steps,
      .compare_files = &compare::compare_files,
      .compare_pairs = &compare::compare_pairs,
      .report_page = &compare::report_page,
      .write_difference = &compare::write_difference,
  };
  return &k_module;
}
