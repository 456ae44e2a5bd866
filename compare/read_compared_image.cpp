// SPDX-License-Identifier: MIT
#include "compare/read_compared_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "image/backend.h"
#include "image/read_image.h"

namespace alidade::compare {
namespace {

/// How to go through the stored image so as to meet its pixels in upright order.
struct Walk {
  bool is_turned;                     ///< rows and columns are exchanged
  std::ptrdiff_t first, right, down;  ///< in pixels of the stored image
};

Walk walk_of(int orientation, std::ptrdiff_t width, std::ptrdiff_t height) {
  const bool is_turned = orientation >= 5;
  const bool from_right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_bottom = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  const std::ptrdiff_t first = (from_right ? width - 1 : 0) + (from_bottom ? (height - 1) * width : 0);
  const std::ptrdiff_t along = from_right ? -1 : 1, across = from_bottom ? -width : width;
  return {is_turned, first, is_turned ? across : along, is_turned ? along : across};
}

template <typename Value>
void turn(std::vector<Value>& values, const Walk& walk, std::ptrdiff_t width, std::ptrdiff_t height,
          std::ptrdiff_t components) {
  if (values.empty()) return;
  std::vector<Value> turned;
  turned.reserve(values.size());
  for (std::ptrdiff_t y = 0; y < height; ++y) {
    for (std::ptrdiff_t x = 0; x < width; ++x) {
      const auto begin = values.begin() + (walk.first + x * walk.right + y * walk.down) * components;
      turned.insert(turned.end(), begin, begin + components);
    }
  }
  values = std::move(turned);
}

/// Turns all layers as the EXIF field Orientation requests (1 to 8; others are taken as 1, upright).
/// Source: CIPA DC-008 (Exif 2.32), 4.6.5.1, tag 274: which side of the image row 0 and column 0 are.
void turn_upright(ComparedImage& image, int orientation) {
  if (orientation < 2 || orientation > 8) return;
  const Walk walk = walk_of(orientation, image.width, image.height);
  if (walk.is_turned) {
    std::swap(image.width, image.height);
    std::swap(image.origin_x, image.origin_y);
  }
  const std::ptrdiff_t width = image.width, height = image.height;
  turn(image.color, walk, width, height, 3);
  turn(image.alpha, walk, width, height, 1);
  turn(image.depth, walk, width, height, 1);
  turn(image.depth_sigma, walk, width, height, 1);
  turn(image.normals, walk, width, height, 3);
  turn(image.ids, walk, width, height, 1);
}

/// Profiles and thumbnails are bytes, not texts.
constexpr std::size_t k_longest_text = 4096;

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& problem,
                       const std::string& expected = {}, const std::string& found = {}) {
  throw Error({.file = file.string(), .problem = problem, .expected = expected, .found = found});
}

/// The channels of a file that the layers are in, by index; -1: missing.
struct ChannelIndices {
  std::array<int, 3> color{-1, -1, -1};
  std::array<int, 3> normal{-1, -1, -1};
  int alpha = -1, depth = -1, depth_sigma = -1, id = -1;
  int color_channels = 0;

