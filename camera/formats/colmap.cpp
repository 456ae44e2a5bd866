// SPDX-License-Identifier: MIT

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/input_file.h"
#include "base/words.h"
#include "camera/camera.h"
#include "camera/camera_set.h"
#include "camera/formats/camera_file.h"

namespace alidade::camera {
namespace {

/// A camera model of COLMAP.
struct ColmapModel {
  std::string_view name;
  int id;  ///< in binary files
  std::size_t parameter_count;
};

constexpr std::array<ColmapModel, 18> k_models = {{{"SIMPLE_PINHOLE", 0, 3},
                                                   {"PINHOLE", 1, 4},
                                                   {"SIMPLE_RADIAL", 2, 4},
                                                   {"RADIAL", 3, 5},
                                                   {"OPENCV", 4, 8},
                                                   {"OPENCV_FISHEYE", 5, 8},
                                                   {"FULL_OPENCV", 6, 12},
                                                   {"FOV", 7, 5},
                                                   {"SIMPLE_RADIAL_FISHEYE", 8, 4},
                                                   {"RADIAL_FISHEYE", 9, 5},
                                                   {"THIN_PRISM_FISHEYE", 10, 12},
                                                   {"RAD_TAN_THIN_PRISM_FISHEYE", 11, 16},
                                                   {"SIMPLE_DIVISION", 12, 4},
                                                   {"DIVISION", 13, 5},
                                                   {"SIMPLE_FISHEYE", 14, 3},
                                                   {"FISHEYE", 15, 4},
                                                   {"EUCM", 16, 6},
                                                   {"EQUIRECTANGULAR", 17, 2}}};

/// Whether the model has one focal length for both axes.
bool has_one_focal_length(int id) {
  return id == 0 || id == 2 || id == 3 || id == 8 || id == 9 || id == 12 || id == 14;
}

/// `k`: the parameters after focal lengths and principal point.
Lens lens_of(int id, std::span<const double> k) {
  switch (id) {
    case 0:
    case 1:
      return PinholeLens{};
    case 2:
      return BrownLens{{.radial = {k[0]}}};
    case 3:
      return BrownLens{{.radial = {k[0], k[1]}}};
    case 4:
      return BrownLens{{.radial = {k[0], k[1]}, .p1 = k[2], .p2 = k[3]}};
    case 5:
      return FisheyeLens{{.radial = {k[0], k[1], k[2], k[3]}}};
    case 6:
      return BrownLens{
          {.radial = {k[0], k[1], k[4]}, .denominator = {k[5], k[6], k[7]}, .p1 = k[2], .p2 = k[3]}};
    case 7:
      return FieldOfViewLens{k[0]};
    case 8:
      return FisheyeLens{{.radial = {k[0]}}};
    case 9:
      return FisheyeLens{{.radial = {k[0], k[1]}}};
    case 10:
      return FisheyeLens{
          {.radial = {k[0], k[1], k[4], k[5]}, .p1 = k[2], .p2 = k[3], .prism = {k[6], 0.0, k[7], 0.0}}};
    case 11:
      // Its p0 corresponds to p2 of all others.
      return FisheyeLens{{.radial = {k[0], k[1], k[2], k[3], k[4], k[5]},
                          .p1 = k[7],
                          .p2 = k[6],
                          .prism = {k[8], k[9], k[10], k[11]},
                          .after_radial = true}};
    case 12:
    case 13:
      return DivisionLens{k[0]};
    case 16:
      return UnifiedLens{k[0], k[1]};
    default:
      return FisheyeLens{};
  }
}

/// Requires: as many parameters as the model has. Errors: as check_camera_numbers().
Camera camera_of_colmap(const ColmapModel& model, std::uint64_t width, std::uint64_t height,
                        std::span<const double> parameters) {
  assert(parameters.size() == model.parameter_count);
  Camera camera;
  set_size(camera, width, height);
  if (model.id == 17) {
    camera.fx = parameters[0] / (2.0 * std::numbers::pi);
    camera.fy = parameters[1] / std::numbers::pi;
    camera.cx = 0.5 * parameters[0];
    camera.cy = 0.5 * parameters[1];
    camera.lens = EquirectangularLens{};
  } else {
    const std::size_t first = has_one_focal_length(model.id) ? 0 : 1;
    camera.fx = parameters[0];
    camera.fy = parameters[first];
    camera.cx = parameters[first + 1];
    camera.cy = parameters[first + 2];
    camera.lens = lens_of(model.id, parameters.subspan(first + 3));
  }
  check_camera_numbers(camera);
  return camera;
}

/// An image of a COLMAP model, as binary and text files have it.
struct ColmapImage {
  std::uint32_t id = 0;
  std::array<double, 4> quaternion{};   ///< w, x, y, z; world to camera
  std::array<double, 3> translation{};  ///< world to camera
  std::uint32_t camera_id = 0;
  std::string name;
};

/// Joins the images of a COLMAP model with their cameras. Errors, without file and location: a duplicate id,
/// an image without its camera, an invalid rotation or translation, an empty name.
class ColmapImages {
 public:
  void add_camera(std::uint32_t id, const Camera& camera) {
    if (!cameras_.emplace(id, camera).second)
      throw input_error(fmt::format("duplicate camera id {}", id), "unique ids");
  }

