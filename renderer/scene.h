// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/date_time.h"
#include "camera/lens.h"
#include "cloud/read_cloud.h"
#include "image/point_color.h"
#include "renderer/material.h"

// A scene as plain data: what a scene file says, with defaults filled in and paths made absolute or relative
// to the working directory. World coordinates are double, z up, in the unit of the cloud's CRS (metres unless
// the file says otherwise).

namespace alidade {

/// How a ray meets the sphere around a point.
enum class HitMode {
  entry,  ///< the sphere entered first: what one sees
  t,      ///< the point projected first, the paper's naive way: can show a sphere behind another one
};

/// Which way the surface of a cloud faces where a ray meets a point.
enum class NormalMode {
  sphere,  ///< outward from the point: exact spheres
  smooth,  ///< across the plane of the points around: even walls instead of bumps, where the points form a
           ///< surface
};

/// Radii that follow the density of the points: of each point, factor times the distance to its n-th nearest
/// neighbour (octree/spacing.h), at most max. On a surface with so many points per square metre the
/// eighth neighbour is 1.6 / sqrt(density) away; spheres of three quarters of that leave 1 % of it open.
struct AdaptedRadius {
  int neighbours = 8;           ///< 1 to 64
  double factor = 0.75;         ///< above 0
  std::optional<double> max{};  ///< metres; empty: four times the radius that "auto" would be
};

/// More levels than any octree has: all of them.
inline constexpr int k_max_level = 255;

/// The scanned part of a scene.
struct CloudSettings {
  std::vector<std::filesystem::path> files;  ///< and folders and patterns (cloud/cloud_inputs.h)
  bool partial = false;                      ///< ReadOptions::partial
  ColorDepth color_depth = ColorDepth::automatic;
  std::optional<double> radius;  ///< of the spheres, metres; empty = "auto", from the measured spacing
  std::optional<AdaptedRadius> adapted_radius;  ///< takes the place of radius
  HitMode hits = HitMode::entry;
  PointColoring color;
  Material material = Lambertian{};
  NormalMode normals = NormalMode::sphere;  ///< glass points are always spheres
  /// Only the levels 0 to max_level of an index file of organisation layered: a thinned cloud, for previews.
  int max_level = k_max_level;
};

struct Sphere {
  glm::dvec3 center{0.0};
  double radius = 1.0;
  Material material = Lambertian{Rgb(0.5f)};
};

/// The plane z = height, everywhere.
struct GroundPlane {
  double height = 0.0;
  Material material = Lambertian{Rgb(0.5f)};
};

using Object = std::variant<Sphere, GroundPlane>;

/// Sky of one radiance.
struct ConstantSky {
  Rgb radiance{0.0f};
};

/// Sky that changes from horizon to zenith with the sine of the elevation; below the horizon as at the
/// horizon.
struct GradientSky {
  Rgb horizon{1.0f, 1.0f, 1.0f};
  Rgb zenith{0.5f, 0.7f, 1.0f};
};

class SkyImage;

/// Sky from a picture of everything around, laid out like a panorama: its middle column looks north if it is
/// not turned (renderer/sky.h).
struct ImageSky {
  std::filesystem::path file;
  double scale = 1.0;     ///< radiance is the picture's values times this, [0, 1e9]
  double rotation = 0.0;  ///< degrees clockwise from north: where the middle column looks, [-360, 360]
  std::shared_ptr<const SkyImage> image;  ///< what was read from the file; nothing is rendered without it
};

using Sky = std::variant<ConstantSky, GradientSky, ImageSky>;

/// The sun: a disc of even radiance, infinitely far away.
struct Sun {
  double azimuth = 135.0;            ///< degrees, clockwise from north (+y), so 90 is east (+x)
  double elevation = 40.0;           ///< degrees above the horizon, (-90, 90]
  Rgb irradiance{3.0f, 2.9f, 2.7f};  ///< on a surface that faces it
  double angular_diameter = 0.53;    ///< degrees, [0, 180); 0 = parallel light
};

/// A sun that stands where date and place say. place_sun() (geo/sun.h) makes a Sun of it, once the
/// cloud is known.
struct SunByTime {
  Moment moment;
  std::optional<double> latitude{}, longitude{};  ///< degrees; both or none: those of the cloud
  double height = 0.0;                            ///< metres above the sea, [-1000, 100000]
  double pressure = 1013.25;                      ///< of the air there, hPa = mbar, [0, 2000]
  double temperature = 10.0;                      ///< of the air there, degrees Celsius, [-150, 100]
  std::optional<Rgb> irradiance{};                ///< empty = that of a clear sky, by elevation
  double angular_diameter = 0.53;                 ///< as Sun's
};

/// Where the optical axis of a camera points and which axes its own frame has.
enum class AxisConvention {
  opencv,  ///< +x right, +y down, +z forward
  opengl,  ///< +x right, +y up, +z backward
};

/// Camera frame -> world, right-handed, rotation orthonormal: columns right, down, forward (opencv), then the
/// place.
struct CameraPose {
  glm::dvec3 position{0.0};
  glm::dvec3 right{1.0, 0.0, 0.0};
  glm::dvec3 down{0.0, 0.0, -1.0};
  glm::dvec3 forward{0.0, 1.0, 0.0};
};

/// A camera. Pixel (0,0) is top left, its centre at (0.5, 0.5). The lens brings a direction to a film place
/// (x, y), which is pixel place (cx + fx x, cy + fy y); see camera/lens.h.
struct Camera {
  int width = 600, height = 400;
  double fx = 0.0, fy = 0.0;  ///< focal lengths in pixels; orthographic: pixels per metre; equirectangular:
                              ///< pixels per radian
  double cx = 0.0, cy = 0.0;  ///< where the axis meets the film, pixels
  CameraPose pose;
  Lens lens = PinholeLens{};
};

// Largest values that scene files and command lines may ask for, inclusive.

inline constexpr int k_max_samples = 1 << 24;            ///< paths per pixel
inline constexpr int k_max_bounces = 1000;               ///< path vertices after the first
inline constexpr int k_max_image_side = 1 << 16;         ///< pixels
inline constexpr std::uint64_t k_max_pixels = 1u << 28;  ///< width times height

/// What a picture shows.
enum class RenderMode {
  path,               ///< light of sun, sky and lamps, scattered from surface to surface
  ambient_occlusion,  ///< colours, darkened where other surfaces are near; no light is needed
  headlight,          ///< colours lit from the camera, without shadows
  flat,               ///< the colours themselves
};

/// A mode and the word for it in scene files and on command lines.
struct NamedMode {
  std::string_view name;
  RenderMode mode;
};

/// Every mode, in the order of the enum.
inline constexpr std::array<NamedMode, 4> k_modes = {{{"path", RenderMode::path},
                                                      {"ambient_occlusion", RenderMode::ambient_occlusion},
                                                      {"headlight", RenderMode::headlight},
                                                      {"flat", RenderMode::flat}}};

struct RenderSettings {
  int samples = 50;     ///< paths per pixel, 1 .. k_max_samples
  int max_bounces = 8;  ///< path vertices after the first, 0 .. k_max_bounces
  std::uint64_t seed = 1;
  RenderMode mode = RenderMode::path;
  std::optional<double> ao_distance{};  ///< metres that count as near; empty = ambient_occlusion_distance()
};

/// One group of image channels.
enum class Layer { color, depth, distance, normal, position, albedo, id, variance };

/// A layer and the word for it in scene files and on command lines.
struct NamedLayer {
  std::string_view name;
  Layer layer;
};

/// Every layer, in the order of the enum.
inline constexpr std::array<NamedLayer, 8> k_layers = {{{"color", Layer::color},
                                                        {"depth", Layer::depth},
                                                        {"distance", Layer::distance},
                                                        {"normal", Layer::normal},
                                                        {"position", Layer::position},
                                                        {"albedo", Layer::albedo},
                                                        {"id", Layer::id},
                                                        {"variance", Layer::variance}}};

struct OutputSettings {
  std::filesystem::path file;               ///< .exr, .png, .jpg, .tif; may be empty in a scene file
  std::vector<Layer> layers{Layer::color};  ///< EXR only
  double exposure = 0.0;                    ///< stops: PNG, JPEG and GeoTIFF show color * 2^exposure, sRGB
  bool half = true;  ///< EXR: colour, normal and albedo as half; all others are always float or uint
};

struct Scene {
  std::optional<CloudSettings> cloud;
  std::vector<Object> objects;
  Sky sky = GradientSky{};
  std::optional<Sun> sun;
  std::optional<SunByTime> sun_by_time;  ///< stands in for `sun`, which is made of it before rendering
  std::string sun_origin;                ///< how `sun` was made, for the metadata of pictures
  std::optional<Camera> camera;          ///< empty = a view is chosen that shows the whole cloud
  RenderSettings render;
  OutputSettings output;
};

}  // namespace alidade