  /// The layers that can be compared by themselves.
  std::array<int, 9> all() const {
    return {color[0], color[1], color[2], normal[0], normal[1], normal[2], alpha, depth, id};
  }
};

int index_of(const image::ImageHeader& header, std::string_view channel) {
  const auto found = std::ranges::find(header.channel_names, channel);
  return found == header.channel_names.end() ? -1 : static_cast<int>(found - header.channel_names.begin());
}

std::array<int, 3> three(const image::ImageHeader& header, const std::array<const char*, 3>& names) {
  std::array<int, 3> indices{};
  for (std::size_t i = 0; i < 3; ++i) indices[i] = index_of(header, names[i]);
  if (std::ranges::find(indices, -1) != indices.end()) return {-1, -1, -1};
  return indices;
}

ChannelIndices indices_of(const image::ImageHeader& header) {
  const bool has_named_channels = header.format == "openexr";
  ChannelIndices indices;
  indices.alpha = index_of(header, "A");
  indices.depth = index_of(header, "Z");
  indices.depth_sigma = index_of(header, "depth.sigma");
  indices.id = index_of(header, "id");
  indices.normal = three(header, {"N.X", "N.Y", "N.Z"});
  if (indices.normal[0] < 0) indices.normal = three(header, {"Nx", "Ny", "Nz"});
  indices.color = three(header, {"R", "G", "B"});
  // In formats without fixed names any three channels are colours.
  if (indices.color[0] < 0 && !has_named_channels && header.channel_count >= 3) indices.color = {0, 1, 2};
  indices.color_channels = indices.color[0] < 0 ? 0 : 3;
  if (indices.color_channels == 0) {
    const int grey = index_of(header, "Y") >= 0 || has_named_channels ? index_of(header, "Y") : 0;
    if (grey >= 0) {
      indices.color = {grey, grey, grey};
      indices.color_channels = 1;
    }
  }
  return indices;
}

void check(const image::ImageHeader& header, const std::filesystem::path& file) {
  if (header.is_deep || header.depth > 1) fail(file, "not a flat image", "one value per channel and pixel");
  if (header.width < 1 || header.height < 1 || header.channel_count < 1)
    fail(file, "the image has no pixels");
  const std::string found = image::size_text({header.width, header.height});
  const auto count = static_cast<std::uint64_t>(header.width) * static_cast<std::uint64_t>(header.height);
  if (count > k_most_compared_pixels)
    fail(file, "too large to compare", "at most " + std::to_string(k_most_compared_pixels) + " pixels",
         found);
}

/// Where the values of a channel go.
struct Target {
  int channel;
  std::vector<float>* layer;
  std::size_t components, component;
};

std::vector<Target> targets_of(const ChannelIndices& indices, ComparedImage& image) {
  std::vector<Target> targets;
  const auto add = [&](int channel, std::vector<float>& layer, std::size_t components, std::size_t i) {
    if (channel >= 0) targets.push_back({channel, &layer, components, i});
  };
  for (std::size_t i = 0; i < 3; ++i) add(indices.color[i], image.color, 3, i);
  for (std::size_t i = 0; i < 3; ++i) add(indices.normal[i], image.normals, 3, i);
  add(indices.alpha, image.alpha, 1, 0);
  add(indices.depth, image.depth, 1, 0);
  add(indices.depth_sigma, image.depth_sigma, 1, 0);
  return targets;
}

/// The wanted channels as runs of at most so many. A few others between them are read along, since compressed
/// blocks are decoded again for each run.
std::vector<image::ChannelRun> runs_of(const std::vector<Target>& targets, int longest) {
  constexpr int k_widest_gap = 4;
  std::vector<int> channels;
  for (const Target& target : targets) channels.push_back(target.channel);
  std::ranges::sort(channels);
  std::vector<image::ChannelRun> runs;
  for (const int channel : channels) {
    if (!runs.empty() && channel - runs.back().end <= k_widest_gap && channel < runs.back().begin + longest) {
      runs.back().end = channel + 1;
    } else {
      runs.push_back({channel, channel + 1});
    }
  }
  return runs;
}

/// The whole number in a channel of floating point. Errors: another number, or one so large that its
/// neighbours become equal in the stored type.
std::uint32_t whole_id(float value, image::ValueType stored) {
  const float limit = stored == image::ValueType::half ? 2048.0f : 16777216.0f;
  if (value >= 0.0f && value < limit && value == std::floor(value)) return static_cast<std::uint32_t>(value);
  throw Error({.problem = "the id layer contains a value that is not an integer",
               .expected = "32-bit ids, or ids below " + std::to_string(static_cast<int>(limit)) +
                           " as floating point",
               .found = std::to_string(value)});
}

/// Reads bands of rows, and hands their values to the layers of an image.
class BandReader {
 public:
  BandReader(image::ImageReader& reader, const ChannelIndices& indices, ComparedImage& image)
      : reader_(reader),
        header_(reader.header()),
        image_(image),
        targets_(targets_of(indices, image)),
        id_(indices.id),
        width_(static_cast<std::size_t>(header_.width)) {
    // Both counted in values.
    constexpr std::size_t k_usual = std::size_t{1} << 23, k_most = std::size_t{1} << 25;
    const std::size_t wanted = std::max<std::size_t>(1, targets_.size());
    const auto fitting_rows = [&](std::size_t values) {
      return static_cast<int>(std::clamp<std::size_t>(values / width_, 1, k_usual));
    };
    // Bands end where blocks of tiles or of compressed rows do. Wide rows are decoded more than once, since a
    // whole block would be too much; tiles can only be read as a whole, so their channels come one by one.
    const int block = header_.tile_width > 0 ? std::min(header_.tile_height, header_.height) : 64;
    rows_ = std::max(block, fitting_rows(k_usual / wanted) / block * block);
    if (header_.tile_width == 0) rows_ = std::min(rows_, fitting_rows(k_most));
    rows_ = std::min(rows_, header_.height);
    const std::size_t longest = k_most / (width_ * static_cast<std::size_t>(rows_));
    runs_ = runs_of(targets_, static_cast<int>(std::clamp<std::size_t>(longest, 1, 16)));
  }

