// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace alidade::image {

// What Alidade uses of OpenImageIO and FreeType. They bring some 250 libraries, which take longer to load
// than most commands to run. So a module of its own is linked with them (image/backend/openimageio.cpp), and
// is loaded at the first use. It contains no other code of Alidade.

/// The type of a channel's values in a file or in memory.
enum class ValueType {
  uint8,
  uint16,
  uint32,
  half,
  single,
  other_float,   ///< only in files that are read
  other_integer  ///< only in files that are read
};

constexpr bool is_float(ValueType type) {
  return type == ValueType::half || type == ValueType::single || type == ValueType::other_float;
}

/// Of the types that are written.
constexpr std::size_t bytes_of(ValueType type) {
  if (type == ValueType::uint8) return 1;
  return type == ValueType::uint16 || type == ValueType::half ? 2 : 4;
}

/// Size and channels of an image.
struct PixelLayout {
  int width = 0, height = 0, channel_count = 0;
  ValueType type = ValueType::uint8;         ///< holds the values of all channels
  std::vector<std::string> channel_names{};  ///< empty in an image to write: OpenImageIO's names
  std::vector<ValueType> channel_types{};    ///< empty: all are `type`

  ValueType type_of(int channel) const {
    const auto index = static_cast<std::size_t>(channel);
    return index < channel_types.size() ? channel_types[index] : type;
  }
  std::size_t pixel_bytes() const {
    std::size_t bytes = 0;
    for (int i = 0; i < channel_count; ++i) bytes += bytes_of(type_of(i));
    return bytes;
  }
};

/// What an image file states about its pixels.
struct ImageHeader : PixelLayout {
  int depth = 1;
  int x = 0, y = 0;            ///< where the pixels begin
  int full_x = 0, full_y = 0;  ///< where the image begins that they are a part of
  int full_width = 0, full_height = 0;
  int tile_width = 0, tile_height = 0;  ///< 0: the file has rows, not tiles
  int orientation = 1;                  ///< as in EXIF
  bool is_deep = false;
  std::string format{};  ///< OpenImageIO's name, such as "openexr"
};

/// An image to encode. Rows consist of pixels, each channel in its own type, without gaps.
struct ImageToWrite : PixelLayout {
  std::string format{};  ///< OpenImageIO's name
  /// Metadata and OpenImageIO's options, in the order in which they are written.
  std::vector<std::pair<std::string, std::variant<std::string, int>>> attributes{};
};

/// Channels `begin` to `end` - 1.
struct ChannelRun {
  int begin, end;
};

/// OpenImageIO's message, which may be empty, if it failed.
using Failure = std::optional<std::string>;

/// An image file that is being read.
class ImageReader {
 public:
  virtual ~ImageReader() = default;
  virtual const ImageHeader& header() const = 0;
  /// Metadata, without values of more than this many bytes.
  virtual std::vector<std::pair<std::string, std::string>> texts(std::size_t longest) const = 0;
  /// Reads these channels of all pixels, which are `stride` bytes apart in `values`.
  virtual Failure read_all(ChannelRun channels, ValueType type, void* values, std::size_t stride) = 0;
  /// Reads these channels of the rows `top` to `bottom` - 1, without gaps. In a file of tiles, both must be
  /// at the edge of a tile or of the image.
  virtual Failure read_rows(int top, int bottom, ChannelRun channels, ValueType type, void* values) = 0;
};

/// A glyph as an image: how much of each pixel it covers, 0 to 255.
struct Glyph {
  int left = 0, top = 0;  ///< from the pen to the image, to the right and up
  int width = 0, height = 0;
  int pitch = 0;                          ///< from row to row, in bytes
  int advance = 0;                        ///< from this pen to the next
  const unsigned char* covers = nullptr;  ///< valid until the next call
};

/// A font file of FreeType.
class FontFace {
 public:
  virtual ~FontFace() = default;
  virtual void set_size(int pixels) = 0;
  /// Empty if it cannot be drawn.
  virtual std::optional<Glyph> draw(char32_t character) = 0;
};

/// The libraries. Thread safe.
class Backend {
 public:
  /// Null, and the failure, if it is not an image. If `bytes` are given, they are the file, must outlive the
  /// reader, and `file` is their name. Colors are not multiplied by alpha.
  virtual std::unique_ptr<ImageReader> open_image(const std::string& file,
                                                  std::optional<std::span<const std::byte>> bytes,
                                                  std::string& failure) const = 0;
  /// Encodes into `bytes`. rows(begin, end) returns rows of pixels, each channel in its own type without
  /// gaps, valid until the next call; it is called from top to bottom. `name` is for messages.
  virtual Failure encode(const ImageToWrite& image, const std::string& name,
                         const std::function<const std::byte*(int begin, int end)>& rows,
                         std::vector<unsigned char>& bytes) const = 0;
  /// OpenImageIO's resize with its default filter. Both have `channels` values per pixel.
  virtual Failure resize(const float* source, int source_width, int source_height, float* target, int width,
                         int height, int channels) const = 0;
  /// Null if it is not a font with outlines.
  virtual std::unique_ptr<FontFace> open_font(const std::string& file) const = 0;

 protected:
  ~Backend() = default;
};

/// Loads the module, which stays loaded. It is found beside the object that contains this code, in the folder
/// where both are installed, or where the loader searches. Errors: it or a library that it requires is
/// missing.
const Backend& backend();

}  // namespace alidade::image
