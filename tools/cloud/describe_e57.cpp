// SPDX-License-Identifier: MIT
#include "tools/cloud/describe_e57.h"

#include <fmt/format.h>

#include <algorithm>

#include "cloud/cloud_inputs.h"

namespace alidade {
namespace {

using Json = nlohmann::ordered_json;

Json place_json(const std::optional<E57Pose>& pose) {
  if (!pose) return {};
  return {pose->translation.x, pose->translation.y, pose->translation.z};
}

std::string place_text(const std::optional<E57Pose>& pose) {
  if (!pose) return "no pose";
  return fmt::format("at {} {} {}", pose->translation.x, pose->translation.y, pose->translation.z);
}

std::string picture_text(const E57Picture& picture) {
  return fmt::format("{} {} {}x{}{}", name_of(picture.projection), picture.extension, picture.width,
                     picture.height, picture.mask ? " with mask" : "");
}

/// Names say anything: line breaks and what moves the cursor would look like words of ours.
std::string named(const char* kind, std::size_t number, std::string name) {
  std::ranges::replace_if(
      name, [](unsigned char letter) { return letter < 0x20 || letter == 0x7f; }, '?');
  return name.empty() ? fmt::format("{} {}", kind, number) : fmt::format("{} {} '{}'", kind, number, name);
}

template <class Item, class Tell>
void tell_each(const std::vector<Item>& items, const char* kind, Verbosity verbosity, const Tell& tell,
               std::vector<std::string>& lines) {
  constexpr std::size_t k_first = 10;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i == k_first && verbosity != Verbosity::verbose) {
      lines.push_back(fmt::format("and {} more {}s (-v tells all)", items.size() - i, kind));
      return;
    }
    lines.push_back(named(kind, i + 1, items[i].name) + ": " + tell(items[i]));
  }
}

}  // namespace

bool is_e57_file(const std::filesystem::path& file) {
  InputFile input = cloud_input(file);
  const auto start = input.view_up_to(0, 8);
  return std::string_view(reinterpret_cast<const char*>(start.data()), start.size()) == "ASTM-E57";
}

Json e57_json(const E57File& file) {
  Json scans = Json::array(), images = Json::array();
  for (const E57Scan& scan : file.document().scans) {
    Json fields = Json::array();
    for (const E57Field& field : scan.fields) fields.push_back(field.name);
    scans.push_back({{"name", scan.name},
                     {"guid", scan.guid},
                     {"records", scan.record_count},
                     {"scanner", place_json(scan.pose)},
                     {"fields", fields}});
  }
  for (const E57Image& image : file.document().images) {
    Json pictures = Json::array();
    for (const E57Picture& picture : image.pictures) {
      pictures.push_back({{"projection", name_of(picture.projection)},
                          {"format", picture.extension},
                          {"width", picture.width},
                          {"height", picture.height},
                          {"bytes", picture.blob.length},
                          {"mask", picture.mask.has_value()}});
    }
    images.push_back({{"name", image.name},
                      {"guid", image.guid},
                      {"scan_guid", image.scan_guid},
                      {"camera", place_json(image.pose)},
                      {"pictures", pictures}});
  }
  return {
      {"file", file.pages().name()}, {"guid", file.document().guid}, {"scans", scans}, {"images", images}};
}

std::vector<std::string> e57_lines(const E57File& file, Verbosity verbosity) {
  std::vector<std::string> lines;
  const auto scan_text = [](const E57Scan& scan) {
    return fmt::format("{} records, {}", scan.record_count, place_text(scan.pose));
  };
  const auto image_text = [](const E57Image& image) {
    std::vector<std::string> pictures;
    for (const E57Picture& picture : image.pictures) pictures.push_back(picture_text(picture));
    if (pictures.empty()) pictures.push_back("no picture");
    return fmt::format("{}, {}", fmt::join(pictures, ", "), place_text(image.pose));
  };
  tell_each(file.document().scans, "scan", verbosity, scan_text, lines);
  tell_each(file.document().images, "image", verbosity, image_text, lines);
  return lines;
}

}  // namespace alidade