  /// `file_size`, bytes, is for an estimate of how many pixels will come.
  void read(std::uint64_t file_size) {
    reserve(file_size);
    for (int top = 0; top < header_.height; top += rows_) {
      const int bottom = std::min(top + rows_, header_.height);
      for (const image::ChannelRun run : runs_) read_run(top, bottom, run);
      if (id_ >= 0) read_ids(top, bottom);
    }
  }

 private:
  /// Growing takes twice the memory for a while, which only images of one colour should need.
  void reserve(std::uint64_t file_size) {
    constexpr std::uint64_t k_likely_pixels_per_byte = 64;
    const std::uint64_t likely =
        std::min<std::uint64_t>(image_.pixels(), k_likely_pixels_per_byte * file_size);
    for (const Target& target : targets_) target.layer->reserve(target.components * likely);
    if (id_ >= 0) image_.ids.reserve(likely);
  }

  void read_run(int top, int bottom, image::ChannelRun run) {
    const auto stride = static_cast<std::size_t>(run.end - run.begin);
    const std::size_t first = width_ * static_cast<std::size_t>(top),
                      count = width_ * static_cast<std::size_t>(bottom - top);
    values_.resize(count * stride);
    read_band(top, bottom, run, image::ValueType::single, values_.data());
    for (const Target& target : targets_) {
      if (target.channel < run.begin || target.channel >= run.end) continue;
      target.layer->resize(target.components * (first + count));
      const float* const from = values_.data() + (target.channel - run.begin);
      float* const to = target.layer->data() + first * target.components + target.component;
      for (std::size_t i = 0; i < count; ++i) to[i * target.components] = from[i * stride];
    }
  }

  /// Ids beyond 2^24 would not survive as floats, and floats not as whole numbers: those would represent
  /// parts of 1.
  void read_ids(int top, int bottom) {
    const std::size_t first = width_ * static_cast<std::size_t>(top),
                      count = width_ * static_cast<std::size_t>(bottom - top);
    const image::ValueType stored = header_.type_of(id_);
    const image::ChannelRun run{id_, id_ + 1};
    if (!image::is_float(stored)) {
      image_.ids.resize(first + count);
      read_band(top, bottom, run, image::ValueType::uint32, image_.ids.data() + first);
      return;
    }
    values_.resize(count);
    read_band(top, bottom, run, image::ValueType::single, values_.data());
    for (const float value : values_) image_.ids.push_back(whole_id(value, stored));
  }

  void read_band(int top, int bottom, image::ChannelRun run, image::ValueType type, void* values) {
    const image::Failure failure = reader_.read_rows(top, bottom, run, type, values);
    if (failure) throw Error({.problem = "the image has missing pixels: " + image::image_trouble(*failure)});
  }

