// SPDX-License-Identifier: MIT
#include "camera/camera_json.h"

#include <fmt/format.h>

namespace alidade::camera {
namespace {

/// "key": value, for values that are not the default 0.
class Fields {
 public:
  void add(std::string_view key, double value) {
    if (value != 0.0) require(key, value);
  }
  void require(std::string_view key, double value) {
    text_ += fmt::format("{}\"{}\": {:.17g}", text_.empty() ? "" : ", ", key, value);
  }
  void add_word(std::string_view key, std::string_view word) {
    text_ += fmt::format("{}\"{}\": \"{}\"", text_.empty() ? "" : ", ", key, word);
  }
  std::string object() const { return "{" + text_ + "}"; }

 private:
  std::string text_;
};

void add_bend(const Distortion& distortion, Fields& fields) {
  fields.add("p1", distortion.p1);
  fields.add("p2", distortion.p2);
  for (std::size_t i = 0; i < distortion.prism.size(); ++i)
    fields.add(fmt::format("s{}", i + 1), distortion.prism[i]);
}

struct DistortionObject {
  std::string operator()(const PinholeLens&) const { return ""; }
  std::string operator()(const OrthographicLens&) const { return ""; }
  std::string operator()(const EquirectangularLens&) const { return ""; }
  std::string operator()(const BrownLens& lens) const {
    Fields fields;
    const Distortion& distortion = lens.distortion;
    for (std::size_t i = 0; i < 3; ++i) fields.add(fmt::format("k{}", i + 1), distortion.radial[i]);
    for (std::size_t i = 0; i < 3; ++i) fields.add(fmt::format("k{}", i + 4), distortion.denominator[i]);
    fields.add("r8", distortion.radial[3]);
    add_bend(distortion, fields);
    return fields.object();
  }
  std::string operator()(const FisheyeLens& lens) const {
    Fields fields;
    const Distortion& distortion = lens.distortion;
    for (std::size_t i = 0; i < 6; ++i) fields.add(fmt::format("k{}", i + 1), distortion.radial[i]);
    add_bend(distortion, fields);
    if (distortion.after_radial) fields.add_word("order", "radial_first");
    return fields.object();
  }
  std::string operator()(const FieldOfViewLens& lens) const { return one("omega", lens.omega); }
  std::string operator()(const DivisionLens& lens) const { return one("k", lens.k); }
  std::string operator()(const UnifiedLens& lens) const {
    Fields fields;
    fields.require("alpha", lens.alpha);
    fields.require("beta", lens.beta);
    return fields.object();
  }
  std::string operator()(const DualLens& lens) const {
    Fields fields;
    fields.require("transition", lens.transition);
    fields.add("k1", lens.distortion.radial[0]);
    fields.add("k2", lens.distortion.radial[1]);
    return fields.object();
  }
  static std::string one(std::string_view key, double value) {
    Fields fields;
    fields.require(key, value);
    return fields.object();
  }
};

}  // namespace

std::string camera_json(const Camera& camera) {
  const CameraPose& pose = camera.pose;
  std::string rows;
  for (int axis = 0; axis < 3; ++axis) {
    rows += fmt::format("[{:.17g}, {:.17g}, {:.17g}, {:.17g}], ", pose.right[axis], pose.down[axis],
                        pose.forward[axis], pose.position[axis]);
  }
  const std::string distortion = std::visit(DistortionObject{}, camera.lens);
  return fmt::format(
      R"({{"version": 1, "model": "{}", "width": {}, "height": {}, )"
      R"("intrinsics": {{"fx": {:.17g}, "fy": {:.17g}, "cx": {:.17g}, "cy": {:.17g}}}, {})"
      R"("pose": {{"matrix": [{}[0, 0, 0, 1]], "convention": "opencv", "direction": "camera_to_world"}}{}}})",
      k_lens_names[camera.lens.index()], camera.width, camera.height, camera.fx, camera.fy, camera.cx,
      camera.cy, distortion.empty() ? "" : "\"distortion\": " + distortion + ", ", rows,
      camera.near > 0.0 ? fmt::format(", \"near\": {:.17g}", camera.near) : "");
}

}  // namespace alidade::camera
