// SPDX-License-Identifier: MIT
#include "renderer/merge_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <sstream>
#include <string_view>
#include <vector>

#include "camera/camera_json.h"

namespace alidade::renderer {
namespace {

constexpr std::string_view k_kind = "kind of image", k_layers = "layers", k_exposure = "exposure",
                           k_sky = "sky of the image", k_half = "half floats", k_crs_keys = "keys of the CRS",
                           k_crs_doubles = "numbers of the CRS", k_crs_text = "text of the CRS",
                           k_metadata = "metadata ";
constexpr std::string_view k_exr = "EXR", k_display = "PNG, JPEG or GeoTIFF";

std::string_view kind_of(const std::filesystem::path& image) {
  return image::image_format(image) == image::ImageFormat::exr ? k_exr : k_display;
}

/// Numbers between blanks. Errors: other text.
template <class Number>
std::vector<Number> numbers_of(const std::string& text, const std::string& file, std::string_view what) {
  std::vector<Number> numbers;
  const char *at = text.data(), *const end = at + text.size();
  while (at != end) {
    if (*at == ' ') {
      ++at;
      continue;
    }
    Number number{};
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc()) throw file_error(file, fmt::format("corrupt part: invalid {}", what));
    numbers.push_back(number);
    at = next;
  }
  return numbers;
}

/// The entries that image_entries() made.
class ImageEntries {
 public:
  ImageEntries(const Fingerprint& fingerprint, std::string file)
      : fingerprint_(fingerprint), file_(std::move(file)) {}

  const std::string& value(std::string_view name) const {
    const auto entry = std::ranges::find(fingerprint_, name, &FingerprintEntry::name);
    if (entry == fingerprint_.end())
      throw file_error(file_, fmt::format("corrupt part: {} is missing", name));
    return entry->value;
  }

  std::vector<std::pair<std::string, std::string>> texts() const {
    std::vector<std::pair<std::string, std::string>> texts;
    for (const auto& [name, value] : fingerprint_)
      if (name.starts_with(k_metadata)) texts.emplace_back(name.substr(k_metadata.size()), value);
    return texts;
  }

  std::vector<image::Layer> layers() const {
    std::vector<image::Layer> layers;
    std::istringstream words(value(k_layers));
    for (std::string word; words >> word;) {
      const auto known = std::ranges::find(image::k_layers, word, &image::NamedLayer::name);
      if (known == image::k_layers.end()) throw file_error(file_, "corrupt part: unknown layer", "", word);
      layers.push_back(known->layer);
    }
    return layers;
  }

  /// The colour in sky_text(), if there is one.
  std::optional<Rgb> background() const {
    const std::string& text = value(k_sky);
    if (text == "shown" || text == "transparent") return std::nullopt;
    const std::vector<double> color = numbers_of<double>(text, file_, k_sky);
    if (color.size() != 3) throw file_error(file_, "corrupt part: invalid sky of the image");
    return Rgb(color[0], color[1], color[2]);
  }

  image::OutputSettings output(const std::filesystem::path& image) const {
    const std::vector<double> exposure = numbers_of<double>(value(k_exposure), file_, k_exposure);
    if (exposure.size() != 1) throw file_error(file_, "corrupt part: invalid exposure");
    return {.file = image,
            .layers = layers(),
            .exposure = exposure[0],
            .transparent = value(k_sky) == "transparent",
            .background = background(),
            .half = value(k_half) == "1"};
  }

  camera::Camera camera() const {
    camera::Camera camera =
        camera::parse_camera(value(fmt::format("{}alidade:camera_json", k_metadata)), file_);
    camera::check_camera(camera);
    return camera;
  }