  image::ImageReader& reader_;
  const image::ImageHeader& header_;
  ComparedImage& image_;
  std::vector<Target> targets_;
  int id_ = -1;
  std::size_t width_ = 0;
  int rows_ = 1;
  std::vector<image::ChannelRun> runs_;
  std::vector<float> values_;
};

int largest_code_of(image::ValueType type) {
  if (type == image::ValueType::uint8) return 255;
  return type == image::ValueType::uint16 ? 65535 : 0;
}

std::vector<float> filtered(const ComparedImage& image, const std::vector<float>& values, int channels,
                            int width, int height) {
  std::vector<float> result(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                            static_cast<std::size_t>(channels));
  const image::Failure failure = image::backend().resize(values.data(), image.width, image.height,
                                                         result.data(), width, height, channels);
  if (failure) throw Error({.file = image.file.string(), .problem = "cannot resize the image: " + *failure});
  return result;
}

/// The filter swings below black beside bright pixels, which tone mappers would show as white rings. Nothing
/// becomes darker than black, or than the darkest pixel where the image itself has light below 0.
void end_below(std::vector<float>& color, const std::vector<float>& source) {
  float least = 0.0f;
  for (const float value : source)
    if (std::isfinite(value)) least = std::min(least, value);
  for (float& value : color)
    if (value < least) value = least;
}

template <typename Value>
std::vector<Value> nearest(const ComparedImage& image, const std::vector<Value>& values, int components,
                           int width, int height) {
  std::vector<Value> result;
  if (values.empty()) return result;
  result.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                 static_cast<std::size_t>(components));
  for (int y = 0; y < height; ++y) {
    const std::int64_t from_y = (2 * std::int64_t{y} + 1) * image.height / (2 * std::int64_t{height});
    for (int x = 0; x < width; ++x) {
      const std::int64_t from_x = (2 * std::int64_t{x} + 1) * image.width / (2 * std::int64_t{width});
      const auto begin = values.begin() + (from_y * image.width + from_x) * components;
      result.insert(result.end(), begin, begin + components);
    }
  }
  return result;
}

}  // namespace

ComparedImage read_compared_image(const std::filesystem::path& file) {
  const std::uint64_t file_size = image::image_file_size(file);
  std::string failure;
  const auto reader = image::backend().open_image(file.string(), {}, failure);
  if (!reader) fail(file, "cannot read the image: " + image::image_trouble(failure));
  const image::ImageHeader& header = reader->header();
  check(header, file);
  const ChannelIndices indices = indices_of(header);
  if (std::ranges::all_of(indices.all(), [](int channel) { return channel < 0; }))
    fail(file, "nothing to compare", "channels R G B, Y, A, Z, N.X N.Y N.Z or id");

  ComparedImage image;
  image.file = file;
  image.width = header.width;
  image.height = header.height;
  image.origin_x = header.x - header.full_x;
  image.origin_y = header.y - header.full_y;
  image.color_channels = indices.color_channels;
  const image::ValueType type = header.type_of(std::max(indices.color[0], 0));
  image.encoding = image::is_float(type) ? ColorEncoding::linear : ColorEncoding::display;
  image.largest_code = largest_code_of(type);
  image.metadata = reader->texts(k_longest_text);
  try {
    BandReader(*reader, indices, image).read(file_size);
  } catch (const Error& error) {
    fail(file, error.what());
  }
  turn_upright(image, header.orientation);
  return image;
}

std::uint64_t claimed_pixels(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return 0;
  std::string failure;
  const auto reader = image::backend().open_image(file.string(), {}, failure);
  if (!reader) return 0;
  const image::ImageHeader& header = reader->header();
  return static_cast<std::uint64_t>(std::max(header.width, 0)) *
         static_cast<std::uint64_t>(std::max(header.height, 0));
}

ComparedImage resized(const ComparedImage& image, int width, int height) {
  const auto pixels =
      static_cast<std::uint64_t>(std::max(width, 0)) * static_cast<std::uint64_t>(std::max(height, 0));
  if (width < 1 || height < 1 || pixels > k_most_compared_pixels) {
    throw Error(image.file.string(), {}, "cannot resize the image",
                "a size of 1 to " + std::to_string(k_most_compared_pixels) + " pixels",
                image::size_text({width, height}));
  }
  ComparedImage result = in_size(image, width, height);
  if (!image.color.empty()) result.color = filtered(image, image.color, 3, width, height);
  if (!image.alpha.empty()) result.alpha = filtered(image, image.alpha, 1, width, height);
  if (image.encoding == ColorEncoding::display)
    for (float& value : result.color) value = std::clamp(value, 0.0f, 1.0f);
  else
    end_below(result.color, image.color);
  for (float& value : result.alpha) value = std::clamp(value, 0.0f, 1.0f);
  result.depth = nearest(image, image.depth, 1, width, height);
  result.depth_sigma = nearest(image, image.depth_sigma, 1, width, height);
  result.normals = nearest(image, image.normals, 3, width, height);
  result.ids = nearest(image, image.ids, 1, width, height);
  return result;
}

}  // namespace alidade::compare
