// SPDX-License-Identifier: MIT
#include "renderer/checkpoint.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <vector>

#include "base/bytes.h"
#include "base/checkpoint.h"
#include "base/output_file.h"

namespace alidade::renderer {
namespace {

/// The head of a checkpoint; renderer/checkpoint.h has its bytes.
struct CheckpointHead {
  std::uint64_t file_bytes = 0;
  std::uint64_t rest_checksum = 0;
  std::uint32_t width = 0, height = 0;
  std::uint32_t with_noise = 0;
  std::uint32_t pass_end = 0;
  std::uint64_t samples_taken = 0;
  double seconds = 0.0;
  std::uint32_t samples = 0;  ///< per pixel, in the end
  Fingerprint fingerprint{};
  std::uint64_t head_bytes = 0;  ///< where the rest begins
};

/// Calls visit(byte, field) for every field of fixed size.
template <class Head, class Visit>
void for_each_field(Head& head, const Visit& visit) {
  visit(16, head.file_bytes);
  visit(32, head.rest_checksum);
  visit(40, head.width);
  visit(44, head.height);
  visit(48, head.with_noise);
  visit(52, head.pass_end);
  visit(56, head.samples_taken);
  visit(64, head.seconds);
  visit(76, head.samples);
}

constexpr CheckpointForm k_images = {.magic = {'A', 'L', 'I', 'D', 'P', 'A', 'R', 'T'},
                                     .name = "an Alidade checkpoint",
                                     .fixed_bytes = 80,
                                     .fingerprint_bytes = 72};

/// Bytes of the head, its checksum included; sets head_bytes.
std::vector<std::byte> encode_head(CheckpointHead& head) {
  std::vector<std::byte> bytes = checkpoint_head(k_images, head.fingerprint, [&head](std::byte* at) {
    for_each_field(head, [at](std::size_t byte, const auto& field) { store(at + byte, field); });
  });
  head.head_bytes = bytes.size();
  return bytes;
}

/// Errors: not a checkpoint; another byte order or version; cut short or too long; damaged.
CheckpointHead read_head(InputFile& file) {
  const std::vector<std::byte> bytes =
      read_checkpoint_head(file, k_images, [&file](const HeaderFields& fixed) {
        const auto size = fixed.get<std::uint64_t>(16);
        fixed.require(size == file.size(), 16, "corrupt checkpoint: wrong file size",
                      fmt::format("{} bytes", size), file.size());
      });
  const HeaderFields reader(bytes, file.name());
  CheckpointHead head;
  for_each_field(head, [&]<class Field>(std::size_t byte, Field& field) { field = reader.get<Field>(byte); });
  reader.require(head.with_noise <= 1, 48, "corrupt checkpoint: invalid noise flag", "0 or 1",
                 head.with_noise);
  reader.require(head.seconds >= 0.0 && head.seconds < 1e12, 64,
                 "corrupt checkpoint: render time out of range", "0 to 1e12 seconds", head.seconds);
  head.fingerprint = fingerprint_of(k_images, bytes, file.name());
  head.head_bytes = bytes.size();
  return head;
}

constexpr std::size_t k_tile_bytes = 16;

/// Tiles of a part as a checkpoint has them: row by row.
std::vector<std::size_t> tiles_by_row(std::vector<std::size_t> tiles) {
  std::ranges::sort(tiles);
  return tiles;
}

/// Calls use(first, count) for the pixels that some tiles of a row of tiles have in each row of pixels;
/// `first` counts from the start of the row of tiles.
template <class Use>
void for_each_run(const TileGrid& grid, std::span<const std::size_t> tiles, const Use& use) {
  if (tiles.empty()) return;
  const image::PixelBox band = grid.band(grid.row_of(tiles.front()));
  if (tiles.size() == static_cast<std::size_t>(grid.columns())) return use(std::size_t{0}, band.count());
  for (int y = 0; y < band.height(); ++y) {
    for (const std::size_t tile : tiles) {
      const image::PixelBox box = grid.box(tile);
      use(static_cast<std::size_t>(y) * static_cast<std::size_t>(band.width()) +
              static_cast<std::size_t>(box.left),
          static_cast<std::size_t>(box.width()));
    }
  }
}

/// Calls use(row, tiles) with those of each row of tiles.
template <class Use>
void for_each_row(const TileGrid& grid, std::span<const std::size_t> tiles, const Use& use) {
  for (int row = 0; row < grid.rows(); ++row) {
    const auto end = std::ranges::find_if(tiles, [&](std::size_t tile) { return grid.row_of(tile) != row; });
    const auto count = static_cast<std::size_t>(end - tiles.begin());
    use(row, tiles.first(count));
    tiles = tiles.subspan(count);
  }
}

/// Calls `use` with everything behind the head but the tiles, in the order of the file: spans of numbers.
/// `tiles` are in the order of tiles_by_row().
template <class State, class Film, class Use>
void for_each_array(State& state, Film& film, std::span<const std::size_t> tiles, const Use& use) {
  if (state.with_noise)
    for (const std::size_t tile : tiles) use(std::span(state.levels).subspan(tile, 1));
  const auto use_row = [&](std::span<const std::size_t> in_row, std::size_t start, auto& values) {
    if (values.empty()) return;
    for_each_run(state.grid, in_row, [&](std::size_t first, std::size_t count) {
      use(std::span(values).subspan(start + first, count));
    });
  };
  for_each_row(state.grid, tiles, [&](int row, std::span<const std::size_t> in_row) {
    auto& band = state.bands[static_cast<std::size_t>(row)];
    use_row(in_row, 0, band.mean);
    use_row(in_row, 0, band.met_count);
    use_row(in_row, 0, band.squares);
    use_row(in_row, 0, band.earlier);
  });
  for_each_row(state.grid, tiles, [&](int row, std::span<const std::size_t> in_row) {
    const std::size_t start = film.index(0, state.grid.band(row).top);
    use_row(in_row, start, film.depth);
    use_row(in_row, start, film.distance);
    use_row(in_row, start, film.normal);
    use_row(in_row, start, film.position);
    use_row(in_row, start, film.albedo);
    use_row(in_row, start, film.id);
    use_row(in_row, start, film.depth_sigma);
    use_row(in_row, start, film.coverage);
    use_row(in_row, start, film.support);
  });
}

std::uint64_t rest_bytes(const ImageState& state, const image::Film& film,
                         std::span<const std::size_t> tiles) {
  std::uint64_t bytes = k_tile_bytes * tiles.size();
  for_each_array(state, film, tiles, [&](const auto& values) { bytes += values.size_bytes(); });
  return bytes;
}

/// Reads a mebibyte of the file at a time, so that checksums are those of whole blocks.
class BlockReader {
 public:
  BlockReader(InputFile& file, std::uint64_t offset) : file_(file), offset_(offset) {}