  Crs crs() const {
    const auto wkt =
        std::ranges::find(fingerprint_, fmt::format("{}alidade:crs", k_metadata), &FingerprintEntry::name);
    return {.wkt = wkt == fingerprint_.end() ? "" : wkt->value,
            .geotiff_keys = numbers_of<std::uint16_t>(value(k_crs_keys), file_, k_crs_keys),
            .geotiff_doubles = numbers_of<double>(value(k_crs_doubles), file_, k_crs_doubles),
            .geotiff_ascii = value(k_crs_text)};
  }

 private:
  const Fingerprint& fingerprint_;
  std::string file_;
};

/// Errors: the file is a checkpoint of a render under way.
void check_finished(const PartHead& head) {
  if (std::ranges::find(head.fingerprint, k_kind, &FingerprintEntry::name) != head.fingerprint.end()) return;
  throw file_error(head.file, "a checkpoint of an unfinished render",
                   "a finished part: resume the render with the same command and --resume");
}

/// Errors: the two are not of the same image.
void check_same(const PartHead& head, const PartHead& first) {
  if (head.part.count != first.part.count) {
    throw file_error(head.file, "this part belongs to another division of the image",
                     fmt::format("one of {} parts, as {}", first.part.count, first.file),
                     fmt::format("part {}", part_text(head.part)));
  }
  check_fingerprint(head.fingerprint, first.fingerprint, head.file,
                    {.file = "part", .other = first.file, .remedy = " for every part"});
  if (head.width != first.width || head.height != first.height || head.samples != first.samples ||
      head.with_noise != first.with_noise)
    throw file_error(head.file, "corrupt part: its sizes contradict its fingerprint");
}

/// "2, 5, 7 to 9".
std::string ranges_text(const std::vector<int>& numbers) {
  constexpr std::size_t k_most = 10;
  std::vector<std::string> ranges;
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    ranges.push_back(last == i
                         ? fmt::format("{}", numbers[i])
                         : fmt::format("{}{}{}", numbers[i], last == i + 1 ? ", " : " to ", numbers[last]));
    i = last + 1;
  }
  const bool is_long = ranges.size() > k_most;
  if (is_long) ranges.resize(k_most);
  return fmt::format("{}{}", fmt::join(ranges, ", "), is_long ? ", ..." : "");
}

/// The heads by number, each once. Errors: those of check_parts().
std::map<int, PartHead> checked_parts(std::span<const std::filesystem::path> files,
                                      const std::filesystem::path& image) {
  std::map<int, PartHead> parts;
  std::optional<PartHead> first;
  for (const std::filesystem::path& file : files) {
    PartHead head = read_part_head(file);
    check_finished(head);
    if (!first) first = head;
    check_same(head, *first);
    const auto [earlier, is_new] = parts.emplace(head.part.number, head);
    if (!is_new && earlier->second.rest_checksum != head.rest_checksum) {
      throw file_error(
          head.file,
          fmt::format("part {} is also {}, with other samples", part_text(head.part), earlier->second.file),
          "every part once");
    }
  }
  if (!first) throw input_error("no parts to merge", "the files of all parts");
  std::vector<int> missing;
  for (int number = 1; number <= first->part.count; ++number)
    if (!parts.contains(number)) missing.push_back(number);
  if (!missing.empty()) {
    throw input_error(fmt::format("missing part{} {} of {}", missing.size() == 1 ? "" : "s",
                                  ranges_text(missing), first->part.count),
                      "the files of all parts", std::to_string(parts.size()));
  }
  const std::string& kind = ImageEntries(first->fingerprint, first->file).value(k_kind);
  if (!image.empty() && kind != kind_of(image))
    throw file_error(image, fmt::format("the parts were rendered for {}", kind),
                     kind == k_exr ? "the extension .exr" : "the extension .png, .jpg or .tif");
  return parts;
}

