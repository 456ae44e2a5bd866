// SPDX-License-Identifier: MIT
#include "renderer/checkpoint.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
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
  PictureFingerprint fingerprint{};
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

constexpr CheckpointForm k_pictures = {.magic = {'A', 'L', 'I', 'D', 'P', 'A', 'R', 'T'},
                                       .name = "an Alidade checkpoint",
                                       .fixed_bytes = 80,
                                       .fingerprint_bytes = 72};

/// Bytes of the head, its checksum included; sets head_bytes.
std::vector<std::byte> encode_head(CheckpointHead& head) {
  std::vector<std::byte> bytes = checkpoint_head(k_pictures, head.fingerprint, [&head](std::byte* at) {
    for_each_field(head, [at](std::size_t byte, const auto& field) { store(at + byte, field); });
  });
  head.head_bytes = bytes.size();
  return bytes;
}

/// Errors: not a checkpoint; another byte order or version; cut short or too long; damaged.
CheckpointHead read_head(InputFile& file) {
  const std::vector<std::byte> bytes =
      read_checkpoint_head(file, k_pictures, [&file](const HeaderFields& fixed) {
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
  head.fingerprint = fingerprint_of(k_pictures, bytes, file.name());
  head.head_bytes = bytes.size();
  return head;
}

constexpr std::size_t k_tile_bytes = 16;

/// Calls `use` with the bytes of everything behind the head but the tiles, in the order of the file.
template <class State, class Use>
void for_each_array(State& state, const Use& use) {
  use(std::span(state.levels));
  for (auto& band : state.bands) {
    use(std::span(band.mean));
    use(std::span(band.met_count));
    use(std::span(band.squares));
    use(std::span(band.earlier));
  }
}

std::uint64_t rest_bytes(const PictureState& state) {
  std::uint64_t bytes = k_tile_bytes * state.tiles.size();
  for_each_array(state, [&](const auto& values) { bytes += values.size_bytes(); });
  return bytes;
}

/// Reads a mebibyte of the file at a time, so that checksums are those of whole blocks.
class BlockReader {
 public:
  BlockReader(InputFile& file, std::uint64_t position) : file_(file), position_(position) {}

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
    sums_.push_back(checksum(block_));
    return checksum(std::as_bytes(std::span(sums_)));
  }

 private:
  void fetch() {
    if (used_ > 0) sums_.push_back(checksum(block_));
    // One byte at least: beyond the file's end this is the error of a file that ends early.
    const std::uint64_t left = std::max<std::uint64_t>(file_.size() - std::min(position_, file_.size()), 1);
    block_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(left, k_checksum_block)));
    file_.read_at(position_, block_);
    position_ += block_.size();
    used_ = 0;
  }

  InputFile& file_;
  std::uint64_t position_;
  std::vector<std::byte> block_;
  std::vector<std::uint64_t> sums_;
  std::size_t used_ = 0;
};

void read_tiles(BlockReader& reader, const InputFile& file, int samples, PictureState& state) {
  std::vector<std::byte> bytes(k_tile_bytes * state.tiles.size());
  reader.take(bytes);
  for (std::size_t tile = 0; tile < state.tiles.size(); ++tile) {
    const std::byte* const at = bytes.data() + k_tile_bytes * tile;
    const auto reached = load<std::uint32_t>(at), stopped = load<std::uint32_t>(at + 4);
    if (reached > static_cast<std::uint32_t>(samples) || stopped > 1) {
      throw file_error(file.name(), fmt::format("corrupt checkpoint: invalid state of tile {}", tile),
                       fmt::format("at most {} samples, stopped 0 or 1", samples),
                       fmt::format("{} samples, stopped {}", reached, stopped));
    }
    state.tiles[tile] = {reached, stopped == 1, load<std::uint64_t>(at + 8)};
  }
}

void check_head(const InputFile& file, const CheckpointHead& head, const PictureFingerprint& fingerprint,
                int samples, const PictureState& state) {
  check_fingerprint(head.fingerprint, fingerprint, file.name());
  // The fingerprint says all this as well; what follows must not rely on a text.
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
  const std::uint64_t expected = head.head_bytes + rest_bytes(state);
  if (head.file_bytes != expected)
    throw file_error(file.name(), "corrupt checkpoint: wrong file size", fmt::format("{} bytes", expected),
                     std::to_string(head.file_bytes));
}

}  // namespace

void write_checkpoint(const std::filesystem::path& path, const PictureFingerprint& fingerprint, int samples,
                      const PictureState& state, double seconds) {
  CheckpointHead head{.width = static_cast<std::uint32_t>(state.grid.width()),
                      .height = static_cast<std::uint32_t>(state.grid.height()),
                      .with_noise = state.with_noise ? 1u : 0u,
                      .pass_end = static_cast<std::uint32_t>(state.pass_end),
                      .samples_taken = state.sample_count(),
                      .seconds = seconds,
                      .samples = static_cast<std::uint32_t>(samples),
                      .fingerprint = fingerprint};
  OutputFile file(path, true);
  file.write(encode_head(head));
  ChecksumBlocks blocks([&](std::span<const std::byte> block) { file.write(block); });
  for (const TileState& tile : state.tiles) {
    std::array<std::byte, k_tile_bytes> bytes{};
    store(bytes.data(), tile.samples);
    store<std::uint32_t>(bytes.data() + 4, tile.stopped ? 1 : 0);
    store(bytes.data() + 8, tile.ray_count);
    blocks.add(bytes);
  }
  for_each_array(state, [&](const auto& values) { blocks.add(std::as_bytes(values)); });
  blocks.end();
  head.rest_checksum = checksum(std::as_bytes(std::span(blocks.sums())));
  head.file_bytes = file.size();
  file.write_at(0, encode_head(head));
  file.commit();
}

void read_checkpoint(InputFile file, const PictureFingerprint& fingerprint, int samples,
                     PictureState& state) {
  const CheckpointHead head = read_head(file);
  check_head(file, head, fingerprint, samples, state);
  BlockReader reader(file, head.head_bytes);
  read_tiles(reader, file, samples, state);
  for_each_array(state, [&](const auto& values) { reader.take(std::as_writable_bytes(values)); });
  const std::uint64_t sum = reader.sum();
  if (sum != head.rest_checksum) {
    throw file_error(file.name(), "corrupt checkpoint: wrong checksum of the samples",
                     fmt::format("{:016x}", head.rest_checksum), fmt::format("{:016x}", sum));
  }
  state.pass_end = static_cast<int>(head.pass_end);
  state.seconds = head.seconds;
}

bool is_checkpoint(const std::filesystem::path& path) {
  InputFile file(path);
  return begins_as(file, k_pictures);
}

CheckpointSummary read_checkpoint_summary(const std::filesystem::path& path) {
  InputFile file(path);
  const CheckpointHead head = read_head(file);
  const double all = double{1} * head.width * head.height * head.samples;
  return {.picture = head.fingerprint.empty() ? "" : head.fingerprint.front().value,
          .samples_taken = head.samples_taken,
          .share = all > 0.0 ? std::clamp(static_cast<double>(head.samples_taken) / all, 0.0, 1.0) : 0.0,
          .seconds = head.seconds};
}

}  // namespace alidade::renderer