  void take(std::span<std::byte> into) {
    while (!into.empty()) {
      if (used_ == block_.size()) fetch();
      const std::size_t count = std::min(into.size(), block_.size() - used_);
      std::memcpy(into.data(), block_.data() + used_, count);
      into = into.subspan(count);
      used_ += count;
    }
  }
  /// Once everything has been taken.
  std::uint64_t sum() {
    if (used_ > 0) sums_.push_back(checksum(block_));
    return checksum(std::as_bytes(std::span(sums_)));
  }

 private:
  void fetch() {
    if (used_ > 0) sums_.push_back(checksum(block_));
    // One byte at least: beyond the file's end this is the error of a file that ends early.
    const std::uint64_t left = std::max<std::uint64_t>(file_.size() - std::min(offset_, file_.size()), 1);
    block_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(left, k_checksum_block)));
    file_.read_at(offset_, block_);
    offset_ += block_.size();
    used_ = 0;
  }

  InputFile& file_;
  std::uint64_t offset_;
  std::vector<std::byte> block_;
  std::vector<std::uint64_t> sums_;
  std::size_t used_ = 0;
};

void read_tiles(BlockReader& reader, const InputFile& file, int samples, std::span<const std::size_t> tiles,
                ImageState& state) {
  std::vector<std::byte> bytes(k_tile_bytes * tiles.size());
  reader.take(bytes);
  const std::byte* at = bytes.data();
  for (const std::size_t tile : tiles) {
    const auto reached = load<std::uint32_t>(at), stopped = load<std::uint32_t>(at + 4);
    if (reached > static_cast<std::uint32_t>(samples) || stopped > 1) {
      throw file_error(file.name(), fmt::format("corrupt checkpoint: invalid state of tile {}", tile),
                       fmt::format("at most {} samples, stopped 0 or 1", samples),
                       fmt::format("{} samples, stopped {}", reached, stopped));
    }
    state.tiles[tile] = {reached, stopped == 1, load<std::uint64_t>(at + 8)};
    at += k_tile_bytes;
  }
}

