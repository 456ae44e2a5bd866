// SPDX-License-Identifier: MIT

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "base/words.h"
#include "camera/formats/camera_file.h"

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

std::uint64_t number_at(std::span<const std::byte> bytes, std::size_t position, std::size_t count) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < count; ++i)
    number = number << 8 | std::to_integer<std::uint64_t>(bytes[position + i]);
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
  for (std::uint64_t position = 2; position < k_farthest_frame;) {
    const std::span<const std::byte> bytes = file.view_up_to(position, 9);
    if (bytes.size() < 9 || number_at(bytes, 0, 1) != 0xFF) return std::nullopt;
    const std::uint64_t marker = number_at(bytes, 1, 1);
    if (is_frame(marker)) return ImageFileSize{number_at(bytes, 7, 2), number_at(bytes, 5, 2)};
    if (marker == 0xFF) {
      position += 1;  // a filling byte
    } else if (marker == 0xDA || marker == 0xD9) {
      return std::nullopt;  // the picture or its end, without a frame before
    } else {
      position += 2 + number_at(bytes, 2, 2);
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

}  // namespace

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
  // A plus sign is written by some programs; from_chars does not take it.
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

}  // namespace alidade::camera
