// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "cloud/laz/laz_layout.h"

namespace alidade {

inline constexpr const char* k_laszip_user_id = "laszip encoded";
inline constexpr std::uint16_t k_laszip_record_id = 22204;

/// What the data of a record "laszip encoded" say. The items are checked: they are those of the point format
/// in their order, cover a record of `point_size` bytes, and have versions of rules that exist; old formats
/// are pointwise and new ones layered. With compressor none, nothing but the compressor is looked at.
/// Errors: whatever else, and more than k_most_laz_extra_bytes; they name `file_name` and `place`, where the
/// data stand in the file.
LazLayout parse_laszip_record(std::span<const std::byte> data, const std::string& file_name,
                              std::uint64_t place, int point_format, std::size_t point_size);

}  // namespace alidade
