// SPDX-License-Identifier: MIT
// The module that image/backend.cpp loads.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <ft2build.h>
#include <algorithm>
#include FT_FREETYPE_H

#include "image/backend.h"

namespace alidade::image {
namespace {

OIIO::TypeDesc type_desc(ValueType type) {
  switch (type) {
    case ValueType::uint8:
      return OIIO::TypeUInt8;
    case ValueType::uint16:
      return OIIO::TypeUInt16;
    case ValueType::uint32:
      return OIIO::TypeUInt;
    case ValueType::half:
      return OIIO::TypeHalf;
    case ValueType::single:
      return OIIO::TypeFloat;
    case ValueType::other_float:
    case ValueType::other_integer:
      break;
  }
  return OIIO::TypeUnknown;
}

ValueType value_type(OIIO::TypeDesc type) {
  for (const ValueType known :
       {ValueType::uint8, ValueType::uint16, ValueType::uint32, ValueType::half, ValueType::single})
    if (type == type_desc(known)) return known;
  return type.is_floating_point() ? ValueType::other_float : ValueType::other_integer;
}

ImageHeader header_of(const OIIO::ImageSpec& spec, const char* format) {
  ImageHeader header;
  header.width = spec.width;
  header.height = spec.height;
  header.channel_count = spec.nchannels;
  header.type = value_type(spec.format);
  header.channel_names = spec.channelnames;
  for (const OIIO::TypeDesc& type : spec.channelformats) header.channel_types.push_back(value_type(type));
  header.depth = spec.depth;
  header.x = spec.x;
  header.y = spec.y;
  header.full_x = spec.full_x;
  header.full_y = spec.full_y;
  header.full_width = spec.full_width;
  header.full_height = spec.full_height;
  header.tile_width = spec.tile_width;
  header.tile_height = spec.tile_height;
  header.orientation = spec.get_int_attribute("Orientation", 1);
  header.is_deep = spec.deep;
  header.format = format;
  return header;
}

class OpenImage final : public ImageReader {
 public:
  /// `memory`: what the input reads from; null: the file.
  OpenImage(std::unique_ptr<OIIO::Filesystem::IOProxy> memory, std::unique_ptr<OIIO::ImageInput> input)
      : memory_(std::move(memory)),
        input_(std::move(input)),
        spec_(input_->spec()),
        header_(header_of(spec_, input_->format_name())) {}

  const ImageHeader& header() const override { return header_; }

  std::vector<std::pair<std::string, std::string>> texts(std::size_t longest) const override {
    std::vector<std::pair<std::string, std::string>> texts;
    for (const OIIO::ParamValue& attribute : spec_.extra_attribs) {
      if (static_cast<std::size_t>(attribute.datasize()) > longest ||
          attribute.type().basetype == OIIO::TypeDesc::PTR)
        continue;
      texts.emplace_back(attribute.name().string(), attribute.get_string());
    }
    return texts;
  }

  Failure read_all(ChannelRun channels, ValueType type, void* values, std::size_t stride) override {
    return failure(input_->read_image(0, 0, channels.begin, channels.end, type_desc(type), values,
                                      static_cast<OIIO::stride_t>(stride)));
  }

  Failure read_rows(int top, int bottom, ChannelRun channels, ValueType type, void* values) override {
    const int begin = spec_.y + top, end = spec_.y + bottom;
    if (spec_.tile_width == 0) {
      return failure(
          input_->read_scanlines(0, 0, begin, end, 0, channels.begin, channels.end, type_desc(type), values));
    }
    return failure(input_->read_tiles(0, 0, spec_.x, spec_.x + spec_.width, begin, end, 0, 1, channels.begin,
                                      channels.end, type_desc(type), values));
  }

 private:
  /// For TIFF files OpenImageIO returns success even where it reports that pixels are missing.
  Failure failure(bool is_read) {
    if (is_read && !input_->has_error()) return {};
    return input_->geterror();
  }

  std::unique_ptr<OIIO::Filesystem::IOProxy> memory_;
  std::unique_ptr<OIIO::ImageInput> input_;
  OIIO::ImageSpec spec_;
  ImageHeader header_;
};

OIIO::ImageSpec spec_of(const ImageToWrite& image) {
  OIIO::ImageSpec spec(image.width, image.height, image.channel_count, type_desc(image.type));
  if (!image.channel_names.empty()) spec.channelnames = image.channel_names;
  for (std::size_t i = 0; i < image.channel_names.size(); ++i) {
    if (image.channel_names[i] == "A") spec.alpha_channel = static_cast<int>(i);
    if (image.channel_names[i] == "Z") spec.z_channel = static_cast<int>(i);
  }
  for (const ValueType type : image.channel_types) spec.channelformats.push_back(type_desc(type));
  for (const auto& [key, value] : image.attributes)
    std::visit([&, &name = key](const auto& known) { spec.attribute(name, known); }, value);
  return spec;
}

/// A font of FreeType.
class OpenFont final : public FontFace {
 public:
  explicit OpenFont(const std::string& file) {
    is_open_ = FT_Init_FreeType(&library_) == 0 && FT_New_Face(library_, file.c_str(), 0, &face_) == 0 &&
               FT_IS_SCALABLE(face_);
  }
  ~OpenFont() override {
    if (face_ != nullptr) FT_Done_Face(face_);
    if (library_ != nullptr) FT_Done_FreeType(library_);
  }
  OpenFont(const OpenFont&) = delete;
  OpenFont& operator=(const OpenFont&) = delete;

