// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

namespace alidade {

/// Decodes LZF, the compression inside PCD's binary_compressed: a control byte below 32 says how many literal
/// bytes less one follow; any other is a reference back: length - 2 in its upper three bits (7: a further
/// byte is added), distance
/// - 1 in its lower five bits and a byte that follows the length.
/// Fills `output` from `input`. Returns false unless both are used up exactly and every reference points into
/// what has been decoded. Cost: linear in the output.
bool decode_lzf(std::span<const std::byte> input, std::span<std::byte> output);

/// No LZF stream of n bytes decodes to more than this times n: three bytes give 264 at most.
constexpr std::size_t k_lzf_largest_ratio = 88;

}  // namespace alidade
