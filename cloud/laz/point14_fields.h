// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/bytes.h"

/// Where the fields of the item POINT14, which all records of formats 6-10 begin with, stand: bytes.
namespace alidade::point14 {

inline constexpr std::size_t k_x = 0;
inline constexpr std::size_t k_y = 4;
inline constexpr std::size_t k_z = 8;
inline constexpr std::size_t k_intensity = 12;
inline constexpr std::size_t k_returns = 14;  ///< return number in bits 0-3, number of returns in bits 4-7
inline constexpr std::size_t k_flags = 15;    ///< bits 0-3, 6 and 7; scanner channel in bits 4-5
inline constexpr std::size_t k_classification = 16;
inline constexpr std::size_t k_user_data = 17;
inline constexpr std::size_t k_scan_angle = 18;
inline constexpr std::size_t k_point_source = 20;
inline constexpr std::size_t k_gps_time = 22;
inline constexpr std::size_t k_size = 30;

inline constexpr unsigned k_channel_bits = 0x30;  ///< of the byte of flags

inline unsigned channel(const std::byte* record) {
  return (load<std::uint8_t>(record + k_flags) & k_channel_bits) >> 4;
}

inline void put_channel(std::byte* record, unsigned channel) {
  const unsigned flags = load<std::uint8_t>(record + k_flags) & ~k_channel_bits;
  store(record + k_flags, static_cast<std::uint8_t>(flags | channel << 4));
}

}  // namespace alidade::point14
