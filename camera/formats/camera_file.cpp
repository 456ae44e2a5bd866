// SPDX-License-Identifier: MIT
#include "camera/formats/camera_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>

#include "base/words.h"

namespace alidade::camera {
namespace {

constexpr std::string_view k_blanks = " \t,\r";

[[noreturn]] void fail(const char* what, const std::string& expected, std::string_view found) {
  constexpr std::size_t k_longest = 40;
  std::string text(found.substr(0, k_longest));
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  throw input_error(std::string("invalid ") + what, expected, found.empty() ? "nothing" : "'" + text + "'");
}

// Source of both layouts: ISO/IEC 15948 (PNG), ITU-T T.81 annex B (JPEG). Numbers are big endian.

std::uint64_t number_at(std::span<const std::byte> bytes, std::size_t offset, std::size_t count) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < count; ++i)
    number = number << 8 | std::to_integer<std::uint64_t>(bytes[offset + i]);
  return number;
}

std::optional<ImageFileSize> png_size(InputFile& file) {
  constexpr char k_beginning[] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR";
  const std::span<const std::byte> bytes = file.view_up_to(0, 24);
  if (bytes.size() < 24 || std::memcmp(bytes.data(), k_beginning, 16) != 0) return std::nullopt;
  return ImageFileSize{number_at(bytes, 16, 4), number_at(bytes, 20, 4)};
}

/// The segment that begins a frame: C0 to CF but for DHT, JPG and DAC.
bool is_frame(std::uint64_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

std::optional<ImageFileSize> jpeg_size(InputFile& file) {
  const std::span<const std::byte> beginning = file.view_up_to(0, 2);
  if (beginning.size() < 2 || number_at(beginning, 0, 2) != 0xFFD8) return std::nullopt;
  // Photos carry thumbnails and profiles before the frame, of some megabytes at most.
  constexpr std::uint64_t k_farthest_frame = 64u << 20;
  for (std::uint64_t offset = 2; offset < k_farthest_frame;) {
    const std::span<const std::byte> bytes = file.view_up_to(offset, 9);
    if (bytes.size() < 9 || number_at(bytes, 0, 1) != 0xFF) return std::nullopt;
    const std::uint64_t marker = number_at(bytes, 1, 1);
    if (is_frame(marker)) return ImageFileSize{number_at(bytes, 7, 2), number_at(bytes, 5, 2)};
    if (marker == 0xFF) {
      offset += 1;  // a fill byte
    } else if (marker == 0xDA || marker == 0xD9) {
      return std::nullopt;  // image data or its end, without a frame before
    } else {
      offset += 2 + number_at(bytes, 2, 2);
    }
  }
  return std::nullopt;
}

std::filesystem::path existing(const std::filesystem::path& file) {
  std::error_code error;
  for (const char* const extension : {"", ".png", ".jpg", ".jpeg"}) {
    std::filesystem::path name = file;
    name += extension;
    if (std::filesystem::is_regular_file(name, error)) return name;
  }
  throw input_error("unknown image size, and the image file is missing",
                    "width and height, or the file " + file.string());
}

constexpr const char* k_colmap =
    "a COLMAP model, transforms.json, or a trajectory with quaternions (docs/cameras.md)";
constexpr const char* k_metashape =
    "its export as COLMAP (File > Export > Export Cameras, type Colmap), or transforms.json by "
    "'ns-process-data metashape'";

/// An export that is not supported, by words that its first bytes contain.
struct KnownExport {
  std::array<std::string_view, 3> marks;  ///< maybe empty
  const char* name;
  const char* remedy;
};

constexpr KnownExport k_exports[] = {
    {{"<document", "<chunk", "<sensor"}, "the XML of Agisoft Metashape", k_metashape},
    {{"xcr:", "", ""}, "the XMP of RealityCapture", k_colmap},
    {{"\"img_name\"", "\"rotation\"", "\"position\""},
     "the cameras.json of 3D Gaussian Splatting",
     "the COLMAP model that the splats were trained on, often in sparse/0"},
    {{"PinholeCamera", "\"extrinsic\"", ""},
     "the camera parameters of Open3D",
     "a camera file of Alidade or transforms.json"},
    {{"\"FeatureCollection\"", "\"translation\"", "\"rotation\""},
     "the shots.geojson of OpenDroneMap",
     "its opensfm/reconstruction.json"},
    {{"# Bundle file", "", ""}, "a bundle of Bundler", k_colmap},
    {{"NVM_V3", "", ""}, "a model of VisualSFM", k_colmap},
    {{"imageName", "Omega", "Kappa"}, "the external camera parameters of Pix4D", k_colmap},
    {{"PhotoID", "Omega", "Kappa"}, "the angles of Agisoft Metashape", k_metashape},
    {{"#name", "alt", "heading"},
     "the camera parameters of RealityCapture",
     "transforms.json by 'ns-process-data realitycapture', or a COLMAP model"},
    {{"yaw", "pitch", "roll"}, "a table of yaw, pitch and roll", k_colmap},
    {{"heading", "pitch", "roll"}, "a table of heading, pitch and roll", k_colmap},
};

}  // namespace

