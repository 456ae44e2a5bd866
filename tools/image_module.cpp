// SPDX-License-Identifier: MIT
#include "tools/image_module.h"
#include "compare/batch.h"
#include "compare/report/page.h"
#include "geo/earth.h"
#include "geo/raster_file.h"
#include "geo/read_polygons.h"
#include "geo/sun.h"
#include "image/read_picture.h"
#include "visibility/horizon/skyline.h"
#include "visibility/points/placement.h"
#include "visibility/raster/map_picture.h"
#include "visibility/read_observers.h"
#include "visibility/sky/sun_path.h"

// The module that load_module_function() loads.

extern "C" void alidade_write_image(const alidade::image::Film& film,
                                    const alidade::image::OutputSettings& output,
                                    const alidade::renderer::ImageMetadata& metadata, bool overwrite) {
  alidade::renderer::write_image(film, output, metadata, overwrite);
}

extern "C" void alidade_write_legend(const alidade::image::ColorKey& key, const std::filesystem::path& file,
                                     const std::optional<glm::ivec2>& size, bool overwrite) {
  alidade::image::write_legend(key, file, size, overwrite);
}

extern "C" void alidade_read_sky_image(const std::filesystem::path& file, alidade::image::SkyPixels& pixels) {
  pixels = alidade::image::read_sky_image(file);
}

extern "C" void alidade_place_sun(const alidade::geo::SunByTime& by_time,
                                  const std::optional<alidade::geo::SceneMap>& map,
                                  alidade::geo::PlacedSun& placed, std::string& description) {
  placed = alidade::geo::place_sun(by_time, map);
  description = alidade::geo::describe(by_time, placed);
}

extern "C" void alidade_write_raster(const std::filesystem::path& file,
                                     const alidade::geo::RasterContents& contents, bool overwrite) {
  alidade::geo::write_raster(file, contents, overwrite);
}

extern "C" void alidade_read_observers(const std::filesystem::path& path,
                                       const alidade::geo::ObserverReference& reference,
                                       std::vector<alidade::visibility::GivenObserver>& observers) {
  observers = alidade::visibility::read_observers(path, reference);
}

extern "C" void alidade_transform_observers(const alidade::geo::ObserverReference& reference,
                                            std::vector<alidade::visibility::GivenObserver>& observers) {
  alidade::visibility::to_cloud_reference(observers, "", reference);
}

extern "C" void alidade_read_polygons(const std::filesystem::path& path,
                                      const alidade::geo::ObserverReference& reference,
                                      std::vector<alidade::PlanePolygon>& polygons) {
  polygons = alidade::geo::read_polygons(path, reference);
}

extern "C" void alidade_lon_lat(const alidade::Crs& crs, const std::vector<glm::dvec3>& places,
                                std::optional<std::vector<glm::dvec3>>& answers) {
  answers = alidade::geo::lon_lat(crs, places);
}

extern "C" void alidade_metres_per_unit(const alidade::Crs& crs, std::optional<double>& metres) {
  metres = alidade::geo::metres_per_unit(crs);
}

extern "C" void alidade_write_coverage_picture(const alidade::visibility::Placement& placement,
                                               const std::filesystem::path& file, bool overwrite) {
  alidade::visibility::write_coverage_picture(placement, file, overwrite);
}

extern "C" void alidade_write_map_picture(const alidade::visibility::MapPicture& picture,
                                          const alidade::visibility::Ground& ground,
                                          const std::filesystem::path& file, bool overwrite) {
  alidade::visibility::write_map_picture(picture, ground, file, overwrite);
}

extern "C" void alidade_write_skyline(const alidade::visibility::DepthStrip& strip,
                                      std::span<const alidade::visibility::HorizonDirection> horizon,
                                      const alidade::visibility::SkylineTexts& texts,
                                      const std::filesystem::path& file, bool overwrite) {
  alidade::visibility::write_skyline(strip, horizon, texts, file, overwrite);
}

extern "C" bool alidade_place_schedule(const alidade::Crs& crs, const glm::dvec2& center,
                                       const std::optional<glm::dvec2>& latitude_longitude,
                                       alidade::visibility::SunSchedule& schedule) {
  return alidade::visibility::place_schedule(crs, center, latitude_longitude, schedule);
}

extern "C" void alidade_sun_steps(const alidade::visibility::SunSchedule& schedule,
                                  const alidade::Progress& progress,
                                  std::vector<alidade::visibility::SunStep>& steps) {
  steps = alidade::visibility::sun_steps(schedule, progress);
}

extern "C" void alidade_compare_files(const std::filesystem::path& reference,
                                      const std::filesystem::path& test,
                                      const alidade::compare::ComparisonOptions& options,
                                      const alidade::Progress& progress,
                                      alidade::compare::Comparison& comparison) {
  comparison = alidade::compare::compare_files(reference, test, options, progress);
}

extern "C" void alidade_compare_pairs(const std::vector<alidade::compare::ImagePair>& pairs,
                                      const alidade::compare::BatchOptions& options,
                                      const alidade::Progress& progress,
                                      std::vector<alidade::compare::PairOutcome>& outcomes) {
  outcomes = alidade::compare::compare_pairs(pairs, options, progress);
}

extern "C" void alidade_report_page(const alidade::compare::Comparison& comparison,
                                    const alidade::compare::Verdict& verdict,
                                    alidade::image::PicturePacking packing,
                                    const alidade::compare::Verdict& warnings, std::string& page) {
  page = alidade::compare::report_page(comparison, verdict, packing, warnings);
}

extern "C" void alidade_write_difference(const alidade::compare::DifferenceMap& map,
                                         const std::filesystem::path& file, bool overwrite) {
  alidade::compare::write_difference(map, file, overwrite);
}
