// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace alidade::test {

using ImageTexts = std::vector<std::pair<std::string, std::string>>;

/// A test with an empty folder of its own and images in it.
class ImageFilesTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override { std::filesystem::remove_all(folder); }

  /// Writes three values per pixel: as sRGB in 0 .. 1 into files of 8 bits, as linear light into EXR files.
  void write_image(const std::string& name, int width, int height, const std::vector<float>& color,
                   const ImageTexts& metadata = {}) const;
  /// An EXR file with the channels given, as float, or unsigned integers for "id".
  void write_layers(const std::string& name, int width, int height, const std::vector<std::string>& channels,
                    const std::vector<float>& values) const;

  std::filesystem::path folder;
};

}  // namespace alidade::test