/// Reads what is behind a head.
void read_rest(InputFile& file, std::uint64_t head_bytes, std::uint64_t rest_checksum, int samples,
               std::span<const std::size_t> tiles, ImageState& state, image::Film& film) {
  BlockReader reader(file, head_bytes);
  read_tiles(reader, file, samples, tiles, state);
  for_each_array(state, film, tiles,
                 [&](const auto& values) { reader.take(std::as_writable_bytes(values)); });
  const std::uint64_t sum = reader.sum();
  if (sum != rest_checksum) {
    throw file_error(file.name(), "corrupt checkpoint: wrong checksum of the samples",
                     fmt::format("{:016x}", rest_checksum), fmt::format("{:016x}", sum));
  }
}

void check_head(const InputFile& file, const CheckpointHead& head, const Fingerprint& fingerprint,
                int samples, std::span<const std::size_t> tiles, const ImageState& state) {
  check_fingerprint(head.fingerprint, fingerprint, file.name());
  // The fingerprint has all this as well; what follows must not rely on a text.
  if (head.width != static_cast<std::uint32_t>(state.grid.width()) ||
      head.height != static_cast<std::uint32_t>(state.grid.height()) ||
      (head.with_noise == 1) != state.with_noise || head.samples != static_cast<std::uint32_t>(samples)) {
    throw file_error(
        file.name(), "corrupt checkpoint: its sizes contradict its fingerprint",
        fmt::format("{} x {} pixels, {} samples", state.grid.width(), state.grid.height(), samples),
        fmt::format("{} x {} pixels, {} samples", head.width, head.height, head.samples));
  }
  if (head.pass_end < 1 || head.pass_end > head.samples) {
    throw file_error(file.name(), "corrupt checkpoint: number of unfinished samples out of range",
                     fmt::format("1 to {}", head.samples), std::to_string(head.pass_end));
  }
  const std::uint64_t expected = head.head_bytes + rest_bytes(state, image::Film(), tiles);
  if (head.file_bytes != expected)
    throw file_error(file.name(), "corrupt checkpoint: wrong file size", fmt::format("{} bytes", expected),
                     std::to_string(head.file_bytes));
}

void write_state(const std::filesystem::path& path, CheckpointHead head, const ImageState& state,
                 const image::Film& film, bool overwrite) {
  const std::vector<std::size_t> tiles = tiles_by_row(state.order);
  OutputFile file(path, overwrite);
  file.write(encode_head(head));
  ChecksumBlocks blocks([&](std::span<const std::byte> block) { file.write(block); });
  for (const std::size_t each : tiles) {
    const TileState& tile = state.tiles[each];
    std::array<std::byte, k_tile_bytes> bytes{};
    store(bytes.data(), tile.samples);
    store<std::uint32_t>(bytes.data() + 4, tile.stopped ? 1 : 0);
    store(bytes.data() + 8, tile.ray_count);
    blocks.add(bytes);
  }
  for_each_array(state, film, tiles, [&](const auto& values) { blocks.add(std::as_bytes(values)); });
  blocks.end();
  head.rest_checksum = checksum(std::as_bytes(std::span(blocks.sums())));
  head.file_bytes = file.size();
  file.write_at(0, encode_head(head));
  file.commit();
}

CheckpointHead head_of(const Fingerprint& fingerprint, int samples, const ImageState& state, double seconds) {
  return {.width = static_cast<std::uint32_t>(state.grid.width()),
          .height = static_cast<std::uint32_t>(state.grid.height()),
          .with_noise = state.with_noise ? 1u : 0u,
          .pass_end = static_cast<std::uint32_t>(state.pass_end),
          .samples_taken = state.sample_count(),
          .seconds = seconds,
          .samples = static_cast<std::uint32_t>(samples),
          .fingerprint = fingerprint};
}

/// Takes the part out of a fingerprint. Errors: it is invalid.
ImagePart take_part(Fingerprint& fingerprint, const std::string& file) {
  const auto entry = std::ranges::find(fingerprint, "part", &FingerprintEntry::name);
  ImagePart part;
  if (entry == fingerprint.end()) return part;
  const std::string text = entry->value;
  const char* const end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, part.number);
  if (number.ptr != end) std::from_chars(number.ptr + 1, end, part.count);
  fingerprint.erase(entry);
  if (part_text(part) == text && part.number >= 1 && part.number <= part.count && part.count <= k_most_parts)
    return part;
  throw file_error(file, "corrupt checkpoint: invalid part", "1/N to N/N");
}

}  // namespace