  void add_image(const ColmapImage& image) {
    const auto camera = cameras_.find(image.camera_id);
    if (camera == cameras_.end()) {
      throw Error(
          {.problem = fmt::format("image {} refers to the missing camera {}", image.id, image.camera_id)});
    }
    if (!image_ids_.insert(image.id).second)
      throw input_error(fmt::format("duplicate image id {}", image.id), "unique ids");
    if (image.name.empty()) throw Error({.problem = fmt::format("image {} has no name", image.id)});
    const auto rotation = rotation_from_quaternion(image.quaternion);
    if (!rotation) {
      throw input_error(fmt::format("invalid rotation of image {}", image.id), "a finite nonzero quaternion");
    }
    const auto& [x, y, z] = image.translation;
    if (!(std::fabs(x) <= 1e12 && std::fabs(y) <= 1e12 && std::fabs(z) <= 1e12)) {
      throw input_error(fmt::format("translation of image {} out of range", image.id),
                        "numbers within +-1e12");
    }
    NamedCamera& named = set_.cameras.emplace_back(NamedCamera{image.name, camera->second});
    named.camera.pose = pose_from_world_to_camera(*rotation, {x, y, z});
  }
  CameraSet take() { return std::move(set_); }

 private:
  std::unordered_map<std::uint32_t, Camera> cameras_;
  std::unordered_set<std::uint32_t> image_ids_;
  CameraSet set_;
};

constexpr std::size_t k_longest_name = 4096;

/// One file of the model, with errors that name the byte.
class Reader {
 public:
  explicit Reader(InputFile& file) : file_(file), cursor_(file, 0) {}

  template <typename Value>
  Value take() {
    return load<Value>(cursor_.take(sizeof(Value)));
  }

  /// A count of records of at least so many bytes each, which must all fit into the rest of the file.
  std::uint64_t take_count(std::size_t smallest_record, const char* what) {
    const std::uint64_t offset = cursor_.offset(), count = take<std::uint64_t>();
    const std::uint64_t left = file_.size() - cursor_.offset();
    if (count > left / smallest_record) {
      throw Error({.file = file_.name(),
                   .location = fmt::format("byte {}", offset),
                   .problem = fmt::format("the number of {} exceeds the file", what),
                   .expected = fmt::format("at most {}", left / smallest_record),
                   .found = fmt::format("{}", count)});
    }
    return count;
  }

  std::string take_name() {
    const std::uint64_t offset = cursor_.offset();
    std::string name;
    for (char character = take<char>(); character != '\0'; character = take<char>()) {
      name += character;
      if (name.size() > k_longest_name) {
        throw Error({.file = file_.name(),
                     .location = fmt::format("byte {}", offset),
                     .problem = "unterminated name",
                     .expected = fmt::format("at most {} bytes and a byte 0", k_longest_name)});
      }
    }
    return name;
  }

  void skip(std::uint64_t bytes) { cursor_.skip(bytes); }

  /// Adds the byte where the record began to errors of `work` that have no location.
  template <typename Work>
  void record(const Work& work) {
    const std::uint64_t offset = cursor_.offset();
    try {
      work();
    } catch (const Error& error) {
      if (!error.parts().file.empty()) throw;
      Error::Parts parts = error.parts();
      parts.file = file_.name();
      parts.location = fmt::format("byte {}", offset);
      throw Error(parts);
    }
  }

  void expect_end() const {
    if (cursor_.offset() == file_.size()) return;
    throw Error({.file = file_.name(),
                 .location = fmt::format("byte {}", cursor_.offset()),
                 .problem = "extra bytes after the last record",
                 .expected = "the end of the file",
                 .found = fmt::format("{} bytes", file_.size() - cursor_.offset())});
  }

