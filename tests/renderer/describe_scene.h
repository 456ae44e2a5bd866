// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "renderer/scene.h"

namespace alidade::test {

using namespace geo;
using namespace camera;
using namespace renderer;

/// All that a scene holds, as text: equal texts for equal scenes, to the last bit of every number.
std::string describe(const Scene& scene);
std::string describe(const Camera& camera);

}  // namespace alidade::test
