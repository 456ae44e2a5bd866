// SPDX-License-Identifier: MIT
#include "tools/sql/load_options.h"

#include "tools/cloud_options.h"
#include "tools/message.h"
#include "tools/parse_size.h"

namespace alidade {

void add_load_options(CLI::App& command, LoadOptions& options) {
  add_value(
      command, "--memory", "SIZE",
      "for points while they are sorted: bytes, or a number with k, M, G or T (default: 1G); those of a "
      "larger cloud wait in a file without a name beside the output",
      [&options](const std::string& text) {
        constexpr std::size_t k_least = std::size_t{1} << 20;
        options.memory = parse_size(text);
        if (options.memory < k_least)
          throw CLI::ValidationError("expected at least 1M, found '" + text + "'");
      });
  add_choice<ColorDepth>(command, "--color-depth",
                         "bits in use of LAS colours (default: 8 if none exceeds 255); 16 are stored",
                         options.color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  add_partial(command, options.partial);
  add_threads(command, options.threads);
  add_verbosity(command, options.verbosity);
}

void load_with_progress(const LoadOptions& options, const std::string& storing,
                        const std::function<std::vector<std::string>(const ReadOptions& reading,
                                                                     const Progress& storing)>& work) {
  const Verbosity verbosity = options.verbosity.verbosity();
  ProgressLine read_line("reading", "B", verbosity);
  std::optional<ProgressLine> store_line;
  Progress store_progress;
  const ReadOptions reading{.color_depth = options.color_depth.value_or(ColorDepth::automatic),
                            .partial = options.partial,
                            .progress = read_line.callback()};
  const std::vector<std::string> warnings = work(reading, [&](std::uint64_t done, std::uint64_t total) {
    if (!store_line) {
      read_line.finish();
      store_line.emplace(storing, "points", verbosity);
      store_progress = store_line->callback();
    }
    return store_progress(done, total);
  });
  if (store_line) store_line->finish();
  if (verbosity == Verbosity::quiet) return;
  for (const std::string& warning : warnings) say_warning(warning);
}

}  // namespace alidade
