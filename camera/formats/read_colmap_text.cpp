// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "base/error.h"
#include "camera/formats/camera_file.h"
#include "camera/formats/colmap_images.h"
#include "camera/formats/text_fields.h"

namespace alidade {
namespace {

/// Runs `work` and tells file and line in errors that name none.
template <typename Work>
void at_line(const std::string& file, const LineWalk& lines, const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    if (!error.parts().file.empty()) throw;
    Error::Parts parts = error.parts();
    parts.file = file;
    parts.place = fmt::format("line {}", lines.number());
    throw Error(parts);
  }
}

bool is_remark(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t,\r");
  return first == std::string_view::npos || line[first] == '#';
}

void read_camera(std::string_view line, ColmapImages& model) {
  FieldWalk fields(line);
  const auto id = static_cast<std::uint32_t>(fields.whole_number("camera id", UINT32_MAX));
  const std::string_view name = fields.word("camera model");
  const std::span<const ColmapModel> models = colmap_models();
  const auto known = std::ranges::find(models, name, &ColmapModel::name);
  if (known == models.end()) {
    throw Error({.problem = fmt::format("camera {} has an unknown model", id),
                 .expected = "a model of COLMAP such as PINHOLE or OPENCV",
                 .found = std::string(name.substr(0, 40))});
  }
  const std::uint64_t width = fields.whole_number("image width", UINT64_MAX);
  const std::uint64_t height = fields.whole_number("image height", UINT64_MAX);
  std::vector<double> parameters;
  for (std::size_t i = 0; i < known->parameter_count; ++i)
    parameters.push_back(fields.number("camera parameter"));
  if (!fields.at_end()) {
    throw Error({.problem = fmt::format("camera {} has too many parameters", id),
                 .expected = fmt::format("{} for {}", known->parameter_count, known->name)});
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

/// The second line of an image holds x, y and point id by turns; anything else is a line out of step.
void check_observations(std::string_view line) {
  std::size_t count = 0;
  for (FieldWalk fields(line); !fields.at_end(); ++count) fields.word("observation");
  if (count % 3 != 0) {
    throw Error({.problem = "not a line of observations",
                 .expected = "x, y and point id by turns, or an empty line below every image",
                 .found = fmt::format("{} values", count)});
  }
}

}  // namespace

CameraSet read_colmap_text(std::string_view cameras, const std::string& cameras_name, std::string_view images,
                           const std::string& images_name) {
  ColmapImages model;
  std::string_view line;
  for (LineWalk lines(cameras); lines.next(line);) {
    if (!is_remark(line)) at_line(cameras_name, lines, [&] { read_camera(line, model); });
  }
  for (LineWalk lines(images); lines.next(line);) {
    if (is_remark(line)) continue;
    at_line(images_name, lines, [&] { read_image(line, model); });
    // The file may end without the last image's empty line.
    if (lines.next(line)) at_line(images_name, lines, [&] { check_observations(line); });
  }
  return model.take();
}

}  // namespace alidade
