// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/surfaces.h"
#include "camera/camera.h"
#include "cloud/read_cloud.h"
#include "geo/sun.h"
#include "image/output_settings.h"
#include "image/point_color.h"
#include "mesh/triangle_mesh.h"
#include "renderer/material.h"

// A scene as plain data: the contents of a scene file, with defaults filled in and paths made absolute or
// relative to the working directory. World coordinates are double, z up, in the unit of the cloud's CRS
// (metres unless the file has another).

namespace alidade::renderer {

/// How a ray meets the sphere around a point.
enum class HitMode {
  entry,  ///< the sphere entered first: what one sees
  t,      ///< the point projected first, the paper's naive way: can show a sphere behind another one
};

/// Which way the surface of a cloud faces where a ray meets a point.
enum class NormalMode {
  sphere,  ///< outward from the point: exact spheres
  smooth,  ///< across the plane of the points around, where they form one: even walls instead of bumps
};

/// What a point is to a ray.
enum class PointShape {
  sphere,  ///< the sphere around it: the paper's way
  disc,    ///< the disc of its sheet (surface/point_disc.h), or a small sphere where it has no sheet
  blend,   ///< a disc, with position, normal and colour blended over the discs of one sheet
};

/// Radii that follow the density of the points: of each point, factor times the distance to its n-th nearest
/// neighbour (octree/spacing.h), at most max. On a surface with so many points per square metre the
/// eighth neighbour is 1.6 / sqrt(density) away; spheres of three quarters of that leave 1 % of it open.
struct AdaptedRadius {
  int neighbours = 8;              ///< 1 to 64
  std::optional<double> factor{};  ///< above 0; empty: 0.75 for spheres, 0.92 for discs
  std::optional<double> max{};     ///< metres; empty: four times the radius that "auto" would be
};

/// More levels than any octree has: all of them.
inline constexpr int k_max_level = 255;

/// The scanned part of a scene.
struct CloudSettings {
  std::vector<std::filesystem::path> files;  ///< and folders and patterns (cloud/cloud_inputs.h)
  bool partial = false;                      ///< ReadOptions::partial
  ColorDepth color_depth = ColorDepth::automatic;
  std::optional<double> radius;  ///< of the spheres, metres; empty = "auto", from the measured spacing
  std::optional<AdaptedRadius> adapted_radius;  ///< replaces radius
  HitMode hits = HitMode::entry;
  image::PointColoring color;
  Material material = Lambertian{};
  NormalMode normals = NormalMode::sphere;  ///< of spheres; glass points are always spheres
  PointShape shape = PointShape::sphere;
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

/// A mesh in a file, and where it is placed.
struct MeshFile {
  std::filesystem::path file;
  MeshPlacement placement;
};

/// Surfaces that are not the scene's to describe, as part of it: a mesh, or the exact site behind a simulated
/// scan.
struct Model {
  /// Not null when rendered; those of a mesh are null until its file is read (mesh/triangle_mesh.h) and made
  /// a TriangleTree (mesh/triangle_tree.h).
  std::shared_ptr<const Surfaces> surfaces;
  /// Of the surfaces, for metadata and checkpoints: equal names mean equal surfaces.
  std::string name{};
  Material material = Lambertian{};  ///< lambertian or metal
  std::optional<MeshFile> mesh{};    ///< empty: surfaces of another kind
};

using Object = std::variant<Sphere, GroundPlane, Model>;

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

/// Sky from an image of everything around, laid out like a panorama: its middle column is north if it is
/// not turned (renderer/sky.h).
struct ImageSky {
  std::filesystem::path file;
  double scale = 1.0;     ///< radiance is the image's values times this, [0, 1e9]
  double rotation = 0.0;  ///< degrees clockwise from north: azimuth of the middle column, [-360, 360]
  std::shared_ptr<const SkyImage> image;  ///< what was read from the file; nothing is rendered without it
};

using Sky = std::variant<ConstantSky, GradientSky, ImageSky>;

// Largest values that scene files and command lines may have, inclusive.

inline constexpr int k_max_samples = 1 << 24;  ///< paths per pixel
inline constexpr int k_max_bounces = 1000;     ///< path vertices after the first

/// What an image shows.
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

struct Scene {
  std::optional<CloudSettings> cloud;
  std::vector<Object> objects;
  Sky sky = GradientSky{};
  std::optional<geo::Sun> sun;
  std::optional<geo::SunByTime> sun_by_time;  ///< replaces `sun`, which is made of it before rendering
  std::string sun_origin;                     ///< how `sun` was made, for the metadata of images
  std::optional<camera::Camera> camera;       ///< empty = a view is chosen that shows the whole cloud
  RenderSettings render;
  image::OutputSettings output;
};

}  // namespace alidade::renderer
