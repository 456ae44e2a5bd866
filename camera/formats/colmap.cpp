// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "base/bytes.h"
#include "base/error.h"
#include "base/input_file.h"
#include "camera/formats/camera_file.h"
#include "camera/formats/colmap_images.h"

namespace alidade {
namespace {

constexpr std::size_t k_longest_name = 4096;

/// One file of the model, with errors that name the byte.
class Reader {
 public:
  explicit Reader(InputFile& file) : file_(file), cursor_(file, 0) {}

  template <typename Value>
  Value take() {
    return load<Value>(cursor_.take(sizeof(Value)));
  }

  /// A count of records of at least so many bytes each, which must all fit into what is left of the file.
  std::uint64_t take_count(std::size_t smallest_record, const char* what) {
    const std::uint64_t place = cursor_.place(), count = take<std::uint64_t>();
    const std::uint64_t left = file_.size() - cursor_.place();
    if (count > left / smallest_record) {
      throw Error({.file = file_.name(),
                   .place = fmt::format("byte {}", place),
                   .problem = fmt::format("more {} than the file has room for", what),
                   .expected = fmt::format("at most {}", left / smallest_record),
                   .found = fmt::format("{}", count)});
    }
    return count;
  }

  std::string take_name() {
    const std::uint64_t place = cursor_.place();
    std::string name;
    for (char letter = take<char>(); letter != '\0'; letter = take<char>()) {
      name += letter;
      if (name.size() > k_longest_name) {
        throw Error({.file = file_.name(),
                     .place = fmt::format("byte {}", place),
                     .problem = "name without an end",
                     .expected = fmt::format("at most {} bytes and a byte 0", k_longest_name)});
      }
    }
    return name;
  }

  void skip(std::uint64_t bytes) { cursor_.skip(bytes); }

  /// Tells where the record began in errors of `work` that name no place.
  template <typename Work>
  void record(const Work& work) {
    const std::uint64_t place = cursor_.place();
    try {
      work();
    } catch (const Error& error) {
      if (!error.parts().file.empty()) throw;
      Error::Parts parts = error.parts();
      parts.file = file_.name();
      parts.place = fmt::format("byte {}", place);
      throw Error(parts);
    }
  }

  void expect_end() const {
    if (cursor_.place() == file_.size()) return;
    throw Error({.file = file_.name(),
                 .place = fmt::format("byte {}", cursor_.place()),
                 .problem = "bytes behind the last record",
                 .expected = "the end of the file",
                 .found = fmt::format("{} bytes", file_.size() - cursor_.place())});
  }

 private:
  InputFile& file_;
  ByteCursor cursor_;
};

void read_camera(Reader& reader, ColmapImages& model) {
  const auto id = reader.take<std::uint32_t>();
  const auto model_id = reader.take<std::int32_t>();
  const auto width = reader.take<std::uint64_t>(), height = reader.take<std::uint64_t>();
  const std::span<const ColmapModel> models = colmap_models();
  const auto known = std::ranges::find(models, model_id, &ColmapModel::id);
  if (known == models.end()) {
    throw Error({.problem = fmt::format("camera {} has an unknown model", id),
                 .expected = fmt::format("0 to {}", models.size() - 1),
                 .found = fmt::format("{}", model_id)});
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

}  // namespace alidade
