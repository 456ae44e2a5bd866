// SPDX-License-Identifier: MIT
#include "renderer/scene_text.h"

#include <fmt/format.h>

#include <span>

#include "base/fingerprint.h"
#include "renderer/sky_image.h"

// Structs are taken apart by structured bindings: a field that is added to one of them does not compile here
// until it is written too.

namespace alidade {
namespace {

class Text {
 public:
  void add(double number) { add_word(fmt::format("{:.17g}", number)); }
  void add(int number) { add_word(std::to_string(number)); }
  void add(const std::string& text) { add_word(fmt::format("{}:{}", text.size(), text)); }
  void add(const std::filesystem::path& path) { add(path.string()); }
  void add(const Rgb& color) { add_all(double{color.r}, double{color.g}, double{color.b}); }
  void add(const glm::dvec3& place) { add_all(place.x, place.y, place.z); }

  template <class Enum>
  requires std::is_enum_v<Enum>
  void add(Enum value) { add(static_cast<int>(value)); }
  template <class Value>
  void add(const std::optional<Value>& value) {
    if (value)
      add(*value);
    else
      add_word("none");
  }
  template <class Value>
  void add(const std::vector<Value>& values) {
    add(static_cast<int>(values.size()));
    for (const Value& value : values) add(value);
  }
  template <class... Alternatives>
  void add(const std::variant<Alternatives...>& value) {
    add(static_cast<int>(value.index()));
    std::visit([this](const auto& alternative) { this->add(alternative); }, value);
  }

  void add(const Lambertian& material) {
    const auto& [own_albedo] = material;
    add(own_albedo);
  }
  void add(const Metal& material) {
    const auto& [own_albedo, roughness] = material;
    add_all(own_albedo, roughness);
  }
  void add(const Dielectric& material) {
    const auto& [refractive_index] = material;
    add(refractive_index);
  }
  void add(const Emissive& material) {
    const auto& [radiance] = material;
    add(radiance);
  }
  void add(const AdaptedRadius& radius) {
    const auto& [neighbours, factor, max] = radius;
    add_all(neighbours, factor, max);
  }
  void add(const Color16& color) { add_all(int{color.x}, int{color.y}, int{color.z}); }
  void add(const ValueRange& range) {
    const auto& [low, high] = range;
    add_all(low, high);
  }
  void add(const ClassColor& each) {
    const auto& [number, color, name] = each;
    add_all(int{number}, color, name);
  }
  void add(const PointColoring& coloring) {
    const auto& [by, attribute, map, range, percentiles, classes] = coloring;
    add_all(by, attribute, map, range, percentiles, classes);
  }
  void add(const CloudSettings& cloud) {
    const auto& [files, partial, color_depth, radius, adapted_radius, hits, color, material, normals,
                 max_level] = cloud;
    add_all(files, partial, color_depth, radius, adapted_radius, hits, color, material, normals, max_level);
  }
  void add(const Sphere& sphere) {
    const auto& [center, radius, material] = sphere;
    add_all(center, radius, material);
  }
  void add(const GroundPlane& plane) {
    const auto& [height, material] = plane;
    add_all(height, material);
  }
  void add(const ConstantSky& sky) {
    const auto& [radiance] = sky;
    add(radiance);
  }
  void add(const GradientSky& sky) {
    const auto& [horizon, zenith] = sky;
    add_all(horizon, zenith);
  }
  void add(const ImageSky& sky) {
    const auto& [file, scale, rotation, image] = sky;
    add_all(file, scale, rotation);
    if (!image) return;
    const SkyPixels& pixels = image->pixels();
    add_all(pixels.width, pixels.height);
    add_word(fmt::format("{:016x}", checksum(std::as_bytes(std::span(pixels.values)))));
  }
  void add(const Sun& sun) {
    const auto& [azimuth, elevation, irradiance, angular_diameter] = sun;
    add_all(azimuth, elevation, irradiance, angular_diameter);
  }

  std::string take() { return std::move(text_); }

 private:
  template <class... Values>
  void add_all(const Values&... values) {
    (add(values), ...);
  }
  void add_word(const std::string& word) {
    if (!text_.empty()) text_ += ' ';
    text_ += word;
  }

  std::string text_;
};

template <class Part>
std::string written(const Part& part) {
  Text text;
  text.add(part);
  return text.take();
}

}  // namespace

std::string text_of(const CloudSettings& cloud) {
  return written(cloud);
}
std::string text_of(const std::vector<Object>& objects) {
  return written(objects);
}
std::string text_of(const Sky& sky) {
  return written(sky);
}
std::string text_of(const std::optional<Sun>& sun) {
  return written(sun);
}

}  // namespace alidade