 private:
  InputFile& file_;
  ByteCursor cursor_;
};

void read_camera(Reader& reader, ColmapImages& model) {
  const auto id = reader.take<std::uint32_t>();
  const auto model_id = reader.take<std::int32_t>();
  const auto width = reader.take<std::uint64_t>(), height = reader.take<std::uint64_t>();
  const auto known = std::ranges::find(k_models, model_id, &ColmapModel::id);
  if (known == k_models.end()) {
    throw input_error(fmt::format("unknown model of camera {}", id),
                      fmt::format("a model id from 0 to {}", k_models.size() - 1),
                      fmt::format("{}", model_id));
  }
  std::vector<double> parameters;
  for (std::size_t i = 0; i < known->parameter_count; ++i) parameters.push_back(reader.take<double>());
  model.add_camera(id, camera_of_colmap(*known, width, height, parameters));
}

void read_image(Reader& reader, ColmapImages& model) {
  ColmapImage image;
  image.id = reader.take<std::uint32_t>();
  for (double& each : image.quaternion) each = reader.take<double>();
  for (double& each : image.translation) each = reader.take<double>();
  image.camera_id = reader.take<std::uint32_t>();
  image.name = reader.take_name();
  constexpr std::size_t k_observation = 24;
  reader.skip(k_observation * reader.take_count(k_observation, "observations"));
  model.add_image(image);
}

bool is_remark(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t,\r");
  return first == std::string_view::npos || line[first] == '#';
}

void read_camera(std::string_view line, ColmapImages& model) {
  FieldWalk fields(line);
  const auto id = static_cast<std::uint32_t>(fields.whole_number("camera id", UINT32_MAX));
  const std::string_view name = fields.word("camera model");
  const auto known = std::ranges::find(k_models, name, &ColmapModel::name);
  if (known == k_models.end()) {
    throw input_error(fmt::format("unknown model of camera {}", id),
                      "a COLMAP model such as PINHOLE or OPENCV", std::string(name.substr(0, 40)));
  }
  const std::uint64_t width = fields.whole_number("image width", UINT64_MAX);
  const std::uint64_t height = fields.whole_number("image height", UINT64_MAX);
  std::vector<double> parameters;
  for (std::size_t i = 0; i < known->parameter_count; ++i)
    parameters.push_back(fields.number("camera parameter"));
  if (!fields.at_end()) {
    throw input_error(fmt::format("camera {} has too many parameters", id),
                      fmt::format("{} for {}", known->parameter_count, known->name));
  }
  model.add_camera(id, camera_of_colmap(*known, width, height, parameters));
}

void read_image(std::string_view line, ColmapImages& model) {
  FieldWalk fields(line);
  ColmapImage image;
  image.id = static_cast<std::uint32_t>(fields.whole_number("image id", UINT32_MAX));
  for (double& each : image.quaternion) each = fields.number("quaternion");
  for (double& each : image.translation) each = fields.number("translation");
  image.camera_id = static_cast<std::uint32_t>(fields.whole_number("camera id", UINT32_MAX));
  image.name = fields.rest();
  model.add_image(image);
}

/// The second line of an image: x, y and point id, repeated.
bool is_observations(std::string_view line) {
  // The line of an image has nine numbers and a name; the third number is part of a quaternion.
  constexpr std::size_t k_looked_at = 12;
  std::size_t count = 0;
  for (FieldWalk fields(line); !fields.at_end(); ++count) {
    const std::string_view word = fields.word("observation");
    const bool is_id = parse_count<std::int64_t>(word) || parse_count(word);
    if (count < k_looked_at && !(count % 3 == 2 ? is_id : parse_number(word).has_value())) return false;
  }
  return count % 3 == 0;
}

/// Id, quaternion, translation, camera id and name.
bool is_image(std::string_view line) {
  constexpr std::size_t k_numbers = 9;
  FieldWalk fields(line);
  for (std::size_t i = 0; i < k_numbers; ++i)
    if (fields.at_end() || !parse_number(fields.word("number"))) return false;
  return !fields.at_end();
}

}  // namespace

CameraSet read_colmap_binary(InputFile cameras, InputFile images) {
  ColmapImages model;
  Reader camera_reader(cameras);
  for (std::uint64_t left = camera_reader.take_count(40, "cameras"); left > 0; --left)
    camera_reader.record([&] { read_camera(camera_reader, model); });
  camera_reader.expect_end();
  Reader image_reader(images);
  for (std::uint64_t left = image_reader.take_count(73, "images"); left > 0; --left)
    image_reader.record([&] { read_image(image_reader, model); });
  image_reader.expect_end();
  return model.take();
}

CameraSet read_colmap_text(std::string_view cameras, const std::string& cameras_name, std::string_view images,
                           const std::string& images_name) {
  ColmapImages model;
  std::string_view line;
  for (LineWalk lines(cameras); lines.next(line);) {
    if (!is_remark(line)) at_line(cameras_name, lines, [&] { read_camera(line, model); });
  }
  bool is_second = false;
  for (LineWalk lines(images); lines.next(line);) {
    const bool may_be_observations = std::exchange(is_second, false);
    if (is_remark(line) || (may_be_observations && is_observations(line))) continue;
    at_line(images_name, lines, [&] {
      // Some programs leave out the lines of observations.
      if (may_be_observations && !is_image(line))
        throw input_error("invalid line of observations",
                          "x, y and point id repeated, an empty line, or the next image, after every image");
      read_image(line, model);
      is_second = true;
    });
  }
  return model.take();
}

}  // namespace alidade::camera
