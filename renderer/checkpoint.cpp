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
#include "base/fingerprint.h"
#include "base/input_file.h"
#include "base/output_file.h"
#include "renderer/picture_fingerprint.h"

namespace alidade::renderer {

/// The head of a checkpoint, field by field; renderer/checkpoint.h has its bytes.
struct CheckpointHead {
  std::uint64_t file_bytes = 0;
  std::uint64_t rest_checksum = 0;
  std::uint32_t width = 0, height = 0;
  bool with_noise = false;
  std::uint32_t pass_end = 0;
  std::uint64_t samples_taken = 0;
  double seconds = 0.0;
  std::uint32_t samples = 0;  ///< per pixel, in the end
  PictureFingerprint fingerprint;
  std::uint64_t head_bytes = 0;  ///< where the rest begins
};

namespace {

constexpr CheckpointForm k_pictures = {.magic = {'A', 'L', 'I', 'D', 'P', 'A', 'R', 'T'},
                                       .name = "an Alidade checkpoint",
                                       .fixed_bytes = 80,
                                       .fingerprint_bytes = 72};

/// Bytes of the head, its checksum included; sets head_bytes.
std::vector<std::byte> encode_head(CheckpointHead& head) {
  std::vector<std::byte> bytes = checkpoint_head(k_pictures, head.fingerprint, [&head](std::byte* at) {
    store(at + 16, head.file_bytes);
    store(at + 32, head.rest_checksum);
    store(at + 40, head.width);
    store(at + 44, head.height);
    store<std::uint32_t>(at + 48, head.with_noise ? 1 : 0);
    store(at + 52, head.pass_end);
    store(at + 56, head.samples_taken);
    store(at + 64, head.seconds);
    store(at + 76, head.samples);
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
  head.file_bytes = reader.get<std::uint64_t>(16);
  head.rest_checksum = reader.get<std::uint64_t>(32);
  head.width = reader.get<std::uint32_t>(40);
  head.height = reader.get<std::uint32_t>(44);
  const auto with_noise = reader.get<std::uint32_t>(48);
  reader.require(with_noise <= 1, 48, "corrupt checkpoint", "0 or 1", with_noise);
  head.with_noise = with_noise == 1;
  head.pass_end = reader.get<std::uint32_t>(52);
  head.samples_taken = reader.get<std::uint64_t>(56);
  head.seconds = reader.get<double>(64);
  reader.require(head.seconds >= 0.0 && head.seconds < 1e12, 64, "corrupt checkpoint", "seconds",
                 head.seconds);
  head.samples = reader.get<std::uint32_t>(76);
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

/// A mebibyte of the file at a time, so that checksums are those of whole blocks.
class Blocks {
 public:
  Blocks() { block_.reserve(k_checksum_block); }

  /// Room left in the block.
  std::size_t room() const { return k_checksum_block - block_.size(); }
  std::vector<std::byte>& block() { return block_; }
  void sum_block() {
    sums_.push_back(checksum(block_));
    block_.clear();
  }
  std::uint64_t sum() const { return checksum(std::as_bytes(std::span(sums_))); }

 private:
  std::vector<std::byte> block_;
  std::vector<std::uint64_t> sums_;
};

class BlockWriter {
 public:
  explicit BlockWriter(OutputFile& file) : file_(file) {}

  void add(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const std::size_t count = std::min(bytes.size(), blocks_.room());
      blocks_.block().insert(blocks_.block().end(), bytes.begin(),
                             bytes.begin() + static_cast<std::ptrdiff_t>(count));
      bytes = bytes.subspan(count);
      if (blocks_.room() == 0) put();
    }
  }
  /// Ends the last block and returns the checksum of all.
  std::uint64_t finish() {
    if (!blocks_.block().empty()) put();
    return blocks_.sum();
  }

 private:
  void put() {
    file_.write(blocks_.block());
    blocks_.sum_block();
  }

  OutputFile& file_;
  Blocks blocks_;
};

class BlockReader {
 public:
  BlockReader(InputFile& file, std::uint64_t position) : file_(file), position_(position) {}

  void take(std::span<std::byte> into) {
    while (!into.empty()) {
      if (used_ == blocks_.block().size()) fetch();
      const std::size_t count = std::min(into.size(), blocks_.block().size() - used_);
      std::memcpy(into.data(), blocks_.block().data() + used_, count);
      into = into.subspan(count);
      used_ += count;
    }
  }
  /// Once everything has been taken.
  std::uint64_t sum() {
    blocks_.sum_block();
    return blocks_.sum();
  }

 private:
  void fetch() {
    if (used_ > 0) blocks_.sum_block();
    // One byte at least: beyond the file's end this is the error of a file that ends early.
    const std::uint64_t left = std::max<std::uint64_t>(file_.size() - std::min(position_, file_.size()), 1);
    blocks_.block().resize(static_cast<std::size_t>(std::min<std::uint64_t>(left, k_checksum_block)));
    file_.read_at(position_, blocks_.block());
    position_ += blocks_.block().size();
    used_ = 0;
  }

  InputFile& file_;
  std::uint64_t position_;
  Blocks blocks_;
  std::size_t used_ = 0;
};

[[noreturn]] void fail(const InputFile& file, const std::string& problem, const std::string& expected,
                       const std::string& found) {
  throw Error({.file = file.name(), .problem = problem, .expected = expected, .found = found});
}

void read_tiles(BlockReader& reader, const InputFile& file, int samples, PictureState& state) {
  std::vector<std::byte> bytes(k_tile_bytes * state.tiles.size());
  reader.take(bytes);
  for (std::size_t tile = 0; tile < state.tiles.size(); ++tile) {
    const std::byte* const at = bytes.data() + k_tile_bytes * tile;
    const auto reached = load<std::uint32_t>(at), stopped = load<std::uint32_t>(at + 4);
    if (reached > static_cast<std::uint32_t>(samples) || stopped > 1) {
      fail(file, fmt::format("corrupt checkpoint: tile {}", tile), fmt::format("at most {} samples", samples),
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
      head.height != static_cast<std::uint32_t>(state.grid.height()) || head.with_noise != state.with_noise ||
      head.samples != static_cast<std::uint32_t>(samples)) {
    fail(file, "corrupt checkpoint: its sizes contradict its fingerprint",
         fmt::format("{} x {} pixels, {} samples", state.grid.width(), state.grid.height(), samples),
         fmt::format("{} x {} pixels, {} samples", head.width, head.height, head.samples));
  }
  if (head.pass_end < 1 || head.pass_end > head.samples) {
    fail(file, "corrupt checkpoint: samples in progress", fmt::format("1 to {}", head.samples),
         std::to_string(head.pass_end));
  }
  const std::uint64_t expected = head.head_bytes + rest_bytes(state);
  if (head.file_bytes != expected)
    fail(file, "corrupt checkpoint", fmt::format("{} bytes", expected), std::to_string(head.file_bytes));
}

}  // namespace

void write_checkpoint(const std::filesystem::path& path, const PictureFingerprint& fingerprint, int samples,
                      const PictureState& state, double seconds) {
  CheckpointHead head;
  head.width = static_cast<std::uint32_t>(state.grid.width());
  head.height = static_cast<std::uint32_t>(state.grid.height());
  head.with_noise = state.with_noise;
  head.pass_end = static_cast<std::uint32_t>(state.pass_end);
  head.samples_taken = state.sample_count();
  head.seconds = seconds;
  head.samples = static_cast<std::uint32_t>(samples);
  head.fingerprint = fingerprint;
  OutputFile file(path, true);
  file.write(encode_head(head));
  BlockWriter writer(file);
  for (const TileState& tile : state.tiles) {
    std::array<std::byte, k_tile_bytes> bytes{};
    store(bytes.data(), tile.samples);
    store<std::uint32_t>(bytes.data() + 4, tile.stopped ? 1 : 0);
    store(bytes.data() + 8, tile.ray_count);
    writer.add(bytes);
  }
  for_each_array(state, [&](const auto& values) { writer.add(std::as_bytes(values)); });
  head.rest_checksum = writer.finish();
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
    fail(file, "corrupt checkpoint: wrong checksum of the samples",
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
  CheckpointSummary summary;
  if (!head.fingerprint.empty()) summary.picture = head.fingerprint.front().value;
  summary.samples_taken = head.samples_taken;
  const double all = double{1} * head.width * head.height * head.samples;
  if (all > 0.0) summary.share = std::clamp(static_cast<double>(head.samples_taken) / all, 0.0, 1.0);
  summary.seconds = head.seconds;
  return summary;
}

}  // namespace alidade::renderer
