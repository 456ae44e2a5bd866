// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace alidade {

/// Points that a layered codec takes through one layer before it turns to the next: enough that a layer stays
/// in registers, few enough that the records stay in the cache.
inline constexpr std::size_t k_layered_block = 512;

}  // namespace alidade
