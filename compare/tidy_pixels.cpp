// SPDX-License-Identifier: MIT
#include "compare/tidy_pixels.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace alidade {
namespace {

enum class Grows { yes, no };

/// Set where any (grows) or every (shrinks) pixel of the window is set, as far as the window lies in the
/// picture.
std::uint8_t decide(int set_count, int window, Grows grows) {
  return grows == Grows::yes ? set_count > 0 : set_count == window;
}

/// Pixels of [place - gap, place + gap] that lie in [0, size).
int window_size(int place, int size, int gap) {
  return std::min(place + gap, size - 1) - std::max(place - gap, 0) + 1;
}

void along_rows(const std::vector<std::uint8_t>& from, std::vector<std::uint8_t>& to, int width, int gap,
                Grows grows) {
  for (std::size_t first = 0; first < from.size(); first += static_cast<std::size_t>(width)) {
    const std::uint8_t* const row = from.data() + first;
    int count = 0;
    for (int x = 0; x < std::min(gap, width); ++x) count += row[x];
    for (int x = 0; x < width; ++x) {
      if (x + gap < width) count += row[x + gap];
      if (x - gap - 1 >= 0) count -= row[x - gap - 1];
      to[first + static_cast<std::size_t>(x)] = decide(count, window_size(x, width, gap), grows);
    }
  }
}

void along_columns(const std::vector<std::uint8_t>& from, std::vector<std::uint8_t>& to, int width, int gap,
                   Grows grows) {
  const int height = static_cast<int>(from.size() / static_cast<std::size_t>(width));
  std::vector<int> counts(static_cast<std::size_t>(width), 0);
  const auto add = [&](int y, int sign) {
    if (y < 0 || y >= height) return;
    const std::uint8_t* const row = from.data() + static_cast<std::size_t>(y) * counts.size();
    for (std::size_t x = 0; x < counts.size(); ++x) counts[x] += sign * row[x];
  };
  for (int y = 0; y < gap; ++y) add(y, 1);
  for (int y = 0; y < height; ++y) {
    add(y + gap, 1);
    add(y - gap - 1, -1);
    const int window = window_size(y, height, gap);
    std::uint8_t* const row = to.data() + static_cast<std::size_t>(y) * counts.size();
    for (std::size_t x = 0; x < counts.size(); ++x) row[x] = decide(counts[x], window, grows);
  }
}

}  // namespace

std::vector<std::uint8_t> drop_specks(const std::vector<std::uint8_t>& set, int width, double least_density) {
  constexpr int k_reach = 2;
  const int height = static_cast<int>(set.size() / static_cast<std::size_t>(width));
  std::vector<std::uint8_t> result(set.size(), 0);
  tbb::parallel_for(0, height, [&](int y) {
    const int top = std::max(y - k_reach, 0), bottom = std::min(y + k_reach, height - 1);
    for (int x = 0; x < width; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
      if (set[pixel] == 0) continue;
      const int left = std::max(x - k_reach, 0), right = std::min(x + k_reach, width - 1);
      int count = 0;
      for (int v = top; v <= bottom; ++v)
        for (int u = left; u <= right; ++u)
          count += set[static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u)];
      result[pixel] = count >= least_density * (right - left + 1) * (bottom - top + 1);
    }
  });
  return result;
}

std::vector<std::uint8_t> close_gaps(const std::vector<std::uint8_t>& set, int width, int gap) {
  if (gap == 0) return set;
  std::vector<std::uint8_t> one(set.size()), other(set.size());
  along_rows(set, one, width, gap, Grows::yes);
  along_columns(one, other, width, gap, Grows::yes);
  along_rows(other, one, width, gap, Grows::no);
  along_columns(one, other, width, gap, Grows::no);
  return other;
}

}  // namespace alidade