/// Errors: the files have fewer bytes than the image, for which memory is taken next.
void check_bytes(const std::map<int, PartHead>& parts) {
  const PartHead& first = parts.begin()->second;
  constexpr std::uint64_t k_least = sizeof(glm::dvec3) + 4, k_noise = 2 * sizeof(glm::vec3);
  const std::uint64_t expected = std::uint64_t{static_cast<std::uint32_t>(first.width)} *
                                 static_cast<std::uint32_t>(first.height) *
                                 (k_least + (first.with_noise ? k_noise : 0));
  std::uint64_t found = 0;
  for (const auto& [number, head] : parts) found += head.file_bytes - head.head_bytes;
  if (found >= expected) return;
  throw file_error(first.file, "corrupt part: the parts have fewer bytes than the image",
                   fmt::format("at least {}", expected), std::to_string(found));
}

/// What is behind the surfaces: the sky, nothing, or a colour.
std::string sky_text(const image::OutputSettings& output) {
  if (output.transparent) return "transparent";
  if (!output.background) return "shown";
  const Rgb& color = *output.background;
  return fmt::format("{:.9g} {:.9g} {:.9g}", color.r, color.g, color.b);
}

}  // namespace

Fingerprint image_entries(const image::OutputSettings& output, const ImageMetadata& metadata) {
  std::string layers;
  if (kind_of(output.file) == k_exr) {
    for (const image::Layer layer : output.layers)
      layers +=
          (layers.empty() ? "" : " ") + std::string(image::k_layers[static_cast<std::size_t>(layer)].name);
  } else {
    layers = "color";
  }
  std::vector<std::string> doubles;
  for (const double number : metadata.crs.geotiff_doubles) doubles.push_back(fmt::format("{:.17g}", number));
  Fingerprint entries{{std::string(k_kind), std::string(kind_of(output.file))},
                      {std::string(k_layers), layers},
                      {std::string(k_exposure), fmt::format("{:.17g}", output.exposure)},
                      {std::string(k_sky), sky_text(output)},
                      {std::string(k_half), output.half ? "1" : "0"},
                      {std::string(k_crs_keys), fmt::format("{}", fmt::join(metadata.crs.geotiff_keys, " "))},
                      {std::string(k_crs_doubles), fmt::format("{}", fmt::join(doubles, " "))},
                      {std::string(k_crs_text), metadata.crs.geotiff_ascii}};
  for (auto& [key, text] : metadata_texts(metadata)) entries.push_back({std::string(k_metadata) + key, text});
  return entries;
}

void check_parts(std::span<const std::filesystem::path> files, const std::filesystem::path& image) {
  checked_parts(files, image);
}

MergedImage merge_parts(std::span<const std::filesystem::path> files, const std::filesystem::path& image) {
  const std::map<int, PartHead> parts = checked_parts(files, image);
  const PartHead& first = parts.begin()->second;
  const ImageEntries entries(first.fingerprint, first.file);
  const camera::Camera camera = entries.camera();
  MergedImage merged;
  merged.output = entries.output(image);
  merged.parts = static_cast<int>(parts.size());
  const std::vector<image::Layer>& layers = merged.output.layers;
  const bool with_variance = std::ranges::find(layers, image::Layer::variance) != layers.end();
  if (camera.width != first.width || camera.height != first.height || with_variance != first.with_noise)
    throw file_error(first.file, "corrupt part: its sizes contradict its fingerprint");
  check_bytes(parts);

  merged.facts = {.texts = entries.texts(), .position_offset = position_offset(camera), .crs = entries.crs()};
  if (image::image_format(image) == image::ImageFormat::geotiff)
    merged.facts.ground = camera::ground_transform(camera);
  std::vector<image::Layer> of_centers = layers;
  std::erase_if(of_centers, [](image::Layer layer) {
    return layer == image::Layer::color || layer == image::Layer::variance;
  });
  merged.film = image::Film(first.width, first.height, of_centers);
  ImageState state(first.width, first.height, first.with_noise);
  for (const auto& [number, head] : parts) {
    read_part(head, state, merged.film);
    merged.samples_taken += head.samples_taken;
  }
  move_into_film(state, with_variance, merged.film);
  return merged;
}

}  // namespace alidade::renderer
