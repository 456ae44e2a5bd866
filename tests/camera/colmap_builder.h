// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace alidade::test {

/// The two files of a COLMAP model as bytes, written from the documented layout.
class ColmapBuilder {
 public:
  ColmapBuilder& camera(std::uint32_t id, std::int32_t model, std::uint64_t width, std::uint64_t height,
                        const std::vector<double>& parameters) {
    ++camera_count_;
    append(cameras_, id);
    append(cameras_, model);
    append(cameras_, width);
    append(cameras_, height);
    for (const double each : parameters) append(cameras_, each);
    return *this;
  }

  ColmapBuilder& image(std::uint32_t id, const std::array<double, 4>& quaternion,
                       const std::array<double, 3>& translation, std::uint32_t camera_id,
                       const std::string& name, std::uint64_t observations = 0) {
    ++image_count_;
    append(images_, id);
    for (const double each : quaternion) append(images_, each);
    for (const double each : translation) append(images_, each);
    append(images_, camera_id);
    images_ += name;
    images_ += '\0';
    append(images_, observations);
    for (std::uint64_t i = 0; i < observations; ++i) {
      append(images_, 1.5);
      append(images_, 2.5);
      append(images_, UINT64_MAX);
    }
    return *this;
  }

  std::string cameras() const { return counted(camera_count_, cameras_); }
  std::string images() const { return counted(image_count_, images_); }

  /// Appends the bytes of a value, little endian.
  template <class Value>
  static void append(std::string& bytes, Value value) {
    char each[sizeof value];
    std::memcpy(each, &value, sizeof value);
    bytes.append(each, sizeof value);
  }

 private:
  static std::string counted(std::uint64_t count, const std::string& records) {
    std::string bytes;
    append(bytes, count);
    return bytes + records;
  }

  std::uint64_t camera_count_ = 0, image_count_ = 0;
  std::string cameras_, images_;
};

}  // namespace alidade::test