void set_size(Camera& camera, std::uint64_t width, std::uint64_t height) {
  constexpr std::uint64_t k_side = k_max_image_side;
  if (width < 1 || height < 1 || width > k_side || height > k_side || width * height > k_max_pixels) {
    throw input_error("image size out of range", "1 to 65536 pixels in each direction, at most 2^28 in total",
                      fmt::format("{} x {}", width, height));
  }
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
}

bool LineWalk::next(std::string_view& line) {
  if (begin_ == text_.size()) return false;
  const std::size_t end = std::min(text_.find_first_of("\r\n", begin_), text_.size());
  line = text_.substr(begin_, end - begin_);
  begin_ = end;
  for (const char character : {'\r', '\n'})
    if (begin_ < text_.size() && text_[begin_] == character) ++begin_;
  ++number_;
  return true;
}

double number_of(std::string_view text, const char* what) {
  // Some programs write a plus sign, which from_chars rejects.
  std::string_view digits = text;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value) ||
      digits.starts_with('+'))
    fail(what, "a number", text);
  return value;
}

bool FieldWalk::at_end() {
  rest_.remove_prefix(std::min(rest_.find_first_not_of(k_blanks), rest_.size()));
  return rest_.empty();
}

std::string_view FieldWalk::word(const char* what) {
  if (at_end()) fail(what, "one more value on this line", "");
  const std::size_t end = std::min(rest_.find_first_of(k_blanks), rest_.size());
  const std::string_view word = rest_.substr(0, end);
  rest_.remove_prefix(end);
  return word;
}

double FieldWalk::number(const char* what) {
  return number_of(word(what), what);
}

std::uint64_t FieldWalk::whole_number(const char* what, std::uint64_t most) {
  const std::string_view text = word(what);
  const std::optional<std::uint64_t> value = parse_count(text);
  if (!value || *value > most) fail(what, "an integer from 0 to " + std::to_string(most), text);
  return *value;
}

std::string_view FieldWalk::rest() {
  if (at_end()) return {};
  const std::string_view text = rest_.substr(0, rest_.find_last_not_of(" \t\r") + 1);
  rest_ = {};
  return text;
}

ImageFileSize image_file_size(InputFile& file) {
  if (const auto size = png_size(file)) return *size;
  if (const auto size = jpeg_size(file)) return *size;
  throw file_error(file.name(), "cannot read the image size", "a PNG or JPEG file");
}

ImageFileSize image_file_size(const std::filesystem::path& path) {
  InputFile file(existing(path));
  return image_file_size(file);
}

void reject_known_export(std::string_view start, const std::filesystem::path& file) {
  // Errors in a file of a format that is read are reported by its reader.
  for (const std::string_view own : {"qw", "look_at_x", "\"frames\"", "\"shots\"", "\"sfm_data_version\""})
    if (start.find(own) != start.npos) return;
  for (const KnownExport& known : k_exports) {
    const bool is_one = std::ranges::all_of(
        known.marks, [&](std::string_view mark) { return start.find(mark) != start.npos; });
    if (is_one) throw file_error(file, "cannot read " + std::string(known.name), known.remedy);
  }
}

}  // namespace alidade::camera
