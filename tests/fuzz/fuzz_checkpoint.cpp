// SPDX-License-Identifier: MIT
// Any bytes as a checkpoint, as they are and with checksums made right: an Error, or a state that becomes a
// film.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "tests/fuzz/checkpoint_case.h"
#include "tests/support/seal_checkpoint.h"

namespace alidade {

using namespace image;
using namespace renderer;

namespace {

void use(std::span<const std::byte> bytes) {
  for (const bool with_noise : {false, true}) {
    ImageState state(test::k_checkpoint_width, test::k_checkpoint_height, with_noise);
    try {
      read_checkpoint(InputFile(bytes, "input"), test::checkpoint_fingerprint(), test::k_checkpoint_samples,
                      state);
    } catch (const Error&) {
      continue;
    }
    if (state.pass_end < 1 || state.pass_end > test::k_checkpoint_samples) std::abort();
    if (with_noise) {
      StopRule rule(0.1, 0.01);
      rule.apply(state);
      rule.expected_samples(state, 0, test::k_checkpoint_samples);
      reached_noise(state, 0.01);
    }
    if (reduced(state, 7).color.empty()) std::abort();
    Film film(test::k_checkpoint_width, test::k_checkpoint_height, {});
    move_into_film(state, with_noise, film);
    if (film.color.size() != film.count()) std::abort();
  }
}

}  // namespace
}  // namespace alidade

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = std::as_bytes(std::span(data, size));
  std::vector<std::byte> bytes(input.begin(), input.end());
  alidade::use(bytes);
  alidade::test::seal_checkpoint(bytes);
  alidade::use(bytes);
  return 0;
}
