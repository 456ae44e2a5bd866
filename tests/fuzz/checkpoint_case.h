// SPDX-License-Identifier: MIT
#pragma once

#include "renderer/checkpoint.h"
#include "renderer/noise.h"

// The image whose checkpoints are fuzzed.

namespace alidade::test {

using namespace image;
using namespace camera;
using namespace renderer;

inline constexpr int k_checkpoint_width = 30, k_checkpoint_height = 13, k_checkpoint_samples = 40;

inline Fingerprint checkpoint_fingerprint() {
  return {{"picture", "a.png"}, {"seed", "1"}};
}

}  // namespace alidade::test
