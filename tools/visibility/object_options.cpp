// SPDX-License-Identifier: MIT
#include "tools/visibility/object_options.h"

#include <fmt/format.h>

#include "tools/console.h"
#include "tools/image_module.h"

namespace alidade::tools {

std::string ObjectOptions::given() const {
  if (!segments.empty()) return "--object";
  if (!file.empty()) return "--objects";
  if (!reference.empty()) return "--objects-crs";
  if (spacing) return "--object-spacing";
  return width ? "--object-width" : "";
}

void add_object_options(const Options& command, ObjectOptions& options) {
  const Options group = command.group("Objects");
  group.values(
      "--object", "X,Y,Z0,Z1",
      "instead of observers: how much of a vertical object (mast, wind turbine) from height Z0 to Z1 is "
      "visible from each cell. May be repeated",
      [&options](const std::string& text) { options.segments.push_back(visibility::parse_object(text)); });
  group.file(
      "--objects", "FILE",
      "objects from a file: points (vertical objects), lines (walls) and polygons (outer walls of "
      "buildings) of GeoJSON, GeoPackage or Shapefile with the attribute height and optionally z (of the "
      "foot) and name; or CSV with the header x,y[,z],height[,name]",
      options.file);
  group.text(
      "--objects-crs", "SYSTEM|cloud",
      "reference system of the objects, such as EPSG:4326 (x is east), overriding their file; cloud: the "
      "cloud's (default: the file's, for CSV and --object the cloud's)",
      options.reference);
  group.number("--object-spacing", "LENGTH",
               "distance of the samples on an object, vertical and along walls (default: 1)", options.spacing,
               1e-3, 1e9);
  group.number("--object-width", "LENGTH",
               "width of vertical objects, which --mode solid-angle requires (default: 0)", options.width,
               0.0, 1e6);
}

visibility::SampledObjects load_objects(const ObjectOptions& options, double max_distance, const Crs& crs,
                                        const visibility::GroundHeight& ground, Verbosity verbosity) {
  const geo::ObserverReference reference{
      .given = options.reference, .cloud = crs, .option = "--objects-crs", .whose = "objects"};
  visibility::GivenObjects given;
  if (!options.file.empty()) given = image_module().read_objects(options.file, reference);
  visibility::GivenObjects all;
  std::vector<visibility::GivenObserver> segments = options.segments;
  if (!options.reference.empty() && !segments.empty())
    image_module().to_cloud_reference(segments, "", reference);
  for (const visibility::GivenObserver& segment : segments) all.add_segment(segment);
  const std::size_t objects = all.count(), corners = all.corners.size();
  for (visibility::ObjectPart part : given.parts) {
    part.object += objects;
    part.begin += corners;
    part.end += corners;
    all.parts.push_back(part);
  }
  all.corners.insert(all.corners.end(), given.corners.begin(), given.corners.end());
  visibility::SampleOptions sampling{.max_distance = max_distance};
  sampling.spacing = options.spacing.value_or(sampling.spacing);
  sampling.width = options.width.value_or(sampling.width);
  visibility::SampledObjects sampled = visibility::sample_objects(all, sampling, ground);
  say_note(verbosity,
           fmt::format("{} object{} with {} samples, at most {:g} apart", sampled.objects.size(),
                       sampled.objects.size() == 1 ? "" : "s", sampled.samples.size(), sampling.spacing));
  return sampled;
}

}  // namespace alidade::tools
