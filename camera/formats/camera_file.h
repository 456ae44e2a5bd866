// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/input_file.h"
#include "base/json.h"
#include "camera/camera_set.h"
#include "camera/projection.h"

// The readers of camera files, one per format, and what they share.

namespace alidade::camera {

/// Largest camera file, without a COLMAP model's points: 1 GiB.
inline constexpr std::uintmax_t k_largest_camera_file = std::uintmax_t{1} << 30;

/// Tolerance for rotations in files, which often have few digits.
inline constexpr double k_file_rotation_tolerance = 1e-3;

/// Sets the image size from that of a file, in whole pixels. Errors: 0, or larger than images may be.
void set_size(Camera& camera, std::uint64_t width, std::uint64_t height);

CameraSet read_transforms(const JsonNode& top, const std::filesystem::path& file, bool original_world);
CameraSet read_opensfm(const JsonNode& top);
CameraSet read_openmvg(const JsonNode& top);
CameraSet read_trajectory(std::string_view text, const std::string& name, const std::optional<Camera>& lens);

/// Errors: the first bytes of a file are those of a known export that is not supported; the error names the
/// format to save instead.
void reject_known_export(std::string_view start, const std::filesystem::path& file);

/// A COLMAP model: its two files, both binary or both text.
CameraSet read_colmap_binary(InputFile cameras, InputFile images);
CameraSet read_colmap_text(std::string_view cameras, const std::string& cameras_name, std::string_view images,
                           const std::string& images_name);

/// Runs `work` and adds file and location of a JSON node to errors without a file.
template <typename Work>
auto at_node(const JsonNode& node, const Work& work) {
  try {
    return work();
  } catch (const Error& error) {
    if (!error.parts().file.empty()) throw;
    node.fail(error.parts().problem, error.parts().expected, error.parts().found);
  }
}

/// Iterates over the lines of a text. LF, CR LF and CR end a line, which the last one may lack.
class LineWalk {
 public:
  explicit LineWalk(std::string_view text) : text_(text) {}
  /// The next line without its end; false at the end of the text.
  bool next(std::string_view& line);
  /// Number of the line last returned, from 1.
  std::uint64_t number() const { return number_; }

 private:
  std::string_view text_;
  std::size_t begin_ = 0;  ///< of the next line
  std::uint64_t number_ = 0;
};

/// Runs `work` and adds file and line to errors without them.
template <typename Work>
void at_line(const std::string& file, const LineWalk& lines, const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    if (!error.parts().file.empty()) throw;
    Error::Parts parts = error.parts();
    parts.file = file;
    parts.location = fmt::format("line {}", lines.number());
    throw Error(parts);
  }
}

/// Splits a line at blanks, tabs and commas. Errors, without file and location: a missing or invalid field.
class FieldWalk {
 public:
  explicit FieldWalk(std::string_view line) : rest_(line) {}

  bool at_end();
  std::string_view word(const char* what);
  double number(const char* what);  ///< finite
  std::uint64_t whole_number(const char* what, std::uint64_t most);
  /// The rest of the line without blanks around it.
  std::string_view rest();

 private:
  std::string_view rest_;
};

/// A finite number and nothing else, with equal bits on every machine. Errors: as FieldWalk.
double number_of(std::string_view text, const char* what);

struct ImageFileSize {
  std::uint64_t width = 0, height = 0;
};

/// Size in pixels of a PNG or JPEG file as it is stored: an EXIF orientation is not applied. A name without
/// an extension also finds the file with .png, .jpg or .jpeg appended. Errors: no such file, another format,
/// damage. Cost: reads some bytes at the beginning, of a JPEG at the beginning of each segment.
ImageFileSize image_file_size(const std::filesystem::path& file);

/// Size in pixels of a PNG or JPEG file that is open.
ImageFileSize image_file_size(InputFile& file);

}  // namespace alidade::camera
