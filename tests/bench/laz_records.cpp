// SPDX-License-Identifier: MIT
#include "tests/bench/laz_records.h"

#include <cmath>
#include <random>

#include "base/bytes.h"
#include "cloud/las/las_header.h"

namespace alidade::bench {
namespace {

constexpr int k_pulses_per_line = 600;
constexpr double k_pulse_seconds = 5e-6;

struct Return {
  std::int32_t x, y, z;  // centimetres
  unsigned number, count, intensity;
  double time;
};

void put_colors(std::byte* at, unsigned intensity) {
  for (std::size_t channel = 0; channel < 3; ++channel)
    store(at + 2 * channel, static_cast<std::uint16_t>((intensity * (3 + channel) / 4) << 8));
}

void put_legacy(std::byte* record, const Return& point) {
  record[14] = static_cast<std::byte>(point.number | point.count << 3);
  record[15] = static_cast<std::byte>(point.number == point.count ? 2 : 5);
  store(record + 18, std::uint16_t{7});
}

void put_new(std::byte* record, const Return& point) {
  record[14] = static_cast<std::byte>(point.number | point.count << 4);
  record[16] = static_cast<std::byte>(point.number == point.count ? 2 : 5);
  store(record + 20, std::uint16_t{7});
}

}  // namespace

std::vector<std::byte> scan_records(int point_format, std::size_t count) {
  const LasPointLayout& layout = k_las_point_layouts[static_cast<std::size_t>(point_format)];
  const std::size_t size = static_cast<std::size_t>(layout.size);
  std::vector<std::byte> records(count * size);
  std::mt19937_64 random(7);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  for (std::size_t pulse = 0, written = 0; written < count; ++pulse) {
    const double along = 0.5 * std::floor(static_cast<double>(pulse) / k_pulses_per_line);
    const double across = 0.4 * static_cast<double>(pulse % k_pulses_per_line);
    const double ground = 400.0 + 5.0 * std::sin(along / 40.0) + 3.0 * std::sin(across / 25.0);
    const bool tree = std::sin(along / 7.0) + std::sin(across / 6.0) > 1.0;
    const unsigned returns = tree ? 1 + static_cast<unsigned>(random() % 3) : 1;
    for (unsigned number = 1; number <= returns && written < count; ++number, ++written) {
      const double height = number == returns ? 0.0 : 12.0 * unit();
      const Return point{.x = static_cast<std::int32_t>(100.0 * (along + 0.03 * unit())),
                         .y = static_cast<std::int32_t>(100.0 * (across + 0.03 * unit())),
                         .z = static_cast<std::int32_t>(100.0 * (ground + height + 0.05 * unit())),
                         .number = number,
                         .count = returns,
                         .intensity = static_cast<unsigned>((tree ? 40.0 : 120.0) + 30.0 * unit()),
                         .time = 2e5 + k_pulse_seconds * static_cast<double>(pulse)};
      std::byte* const record = records.data() + written * size;
      store(record, point.x);
      store(record + 4, point.y);
      store(record + 8, point.z);
      store(record + 12, static_cast<std::uint16_t>(point.intensity));
      if (layout.legacy)
        put_legacy(record, point);
      else
        put_new(record, point);
      if (layout.gps_time >= 0) store(record + layout.gps_time, point.time);
      if (layout.color >= 0) put_colors(record + layout.color, point.intensity);
    }
  }
  return records;
}

}  // namespace alidade::bench
