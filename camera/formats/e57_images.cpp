// SPDX-License-Identifier: MIT
#include "camera/formats/e57_images.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "base/error.h"
#include "base/output_file.h"
#include "base/shown_text.h"
#include "base/words.h"
#include "camera/camera_json.h"
#include "camera/formats/e57.h"

namespace alidade::camera {
namespace {

using Json = nlohmann::ordered_json;

/// An image to extract, and the names of the files that are written for it.
struct Extraction {
  std::size_t file = 0;
  E57Blob blob;
  std::optional<E57Blob> mask{};
  std::string image_name, mask_name, camera_name;
  std::string camera;
};

/// Gives names that differ, also on file systems that ignore case.
class Names {
 public:
  std::string unique(const std::string& wanted) {
    // Counts on from the last one of that name: thousands of images may have the same.
    for (std::size_t& count = counts_[lower_case(wanted)];;) {
      const std::string name = ++count == 1 ? wanted : wanted + "_" + std::to_string(count);
      if (taken_.insert(lower_case(name)).second) return name;
    }
  }

 private:
  std::unordered_set<std::string> taken_{"images"};
  std::unordered_map<std::string, std::size_t> counts_;
};

Json pose_json(const std::optional<E57Pose>& pose) {
  if (!pose) return {};
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) {
    rows.push_back(
        {pose->rotation[0][row], pose->rotation[1][row], pose->rotation[2][row], pose->translation[row]});
  }
  rows.push_back({0, 0, 0, 1});
  return rows;
}

const char* note_of(const E57Representation& representation, bool has_camera) {
  if (has_camera) {
    return representation.projection == E57Projection::pinhole
               ? "pinhole: camera axes x right, y up, -z forward"
               : "spherical: camera axes x forward, y left, z up; "
                 "read as equirectangular with its centre forward";
  }
  switch (representation.projection) {
    case E57Projection::visual:
      return "visual reference: an image without a camera";
    case E57Projection::cylindrical:
      return "cylindrical: no lens of camera files; radius, pixel sizes and principal point are those of the "
             "file";
    default:
      return "invalid size or focal length";
  }
}

std::string camera_text(const E57Image& image, const E57Representation& representation,
                        const std::string& file) {
  const std::optional<Camera> camera = camera_of(image, representation);
  if (!camera) return {};
  Json json = Json::parse(camera_json(*camera));
  json["description"] = std::string(name_of(representation.projection)) + " image of " + file +
                        (image.pose ? "" : ", which has no pose: the axes are those of the file");
  return json_text(json, 2) + "\n";
}

/// A name that cannot lead out of its folder, whatever `text` a file contains: a-z, A-Z, 0-9, '-', '_' and
/// '.', "_" for everything else, no '.' in front, 80 bytes at most; "image" if nothing is left.
std::string safe_file_name(const std::string& text) {
  constexpr std::size_t k_longest = 80;
  std::string name;
  for (const char c : text) {
    const bool is_safe = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                         c == '-' || c == '_' || c == '.';
    if (name.size() < k_longest && !(c == '.' && name.empty())) name += is_safe ? c : '_';
  }
  return name.find_first_not_of("_.") == std::string::npos ? "image" : name;
}

class ExtractionPlan {
 public:
  void add(std::size_t file_number, const E57File& file) {
    for (const E57Image& image : file.document().images) {
      const std::string base = safe_file_name(image.name.empty() ? image.guid : image.name);
      for (const E57Representation& representation : image.representations)
        add(file_number, file, image, representation, base);
    }
  }

  const std::vector<Extraction>& extractions() const { return extractions_; }
  std::string table() const { return json_text(table_, 2) + "\n"; }

 private:
  void add(std::size_t file_number, const E57File& file, const E57Image& image,
           const E57Representation& representation, const std::string& base) {
    const bool is_second =
        representation.projection == E57Projection::visual && image.representations.size() > 1;
    const std::string name = names_.unique(is_second ? base + "_visual" : base);
    Extraction extraction{.file = file_number,
                          .blob = representation.blob,
                          .mask = representation.mask,
                          .image_name = name + "." + representation.extension,
                          .mask_name = representation.mask ? names_.unique(name + "_mask") + ".png" : "",
                          .camera_name = "",
                          .camera = camera_text(image, representation, file.pages().name())};
    if (!extraction.camera.empty()) extraction.camera_name = name + ".json";
    table_.push_back({{"file", extraction.image_name},
                      {"mask", representation.mask ? Json(extraction.mask_name) : Json()},
                      {"camera", extraction.camera.empty() ? Json() : Json(extraction.camera_name)},
                      {"note", note_of(representation, !extraction.camera.empty())},
                      {"source", file.pages().name()},
                      {"name", image.name},
                      {"guid", image.guid},
                      {"scan_guid", image.scan_guid},
                      {"projection", name_of(representation.projection)},
                      {"width", representation.width},
                      {"height", representation.height},
                      {"focal_length", representation.focal_length},
                      {"pixel_width", representation.pixel_width},
                      {"pixel_height", representation.pixel_height},
                      {"principal_point", {representation.principal_x, representation.principal_y}},
                      {"radius", representation.radius},
                      {"pose", pose_json(image.pose)}});
    extractions_.push_back(std::move(extraction));
  }

  Names names_;
  std::vector<Extraction> extractions_;
  Json table_ = Json::array();
};

void write_blob(const std::filesystem::path& path, E57File& file, const E57Blob& blob, bool overwrite) {
  OutputFile output(path, overwrite);
  file.read_blob(blob, [&](std::span<const std::byte> bytes) { output.write(bytes); });
  output.commit();
}

}  // namespace

void extract_images(std::vector<E57File>& files, const std::filesystem::path& folder, bool overwrite) {
  ExtractionPlan plan;
  for (std::size_t i = 0; i < files.size(); ++i) plan.add(i, files[i]);
  if (plan.extractions().empty()) {
    throw file_error(files.empty() ? "" : files.front().pages().name(), "no images to extract",
                     "an E57 file with images");
  }
  std::filesystem::create_directories(folder);
  for (const Extraction& extraction : plan.extractions()) {
    for (const std::string& name : {extraction.image_name, extraction.mask_name, extraction.camera_name})
      if (!name.empty()) check_output(folder / name, overwrite);
  }
  check_output(folder / "images.json", overwrite);
  for (const Extraction& extraction : plan.extractions()) {
    E57File& source = files[extraction.file];
    write_blob(folder / extraction.image_name, source, extraction.blob, overwrite);
    if (extraction.mask) write_blob(folder / extraction.mask_name, source, *extraction.mask, overwrite);
    if (!extraction.camera.empty())
      write_text_file(folder / extraction.camera_name, extraction.camera, overwrite);
  }
  write_text_file(folder / "images.json", plan.table(), overwrite);
}

}  // namespace alidade::camera
