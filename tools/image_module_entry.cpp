// SPDX-License-Identifier: MIT
// The function of the module that image_module.cpp calls: the only one that it finds by its name.
#include "tools/image_module.h"

extern "C" const alidade::tools::ImageModule* alidade_image_module() {
  static constexpr alidade::tools::ImageModule k_module;
  return &k_module;
}
