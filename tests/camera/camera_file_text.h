// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <stdexcept>
#include <string>

#include "base/error.h"
#include "camera/camera_set.h"

// What the tests of camera files share.

namespace alidade::test {

using namespace camera;

inline CameraSet parse(const std::string& text, const CameraFileOptions& options = {}) {
  return parse_cameras(text, "nowhere/cameras.json", options);
}

inline std::string error_of(const std::string& text, const CameraFileOptions& options = {}) {
  try {
    parse(text, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

inline void expect_error(const std::string& text, const std::string& part) {
  const std::string error = error_of(text);
  EXPECT_NE(error.find(part), std::string::npos) << error << "\n  lacks " << part;
}

inline void expect_pose(const CameraPose& pose, const CameraPose& expected, double tolerance = 1e-14) {
  EXPECT_LT(glm::length(pose.position - expected.position), tolerance);
  EXPECT_LT(glm::length(pose.right - expected.right), tolerance);
  EXPECT_LT(glm::length(pose.down - expected.down), tolerance);
  EXPECT_LT(glm::length(pose.forward - expected.forward), tolerance);
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t position = text.find(from);
  if (position == std::string::npos) throw std::logic_error("no " + from);
  return text.replace(position, from.size(), to);
}

}  // namespace alidade::test
