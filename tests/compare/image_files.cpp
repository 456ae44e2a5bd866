// SPDX-License-Identifier: MIT
#include "tests/compare/image_files.h"

#include <OpenImageIO/imageio.h>
#include <unistd.h>
#include <filesystem>

#include <bit>
#include <cstdint>
#include <stdexcept>

namespace alidade::test {
namespace {

void write_file(const std::filesystem::path& file, const OIIO::ImageSpec& spec, OIIO::TypeDesc type,
                const void* values) {
  const auto output = OIIO::ImageOutput::create(file.string());
  if (!output || !output->open(file.string(), spec) || !output->write_image(type, values) || !output->close())
    throw std::runtime_error("cannot write " + file.string());
}

}  // namespace

void ImageFilesTest::SetUp() {
  const auto* const test = ::testing::UnitTest::GetInstance()->current_test_info();
  folder = std::filesystem::temp_directory_path() / ("alidade_" + std::string(test->test_suite_name()) + "_" +
                                                     test->name() + "_" + std::to_string(::getpid()));
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
}

void ImageFilesTest::write_image(const std::string& name, int width, int height,
                                 const std::vector<float>& color, const ImageTexts& metadata) const {
  const bool is_linear = name.ends_with(".exr");
  OIIO::ImageSpec spec(width, height, 3, is_linear ? OIIO::TypeFloat : OIIO::TypeUInt8);
  for (const auto& [key, text] : metadata) spec.attribute(key, text);
  write_file(folder / name, spec, OIIO::TypeFloat, color.data());
}

void ImageFilesTest::write_layers(const std::string& name, int width, int height,
                                  const std::vector<std::string>& channels,
                                  const std::vector<float>& values) const {
  OIIO::ImageSpec spec(width, height, static_cast<int>(channels.size()), OIIO::TypeFloat);
  spec.channelnames = channels;
  for (const std::string& channel : channels)
    spec.channelformats.push_back(channel == "id" ? OIIO::TypeUInt32 : OIIO::TypeFloat);
  // Each value is written in its own type: a conversion would scale integers to fractions of their maximum.
  std::vector<std::uint32_t> words(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool is_id = channels[i % channels.size()] == "id";
    words[i] = is_id ? static_cast<std::uint32_t>(values[i]) : std::bit_cast<std::uint32_t>(values[i]);
  }
  write_file(folder / name, spec, OIIO::TypeUnknown, words.data());
}

}  // namespace alidade::test