  bool is_open() const { return is_open_; }

  void set_size(int pixels) override { FT_Set_Pixel_Sizes(face_, 0, static_cast<FT_UInt>(pixels)); }

  std::optional<Glyph> draw(char32_t character) override {
    // The light hints keep stems crisp from top to bottom and do not move characters sideways.
    if (FT_Load_Char(face_, character, FT_LOAD_RENDER | FT_LOAD_TARGET_LIGHT) != 0) return {};
    const FT_GlyphSlotRec_& glyph = *face_->glyph;
    constexpr int k_unit_bits = 6;
    return Glyph{.left = glyph.bitmap_left,
                 .top = glyph.bitmap_top,
                 .width = static_cast<int>(glyph.bitmap.width),
                 .height = static_cast<int>(glyph.bitmap.rows),
                 .pitch = glyph.bitmap.pitch,
                 .advance = static_cast<int>(glyph.advance.x >> k_unit_bits),
                 .covers = glyph.bitmap.buffer};
  }

 private:
  FT_Library library_ = nullptr;
  FT_Face face_ = nullptr;
  bool is_open_ = false;
};

class OpenImageIoBackend final : public Backend {
 public:
  std::unique_ptr<ImageReader> open_image(const std::string& file,
                                          std::optional<std::span<const std::byte>> bytes,
                                          std::string& failure) const override {
    OIIO::ImageSpec hints;
    hints.attribute("oiio:UnassociatedAlpha", 1);
    std::unique_ptr<OIIO::Filesystem::IOProxy> memory;
    if (bytes) {
      memory = std::make_unique<OIIO::Filesystem::IOMemReader>(bytes->data(), bytes->size());
      void* const proxy = memory.get();
      hints.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    }
    auto input = OIIO::ImageInput::open(file, &hints);
    if (input) return std::make_unique<OpenImage>(std::move(memory), std::move(input));
    failure = OIIO::geterror();
    return nullptr;
  }

  Failure encode(const ImageToWrite& image, const std::string& name,
                 const std::function<const std::byte*(int begin, int end)>& rows,
                 std::vector<unsigned char>& bytes) const override {
    // A whole number of OpenEXR's 16-row compression blocks; the copy of the image stays small.
    constexpr int k_rows_at_once = 64;
    OIIO::Filesystem::IOVecOutput encoded(bytes);
    const auto output = OIIO::ImageOutput::create(image.format);
    if (!output) return OIIO::geterror();
    if (!output->set_ioproxy(&encoded)) return image.format + " encoding failed";
    if (!output->open(name, spec_of(image))) return output->geterror();
    for (int begin = 0; begin < image.height; begin += k_rows_at_once) {
      const int end = std::min(begin + k_rows_at_once, image.height);
      if (!output->write_scanlines(begin, end, 0, OIIO::TypeUnknown, rows(begin, end)))
        return output->geterror();
    }
    if (!output->close()) return output->geterror();
    return {};
  }

  Failure resize(const float* source, int source_width, int source_height, float* target, int width,
                 int height, int channels) const override {
    // OpenImageIO only reads the source, though it requests a pointer that could be written through.
    const OIIO::ImageBuf from(OIIO::ImageSpec(source_width, source_height, channels, OIIO::TypeFloat),
                              const_cast<float*>(source));
    OIIO::ImageBuf to(OIIO::ImageSpec(width, height, channels, OIIO::TypeFloat), target);
    if (OIIO::ImageBufAlgo::resize(to, from)) return {};
    return to.geterror();
  }

  std::unique_ptr<FontFace> open_font(const std::string& file) const override {
    auto font = std::make_unique<OpenFont>(file);
    return font->is_open() ? std::move(font) : nullptr;
  }
};

}  // namespace
}  // namespace alidade::image

extern "C" __attribute__((visibility("default"))) const alidade::image::Backend* alidade_image_backend() {
  static const alidade::image::OpenImageIoBackend backend;
  return &backend;
}
