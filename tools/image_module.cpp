// SPDX-License-Identifier: MIT
// The module that image_module() loads.
#include "tools/image_module.h"

extern "C" const alidade::tools::ImageModule* alidade_image_module() {
  static constexpr alidade::tools::ImageModule k_module;
  return &k_module;
}
