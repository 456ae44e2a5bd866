// SPDX-License-Identifier: MIT
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "octree/cloud/laz/corrupt_chunk.h"
#include "octree/cloud/laz/pointwise_codec.h"
#include "tests/fuzz/laz_fuzz_case.h"

namespace alidade {
namespace {

struct Codecs {
  explicit Codecs(const LazLayout& layout) : decoder(layout), encoder(layout) {}

  PointwiseDecoder decoder;
  PointwiseEncoder encoder;
};

/// Codecs take longer to make than to use, and have to be as good as new for every chunk.
Codecs& codecs_for(const LazLayout& layout) {
  static std::vector<std::pair<LazLayout, std::unique_ptr<Codecs>>> known;
  for (const auto& [of, codecs] : known)
    if (of == layout) return *codecs;
  known.emplace_back(layout, std::make_unique<Codecs>(layout));
  return *known.back().second;
}

void fuzz_pointwise(std::span<const std::byte> input) {
  const test::LazCase laz = test::laz_case(input);
  const LazLayout layout = laz.layout(0);
  Codecs& codecs = codecs_for(layout);
  const std::size_t size = layout.record_size();
  std::vector<std::byte> records(laz.point_count * size);
  try {
    codecs.decoder.start(laz.chunk);
    // In two parts, as long streams are read.
    const std::size_t first = laz.point_count / 2 * size;
    codecs.decoder.decode(std::span(records).first(first));
    codecs.decoder.decode(std::span(records).subspan(first));
  } catch (const CorruptChunk&) {
    return;
  }
  if (codecs.decoder.consumed() > laz.chunk.size()) std::abort();
  const std::vector<std::byte> chunk = codecs.encoder.encode(records);
  std::vector<std::byte> again(records.size());
  codecs.decoder.start(chunk);
  codecs.decoder.decode(again);
  if (again != records || codecs.decoder.consumed() != chunk.size()) std::abort();
}

}  // namespace
}  // namespace alidade

// Any bytes as a pointwise LAZ chunk: CorruptChunk, or records that are the same once encoded and decoded
// again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size >= alidade::test::k_laz_case_head) alidade::fuzz_pointwise(std::as_bytes(std::span(data, size)));
  return 0;
}
