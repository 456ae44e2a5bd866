// SPDX-License-Identifier: MIT
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "octree/cloud/laz/corrupt_chunk.h"
#include "octree/cloud/laz/layered_codec.h"
#include "tests/fuzz/laz_fuzz_case.h"

namespace alidade {
namespace {

struct Codecs {
  explicit Codecs(const LazLayout& layout)
      : decoder(layout), of_positions(layout, LazLayers::positions()), encoder(layout) {}

  LayeredDecoder decoder, of_positions;
  LayeredEncoder encoder;
};

/// Codecs take longer to make than to use, and have to be as good as new for every chunk.
Codecs& codecs_for(const LazLayout& layout) {
  static std::vector<std::pair<LazLayout, std::unique_ptr<Codecs>>> known;
  for (const auto& [of, codecs] : known)
    if (of == layout) return *codecs;
  known.emplace_back(layout, std::make_unique<Codecs>(layout));
  return *known.back().second;
}

void fuzz_layered(std::span<const std::byte> input) {
  const test::LazCase laz = test::laz_case(input);
  const LazLayout layout = laz.layout(6);
  Codecs& codecs = codecs_for(layout);
  std::vector<std::byte> records(laz.point_count * layout.record_size());
  try {
    codecs.decoder.decode(laz.chunk, records);
  } catch (const CorruptChunk&) {
    return;
  }
  std::vector<std::byte> again(records.size());
  codecs.of_positions.decode(laz.chunk, again);
  for (std::size_t at = 0; at < records.size(); at += layout.record_size())
    if (std::memcmp(records.data() + at, again.data() + at, 12) != 0) std::abort();
  codecs.decoder.decode(codecs.encoder.encode(records), again);
  if (again != records) std::abort();
}

}  // namespace
}  // namespace alidade

// Any bytes as a layered LAZ chunk: CorruptChunk, or records whose positions alone are the same, and that are
// the same once encoded and decoded again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size >= alidade::test::k_laz_case_head) alidade::fuzz_layered(std::as_bytes(std::span(data, size)));
  return 0;
}
