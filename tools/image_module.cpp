// SPDX-License-Identifier: MIT
#include "compare/batch.h"
#include "compare/report/page.h"
#include "geo/earth.h"
#include "geo/raster_file.h"
#include "geo/read_polygons.h"
#include "geo/sun.h"
#include "image/read_picture.h"
#include "tools/image_module.h"
#include "visibility/horizon/skyline.h"
#include "visibility/points/placement.h"
#include "visibility/raster/map_picture.h"
#include "visibility/read_observers.h"
#include "visibility/sky/sun_path.h"

// The module that load_module_function() loads.

extern "C" void alidade_write_image(const alidade::Film& film, const alidade::OutputSettings& output,
                                    const alidade::ImageMetadata& metadata, bool overwrite) {
  alidade::write_image(film, output, metadata, overwrite);
}

extern "C" void alidade_write_legend(const alidade::ColorKey& key, const std::filesystem::path& file,
                                     const std::optional<glm::ivec2>& size, bool overwrite) {
  alidade::write_legend(key, file, size, overwrite);
}

extern "C" void alidade_read_sky_image(const std::filesystem::path& file, alidade::SkyPixels& pixels) {
  pixels = alidade::read_sky_image(file);
}

extern "C" void alidade_place_sun(const alidade::SunByTime& by_time,
                                  const std::optional<alidade::SceneMap>& map, alidade::PlacedSun& placed,
                                  std::string& description) {
  placed = alidade::place_sun(by_time, map);
  description = alidade::describe(by_time, placed);
}

extern "C" void alidade_write_raster(const std::filesystem::path& file,
                                     const alidade::RasterContents& contents, bool overwrite) {
  alidade::write_raster(file, contents, overwrite);
}

extern "C" void alidade_read_observers(const std::filesystem::path& path,
                                       const alidade::ObserverReference& reference,
                                       std::vector<alidade::GivenObserver>& observers) {
  observers = alidade::read_observers(path, reference);
}

extern "C" void alidade_transform_observers(const alidade::ObserverReference& reference,
                                            std::vector<alidade::GivenObserver>& observers) {
  alidade::to_cloud_reference(observers, "", reference);
}

extern "C" void alidade_read_polygons(const std::filesystem::path& path,
                                      const alidade::ObserverReference& reference,
                                      std::vector<alidade::PlanePolygon>& polygons) {
  polygons = alidade::read_polygons(path, reference);
}

extern "C" void alidade_lon_lat(const alidade::Crs& crs, const std::vector<glm::dvec3>& places,
                                std::optional<std::vector<glm::dvec3>>& answers) {
  answers = alidade::lon_lat(crs, places);
}

extern "C" void alidade_metres_per_unit(const alidade::Crs& crs, std::optional<double>& metres) {
  metres = alidade::metres_per_unit(crs);
}

extern "C" void alidade_write_coverage_picture(const alidade::Placement& placement,
                                               const std::filesystem::path& file, bool overwrite) {
  alidade::write_coverage_picture(placement, file, overwrite);
}

extern "C" void alidade_write_map_picture(const alidade::MapPicture& picture, const alidade::Ground& ground,
                                          const std::filesystem::path& file, bool overwrite) {
  alidade::write_map_picture(picture, ground, file, overwrite);
}

extern "C" void alidade_write_skyline(const alidade::DepthStrip& strip,
                                      std::span<const alidade::HorizonDirection> horizon,
                                      const alidade::SkylineTexts& texts, const std::filesystem::path& file,
                                      bool overwrite) {
  alidade::write_skyline(strip, horizon, texts, file, overwrite);
}

extern "C" bool alidade_place_schedule(const alidade::Crs& crs, const glm::dvec2& center,
                                       const std::optional<glm::dvec2>& latitude_longitude,
                                       alidade::SunSchedule& schedule) {
  return alidade::place_schedule(crs, center, latitude_longitude, schedule);
}

extern "C" void alidade_sun_steps(const alidade::SunSchedule& schedule, const alidade::Progress& progress,
                                  std::vector<alidade::SunStep>& steps) {
  steps = alidade::sun_steps(schedule, progress);
}

extern "C" void alidade_compare_files(const std::filesystem::path& reference,
                                      const std::filesystem::path& test,
                                      const alidade::ComparisonOptions& options,
                                      const alidade::Progress& progress, alidade::Comparison& comparison) {
  comparison = alidade::compare_files(reference, test, options, progress);
}

extern "C" void alidade_compare_pairs(const std::vector<alidade::ImagePair>& pairs,
                                      const alidade::BatchOptions& options, const alidade::Progress& progress,
                                      std::vector<alidade::PairOutcome>& outcomes) {
  outcomes = alidade::compare_pairs(pairs, options, progress);
}

extern "C" void alidade_report_page(const alidade::Comparison& comparison, const alidade::Verdict& verdict,
                                    alidade::PicturePacking packing, const alidade::Verdict& warnings,
                                    std::string& page) {
  page = alidade::report_page(comparison, verdict, packing, warnings);
}

extern "C" void alidade_write_difference(const alidade::DifferenceMap& map, const std::filesystem::path& file,
                                         bool overwrite) {
  alidade::write_difference(map, file, overwrite);
}
