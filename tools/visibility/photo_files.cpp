// SPDX-License-Identifier: MIT
#include "tools/visibility/photo_files.h"

#include <fmt/format.h>
#include <algorithm>
#include <map>
#include <memory>

#include "base/error.h"
#include "tools/image_module.h"

namespace alidade::tools {
namespace {

namespace fs = std::filesystem;

/// Relative names under which a photo may be in the folder. They do not lead out of it.
std::vector<fs::path> names_of(const std::string& name) {
  std::vector<fs::path> names;
  const fs::path whole = fs::path(name).lexically_normal();
  if (!whole.is_absolute() && !whole.empty() && *whole.begin() != "..") names.push_back(whole);
  if (whole.has_filename()) names.push_back(whole.filename());
  const std::size_t count = names.size();
  for (std::size_t i = 0; i < count && !whole.has_extension(); ++i) {
    for (const char* const extension : {".jpg", ".JPG", ".jpeg", ".png", ".PNG", ".tif", ".tiff"})
      names.push_back(names[i].string() + extension);
  }
  return names;
}

/// The file of a photo; empty if it is missing.
fs::path photo_of(const fs::path& folder, const std::string& name) {
  std::error_code error;
  for (const fs::path& each : names_of(name))
    if (fs::is_regular_file(folder / each, error)) return folder / each;
  return {};
}

void check_size(const fs::path& file, const image::ImageSize& found, const camera::NamedCamera& photo) {
  const camera::Camera& camera = photo.camera;
  if (found == image::ImageSize{camera.width, camera.height}) return;
  const bool is_turned = found == image::ImageSize{camera.height, camera.width};
  throw file_error(file, fmt::format("the size of the photo differs from that of camera '{}'", photo.name),
                   fmt::format("{} x {} pixels{}", camera.width, camera.height,
                               is_turned ? ", not turned" : ": the photo that the camera was computed for"),
                   fmt::format("{} x {}", found.width, found.height));
}

/// The photos of some cameras inside an E57 file.
class E57Photos {
 public:
  E57Photos(const fs::path& file, std::span<const camera::NamedCamera> cameras) : file_(InputFile(file)) {
    std::vector<std::string> ignored;  // which were printed with the cameras
    std::map<std::string, E57Picture> pictures;
    for (const camera::E57Photo& each : camera::e57_photos(file_.document(), ignored))
      pictures.emplace(each.camera.name, each.picture);
    for (const camera::NamedCamera& camera : cameras) {
      const E57Picture& picture = pictures.at(camera.name);
      photos_.push_back({file.string() + "/" + camera.name + "." + picture.extension, picture.blob});
      check_size(photos_.back().name,
                 image_module().photo_size(photos_.back().name, bytes_of(photos_.back())), camera);
    }
  }

  image::PhotoPixels read(std::size_t photo) {
    return image_module().read_photo(photos_[photo].name, bytes_of(photos_[photo]));
  }

 private:
  struct Photo {
    fs::path name;  ///< in messages, with the extension of its format
    E57Blob blob;
  };

  /// Valid until the next call.
  std::span<const std::byte> bytes_of(const Photo& photo) {
    bytes_.clear();
    file_.read_blob(photo.blob, [&](std::span<const std::byte> piece) {
      bytes_.insert(bytes_.end(), piece.begin(), piece.end());
    });
    return bytes_;
  }

  E57File file_;
  std::vector<Photo> photos_;
  std::vector<std::byte> bytes_;
};

}  // namespace

PhotoReader photos_in_folder(const fs::path& folder, std::span<const camera::NamedCamera> cameras) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) throw file_error(folder, "not a folder", "the folder of the photos");
  std::vector<fs::path> files;
  std::vector<std::string> missing;
  for (const camera::NamedCamera& each : cameras) {
    files.push_back(photo_of(folder, each.name));
    if (files.back().empty()) missing.push_back(each.name);
  }
  if (!missing.empty()) {
    throw file_error(folder, fmt::format("the photo of camera '{}' is missing", missing.front()),
                     "a file of that name, or --camera-name to choose cameras",
                     fmt::format("{} of {} photos", cameras.size() - missing.size(), cameras.size()));
  }
  for (std::size_t i = 0; i < files.size(); ++i)
    check_size(files[i], image_module().photo_size(files[i], {}), cameras[i]);
  return [files](std::size_t photo) { return image_module().read_photo(files[photo], {}); };
}

PhotoReader photos_in_e57(const fs::path& file, std::span<const camera::NamedCamera> cameras) {
  const auto photos = std::make_shared<E57Photos>(file, cameras);
  return [photos](std::size_t photo) { return photos->read(photo); };
}

}  // namespace alidade::tools
