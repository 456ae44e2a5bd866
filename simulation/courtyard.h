// SPDX-License-Identifier: MIT
#pragma once

#include "simulation/site.h"

namespace alidade {

/// The sample site: a courtyard between four wings with a gateway, in UTM-like coordinates. Always the same.
/// Cost: about a tenth of a second.
Site courtyard();

}  // namespace alidade