void write_checkpoint(const std::filesystem::path& path, const Fingerprint& fingerprint, int samples,
                      const ImageState& state, double seconds) {
  write_state(path, head_of(fingerprint, samples, state, seconds), state, image::Film(), true);
}

void write_part(const std::filesystem::path& path, const Fingerprint& fingerprint, int samples,
                const ImageState& state, const image::Film& film, bool overwrite) {
  CheckpointHead head = head_of(fingerprint, samples, state, 0.0);
  head.pass_end = head.samples;  // however it was reached
  write_state(path, head, state, film, overwrite);
}

void read_checkpoint(InputFile file, const Fingerprint& fingerprint, int samples, ImageState& state) {
  const std::vector<std::size_t> tiles = tiles_by_row(state.order);
  const CheckpointHead head = read_head(file);
  check_head(file, head, fingerprint, samples, tiles, state);
  image::Film none;
  read_rest(file, head.head_bytes, head.rest_checksum, samples, tiles, state, none);
  state.pass_end = static_cast<int>(head.pass_end);
  state.seconds = head.seconds;
}

PartHead read_part_head(const std::filesystem::path& path) {
  constexpr std::uint32_t k_most_side = 65536, k_most_pixels = 1u << 28;
  InputFile file(path);
  if (!begins_as(file, k_images))
    fail_at_byte(file.name(), 0, "not a part of an image", "a file that 'alidade render --part' wrote");
  CheckpointHead head = read_head(file);
  if (head.width < 1 || head.height < 1 || head.width > k_most_side || head.height > k_most_side ||
      std::uint64_t{head.width} * head.height > k_most_pixels || head.samples < 1 ||
      head.samples > static_cast<std::uint32_t>(k_max_samples)) {
    throw file_error(file.name(), "corrupt checkpoint: its sizes are out of range",
                     fmt::format("up to {} pixels with up to {} samples", k_most_pixels, k_max_samples),
                     fmt::format("{} x {} pixels, {} samples", head.width, head.height, head.samples));
  }
  PartHead part{.file = path.string(),
                .part = take_part(head.fingerprint, file.name()),
                .width = static_cast<int>(head.width),
                .height = static_cast<int>(head.height),
                .samples = static_cast<int>(head.samples),
                .with_noise = head.with_noise == 1,
                .samples_taken = head.samples_taken,
                .file_bytes = head.file_bytes,
                .head_bytes = head.head_bytes,
                .rest_checksum = head.rest_checksum};
  part.fingerprint = std::move(head.fingerprint);
  return part;
}

void read_part(const PartHead& head, ImageState& state, image::Film& film) {
  InputFile file{std::filesystem::path(head.file)};
  const std::vector<std::size_t> tiles = tiles_by_row(tiles_of(state.grid, head.part));
  const std::uint64_t expected = head.head_bytes + rest_bytes(state, film, tiles);
  if (head.file_bytes != expected) {
    throw file_error(file.name(), "corrupt checkpoint: wrong file size", fmt::format("{} bytes", expected),
                     std::to_string(head.file_bytes));
  }
  read_rest(file, head.head_bytes, head.rest_checksum, head.samples, tiles, state, film);
  for (const std::size_t tile : tiles) {
    if (state.tiles[tile].samples == static_cast<std::uint32_t>(head.samples)) continue;
    throw file_error(file.name(), fmt::format("corrupt part: tile {} is unfinished", tile),
                     fmt::format("{} samples", head.samples), std::to_string(state.tiles[tile].samples));
  }
}

bool is_checkpoint(const std::filesystem::path& path) {
  InputFile file(path);
  return begins_as(file, k_images);
}

CheckpointSummary read_checkpoint_summary(const std::filesystem::path& path) {
  InputFile file(path);
  const CheckpointHead head = read_head(file);
  Fingerprint fingerprint = head.fingerprint;
  const int parts = take_part(fingerprint, file.name()).count;
  // Parts differ by a tile at most.
  const double all = double{1} * head.width * head.height * head.samples / parts;
  return {.image = head.fingerprint.empty() ? "" : head.fingerprint.front().value,
          .samples_taken = head.samples_taken,
          .share = all > 0.0 ? std::clamp(static_cast<double>(head.samples_taken) / all, 0.0, 1.0) : 0.0,
          .seconds = head.seconds};
}

}  // namespace alidade::renderer
