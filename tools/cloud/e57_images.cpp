// SPDX-License-Identifier: MIT
#include "tools/cloud/e57_images.h"

#include <fmt/format.h>
#include <unordered_map>
#include <unordered_set>

#include "base/output_file.h"
#include "base/shown_text.h"
#include "base/words.h"
#include "camera/camera_json.h"
#include "camera/formats/e57.h"

namespace alidade::tools {
namespace {

using Json = nlohmann::ordered_json;

Json position_json(const std::optional<E57Pose>& pose) {
  if (!pose) return {};
  return {pose->translation.x, pose->translation.y, pose->translation.z};
}

std::string position_text(const std::optional<E57Pose>& pose) {
  if (!pose) return "no pose";
  return fmt::format("at {} {} {}", pose->translation.x, pose->translation.y, pose->translation.z);
}

std::string representation_text(const E57Representation& representation) {
  return fmt::format("{} {} {}x{}{}", name_of(representation.projection), representation.extension,
                     representation.width, representation.height, representation.mask ? " with mask" : "");
}

std::string named(const char* kind, std::size_t number, const std::string& name) {
  return name.empty() ? fmt::format("{} {}", kind, number) : fmt::format("{} {} '{}'", kind, number, name);
}

template <class Item, class Describe>
void print_each(const std::vector<Item>& items, const char* kind, Verbosity verbosity,
                const Describe& describe, std::vector<std::string>& lines) {
  constexpr std::size_t k_first = 10;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i == k_first && verbosity != Verbosity::verbose) {
      lines.push_back(fmt::format("and {} more {}s (-v lists all)", items.size() - i, kind));
      return;
    }
    lines.push_back(named(kind, i + 1, items[i].name) + ": " + describe(items[i]));
  }
}

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
  const std::optional<camera::Camera> camera = camera::camera_of(image, representation);
  if (!camera) return {};
  Json json = Json::parse(camera::camera_json(*camera));
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

class Plan {
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

Json e57_json(const E57File& file) {
  Json scans = Json::array(), images = Json::array();
  for (const E57Scan& scan : file.document().scans) {
    Json fields = Json::array();
    for (const E57Field& field : scan.fields) fields.push_back(field.name);
    scans.push_back({{"name", scan.name},
                     {"guid", scan.guid},
                     {"records", scan.record_count},
                     {"scanner", position_json(scan.pose)},
                     {"fields", fields}});
  }
  for (const E57Image& image : file.document().images) {
    Json representations = Json::array();
    for (const E57Representation& representation : image.representations) {
      representations.push_back({{"projection", name_of(representation.projection)},
                                 {"format", representation.extension},
                                 {"width", representation.width},
                                 {"height", representation.height},
                                 {"bytes", representation.blob.length},
                                 {"mask", representation.mask.has_value()}});
    }
    images.push_back({{"name", image.name},
                      {"guid", image.guid},
                      {"scan_guid", image.scan_guid},
                      {"camera", position_json(image.pose)},
                      {"pictures", representations}});
  }
  return {
      {"file", file.pages().name()}, {"guid", file.document().guid}, {"scans", scans}, {"images", images}};
}

std::vector<std::string> e57_lines(const E57File& file, Verbosity verbosity) {
  std::vector<std::string> lines;
  const auto scan_text = [](const E57Scan& scan) {
    return fmt::format("{} records, {}", scan.record_count, position_text(scan.pose));
  };
  const auto image_text = [](const E57Image& image) {
    std::vector<std::string> representations;
    for (const E57Representation& representation : image.representations)
      representations.push_back(representation_text(representation));
    if (representations.empty()) representations.push_back("no image");
    return fmt::format("{}, {}", fmt::join(representations, ", "), position_text(image.pose));
  };
  print_each(file.document().scans, "scan", verbosity, scan_text, lines);
  print_each(file.document().images, "image", verbosity, image_text, lines);
  return lines;
}

std::size_t extract_images(std::span<const std::filesystem::path> files, const std::filesystem::path& folder,
                           bool overwrite) {
  std::vector<E57File> sources;
  Plan plan;
  for (const std::filesystem::path& file : files) {
    sources.emplace_back(InputFile(file));
    plan.add(sources.size() - 1, sources.back());
    sources.back().pages().rest();
  }
  if (plan.extractions().empty()) {
    throw file_error(files.empty() ? std::string() : files.front().string(), "no images to extract",
                     "an E57 file with images");
  }
  std::filesystem::create_directories(folder);
  for (const Extraction& extraction : plan.extractions()) {
    for (const std::string& name : {extraction.image_name, extraction.mask_name, extraction.camera_name})
      if (!name.empty()) check_output(folder / name, overwrite);
  }
  check_output(folder / "images.json", overwrite);
  for (const Extraction& extraction : plan.extractions()) {
    E57File& source = sources[extraction.file];
    write_blob(folder / extraction.image_name, source, extraction.blob, overwrite);
    if (extraction.mask) write_blob(folder / extraction.mask_name, source, *extraction.mask, overwrite);
    if (!extraction.camera.empty())
      write_text_file(folder / extraction.camera_name, extraction.camera, overwrite);
  }
  write_text_file(folder / "images.json", plan.table(), overwrite);
  return plan.extractions().size();
}

}  // namespace alidade::tools
