// SPDX-License-Identifier: MIT
#include "simulation/courtyard.h"

#include "tools/command.h"
#include "tools/console.h"
#include "tools/options.h"

namespace alidade::tools {
namespace {

// More cannot be numbered by the index (octree/build.h).
constexpr std::uint64_t k_most_points = 4'294'967'295;

struct GenerateCommand {
  std::filesystem::path output;
  simulation::GenerateOptions options;
  std::optional<int> threads;
  VerbosityOptions verbosity;
};

ExitCode run_courtyard(const GenerateCommand& command) {
  check_writable(command.output, command.options.overwrite);
  ProgressLine line("scanning", "points", command.verbosity.verbosity());
  simulation::GenerateOptions options = command.options;
  options.progress = line.callback();
  with_threads(command.threads, [&] { simulation::generate_courtyard(command.output, options); });
  line.finish();
  return ExitCode::done;
}

}  // namespace

Command add_generate(CLI::App& program) {
  auto command = std::make_shared<GenerateCommand>();
  CLI::App* generate = program.add_subcommand("generate", "Scan a simulated site into a LAS or LAZ file");
  add_value(
      *generate, "site", "courtyard",
      "the site: a yard with houses, trees, lamp posts and a car, scanned from the ground and from the air",
      [](const std::string& text) {
        if (text != "courtyard") throw CLI::ValidationError("expected courtyard, found '" + text + "'");
      })
      ->required();
  generate
      ->add_option("-o,--output", command->output,
                   "LAS 1.4 or LAZ file to write, by the ending; metres, UTM zone 32N")
      ->option_text("FILE.las|FILE.laz")
      ->required();
  add_value(*generate, "--points", "N", "exact number of points, also as 2e6 (default 2e6; up to 4294967295)",
            [command](const std::string& text) {
              command->options.point_count = parse_count(text, 1, k_most_points);
            });
  add_value(*generate, "--seed", "N",
            "seed of the range noise; the same seed and count give the same bytes (default 1)",
            [command](const std::string& text) { command->options.seed = parse_count(text, 0, UINT64_MAX); });
  generate->add_flag("--overwrite", command->options.overwrite, "replace an existing output");
  add_threads(*generate, command->threads);
  add_verbosity(*generate, command->verbosity);
  generate->footer(
      "Form:\n"
      "  alidade generate courtyard -o FILE.las|FILE.laz [OPTIONS]\n"
      "\n"
      "The scan is written as it is made, in bounded memory: about 36 bytes of disk per point, fewer as "
      "LAZ.\n"
      "\n"
      "Examples:\n"
      "  alidade generate courtyard -o courtyard.las\n"
      "  alidade generate courtyard --points 2e8 --seed 7 -o large.las\n");
  return {generate, [command] { return run_courtyard(*command); }};
}

}  // namespace alidade::tools
