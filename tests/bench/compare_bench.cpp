// SPDX-License-Identifier: MIT
// compare_bench [WIDTH HEIGHT [REPEATS]]: measures the time of each metric for a pair of generated images
// (default: 4096 x 2160, five times each) and the memory that it needs beside the images. Prints the rows
// of a table in Markdown.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>

#include "compare/metrics/errors.h"
#include "compare/metrics/flip.h"
#include "compare/metrics/ssim.h"
#include "simulation/noise.h"
#include "tests/bench/process_memory.h"

namespace alidade {

using namespace compare;
using namespace simulation;

namespace {

/// Waves of several lengths, edges and grain, in codes of 8 bits or in light with a range of a thousand to
/// one.
ComparedImage generated(int width, int height, ColorEncoding encoding, std::uint64_t seed, double grain) {
  ComparedImage image;
  image.file = "generated";
  image.width = width;
  image.height = height;
  image.encoding = encoding;
  image.color_channels = 3;
  image.largest_code = encoding == ColorEncoding::display ? 255 : 0;
  image.color.reserve(3 * image.pixels());
  std::uint64_t counter = seed << 40;
  for (int y = 0; y < height; ++y) {
    const double wave = std::sin(y / 97.0) + std::sin(y / 13.0);
    for (int x = 0; x < width; ++x) {
      const bool in_tile = (x / 160 + y / 120) % 2 == 0;
      for (int channel = 0; channel < 3; ++channel) {
        const double ground = 0.5 + 0.1 * wave * (in_tile ? 1.0 : -1.0) + 0.1 * (channel - 1);
        const double value = std::clamp(ground + grain * (unit_of(mix_bits(counter++)) - 0.5), 0.0, 1.0);
        const double code = std::floor(255.0 * value + 0.5) / 255.0;
        image.color.push_back(
            static_cast<float>(encoding == ColorEncoding::display ? code : 0.01 * std::pow(1000.0, value)));
      }
    }
  }
  return image;
}

struct Pair {
  ComparedImage reference, test;
};

Pair pair_of(int width, int height, ColorEncoding encoding) {
  return {generated(width, height, encoding, 1, 0.05), generated(width, height, encoding, 2, 0.1)};
}

void measure(const char* what, int repeats, const std::function<double()>& work) {
  std::vector<double> seconds, processor_seconds;
  double figure = 0.0;
  bench::forget_peak();
  const std::size_t before = bench::process_memory().resident;
  for (int i = 0; i < repeats; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t processor_start = std::clock();
    figure = work();
    processor_seconds.push_back(static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC);
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  std::ranges::sort(seconds);
  std::ranges::sort(processor_seconds);
  const std::size_t peak = bench::process_memory().peak;
  std::printf("| %s | %.3f | %.3f | %.0f | %.6f |\n", what, seconds[seconds.size() / 2],
              processor_seconds[processor_seconds.size() / 2],
              1e-6 * static_cast<double>(peak > before ? peak - before : 0), figure);
  std::fflush(stdout);
}

void run(int width, int height, int repeats) {
  std::printf("| %d x %d | median s | of all processors | MB beside the images | figure |\n", width, height);
  std::printf("|---|--:|--:|--:|--:|\n");
  {
    const Pair pair = pair_of(width, height, ColorEncoding::display);
    measure("errors", repeats,
            [&] { return error_metrics(pair.reference, pair.test, ColorEncoding::display).psnr; });
    measure("errors in linear light", repeats,
            [&] { return error_metrics(pair.reference, pair.test, ColorEncoding::linear).psnr; });
    measure("SSIM and MS-SSIM", repeats, [&] { return similarity(pair.reference, pair.test).ssim; });
    measure("FLIP", repeats, [&] { return flip(pair.reference, pair.test).mean; });
    std::printf("| process with two images | | | %.0f | |\n",
                1e-6 * static_cast<double>(bench::process_memory().peak));
  }
  const Pair pair = pair_of(width, height, ColorEncoding::linear);
  int exposures = 0;
  measure("HDR-FLIP", repeats, [&] {
    const FlipResult result = flip(pair.reference, pair.test);
    exposures = result.exposures;
    return result.mean;
  });
  std::printf("\nHDR-FLIP went through %d exposures.\n", exposures);
}

}  // namespace
}  // namespace alidade

int main(int count, char** arguments) {
  const int width = count >= 3 ? std::atoi(arguments[1]) : 4096;
  const int height = count >= 3 ? std::atoi(arguments[2]) : 2160;
  const int repeats = count >= 4 ? std::atoi(arguments[3]) : 5;
  if (count == 2 || count > 4 || width < 1 || height < 1 || repeats < 1) {
    std::fprintf(stderr, "usage: compare_bench [WIDTH HEIGHT [REPEATS]]\n");
    return 2;
  }
  try {
    alidade::run(width, height, repeats);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "compare_bench: %s\n", error.what());
    return 2;
  }
  return 0;
}
