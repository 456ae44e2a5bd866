// SPDX-License-Identifier: MIT
#include "base/error.h"
#include "base/words.h"
#include "simulation/courtyard.h"
#include "tools/command.h"

namespace alidade::tools {
namespace {

// The index cannot number more (octree/build.h).
constexpr std::uint64_t k_most_points = 4'294'967'295;

struct GenerateCommand : RunRequest {
  std::filesystem::path output;
  simulation::GenerateOptions options;
};

ExitCode run_courtyard(const GenerateCommand& command) {
  if (command.output.has_extension() && !has_extension(command.output, {".las", ".laz"}))
    throw file_error(command.output, "unknown output format", "the extension .las or .laz");
  check_writable(command.output, command.options.overwrite);
  with_progress("scanning", "points", command.verbosity, [&](const Progress& progress) {
    simulation::GenerateOptions options = command.options;
    options.progress = progress;
    simulation::generate_courtyard(command.output, options);
  });
  return ExitCode::done;
}

}  // namespace

Command add_generate(const Options& program) {
  auto command = std::make_shared<GenerateCommand>();
  const Options generate = program.command("generate", "Scan a simulated site into a LAS or LAZ file");
  generate.required().value(
      "site", "courtyard",
      "the site: a courtyard with houses, trees, lamp posts and a car, scanned from the ground and "
      "from the air",
      [](const std::string& text) {
        if (text != "courtyard") throw UsageError("invalid value; expected courtyard, found '" + text + "'");
      });
  generate.required().file("-o,--output", "FILE.las|FILE.laz",
                           "output: LAS 1.4, or LAZ by the extension; metres, UTM zone 32N", command->output);
  generate.count("--points", "N", "exact number of points, such as 2e6 (default 2e6; up to 4294967295)",
                 command->options.point_count, 1, k_most_points);
  generate.count("--seed", "N",
                 "seed of the range noise; the same seed and count give the same bytes (default 1)",
                 command->options.seed, 0, UINT64_MAX);
  generate.flag("--overwrite", "replace an existing output", command->options.overwrite);
  add_threads(generate, command->threads);
  add_verbosity(generate, command->verbosity);
  return command_of(generate, command, run_courtyard);
}

}  // namespace alidade::tools
