// SPDX-License-Identifier: MIT
// checkpoint_seeds FOLDER: checkpoints with and without noise, as a start for fuzz_checkpoint.
#include <string>

#include "tests/fuzz/checkpoint_case.h"

namespace {

using namespace alidade;
using namespace alidade::renderer;

ImageState state_with(bool with_noise, std::uint32_t samples) {
  ImageState state(test::k_checkpoint_width, test::k_checkpoint_height, with_noise);
  state.pass_end = test::k_checkpoint_samples;
  for (std::size_t tile = 0; tile < state.tiles.size(); ++tile) {
    std::vector<PathResult> results(state.grid.box(tile).count() * (samples + tile));
    for (std::size_t i = 0; i < results.size(); ++i)
      results[i] = {Rgb(static_cast<float>(i * 40503 % 256) / 256.0f), i % 3 == 0, i % 5};
    add_samples(state, tile, results);
  }
  return state;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const std::filesystem::path folder = arguments[1];
  std::filesystem::create_directories(folder);
  int number = 0;
  for (const bool with_noise : {false, true}) {
    for (const std::uint32_t samples : {0u, 1u, 33u}) {
      write_checkpoint(folder / ("seed_" + std::to_string(number++)), test::checkpoint_fingerprint(),
                       test::k_checkpoint_samples, state_with(with_noise, samples), 1.5);
    }
  }
}
