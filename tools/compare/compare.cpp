// SPDX-License-Identifier: MIT
#include "jobs/compare/compare.h"

#include <fmt/format.h>
#include <algorithm>
#include <new>

#include "base/error.h"
#include "base/shown_text.h"
#include "compare/report/comparison_json.h"
#include "compare/verdict.h"
#include "tools/command.h"

namespace alidade::tools {
namespace {

struct CompareCommand : JobCommand<jobs::CompareRequest> {
  bool idiff_codes = false, json = false;
};

std::string facts_text(const char* side, const compare::ComparedImageFacts& facts) {
  return fmt::format("{:<10} {}  {} x {}, {}\n", side, line_text(facts.file.string()), facts.width,
                     facts.height,
                     facts.encoding == compare::ColorEncoding::display ? "display" : "linear light");
}

std::string regions_text(const compare::ChangeRegions& changes) {
  constexpr std::size_t k_most_lines = 10;
  std::string text = fmt::format("\nRegions of change: {}, with {} of {} changed pixels\n",
                                 changes.regions.size(), changes.listed_pixels, changes.changed_pixels);
  for (std::size_t i = 0; i < std::min(k_most_lines, changes.regions.size()); ++i) {
    const compare::ChangeRegion& region = changes.regions[i];
    text += fmt::format("  {:>3}  {} pixels in {},{},{},{}, strongest {:.4g} at {},{}\n", i + 1,
                        region.pixels, region.left, region.top, region.right, region.bottom, region.strongest,
                        region.x, region.y);
  }
  if (changes.regions.size() > k_most_lines)
    text += fmt::format("  and {} more, see --json or --report\n", changes.regions.size() - k_most_lines);
  return text;
}

/// The table that people read on a terminal.
std::string comparison_text(const compare::Comparison& comparison, const compare::Verdict& verdict) {
  std::string text = facts_text("reference", comparison.reference) + facts_text("test", comparison.test);
  text += fmt::format("{:<10} {} of {} pixels", "counted", comparison.counted, comparison.pixels);
  text += comparison.excluded > 0 ? fmt::format(", {} of them without finite colours\n", comparison.excluded)
                                  : "\n";
  std::string_view group;
  for (const compare::Metric& metric : compare::metrics_of(comparison)) {
    if (metric.kind->group != group) {
      group = metric.kind->group;
      text += fmt::format("\n{}\n", group);
    }
    text += fmt::format("  {:<18} {:>12.6g} {:<4} {}\n", metric.kind->name, metric.value, metric.kind->unit,
                        metric.kind->label);
    if (metric.position)
      text.insert(text.size() - 1, fmt::format(" at {},{}", metric.position->x, metric.position->y));
  }
  const std::vector<compare::HowLine> how = compare::how_lines(comparison);
  if (!how.empty()) text += "\nHow it was compared\n";
  for (const compare::HowLine& line : how)
    text += fmt::format("  {:<18} {}\n", line.name, line_text(line.text));
  if (comparison.changes) text += regions_text(*comparison.changes);
  if (verdict.judged.empty()) return text;
  text += "\nThresholds\n";
  for (const compare::JudgedThreshold& judged : verdict.judged)
    text += fmt::format("  {:<18} {:>12.6g}      {}\n", compare::to_text(judged.threshold), judged.value,
                        judged.fails ? "FAILS" : "kept");
  return text + (verdict.pass() ? "pass\n" : "FAIL\n");
}

/// A line per pair, worst first, and one for all pairs.
std::string batch_text(const std::vector<compare::PairOutcome>& outcomes) {
  std::string text = fmt::format("{:<5} {:>10} {:>10} {:>10}  pair\n", "", "flip", "ssim", "psnr");
  std::size_t failed = 0;
  for (const compare::PairOutcome& outcome : outcomes) {
    failed += !outcome.pass();
    if (!outcome.comparison) {
      text += fmt::format("{:<5} {:>10} {:>10} {:>10}  {}: {}\n", "ERROR", "", "", "",
                          line_text(outcome.pair.name), line_text(outcome.error));
      continue;
    }
    text += fmt::format("{:<5}", outcome.pass() ? "pass" : "FAIL");
    for (const char* const name : {"flip", "ssim", "psnr"}) {
      const std::optional<double> value = compare::find_metric(name)->value(*outcome.comparison);
      text += fmt::format(" {:>10}", value ? fmt::format("{:.5g}", *value) : "-");
    }
    text += "  " + line_text(outcome.pair.name);
    for (const std::string& failure : compare::failures(outcome.verdict)) text += "; " + failure;
    text += "\n";
  }
  return text + fmt::format("{} of {} pairs {}\n", failed == 0 ? outcomes.size() : failed, outcomes.size(),
                            failed == 0 ? "pass" : "fail");
}

/// The exit code of the worst pair.
ExitCode exit_code(const jobs::CompareResult& pairs, bool idiff_codes) {
  bool pass = true, warned = false, only_sizes = true, any_error = false;
  for (const compare::PairOutcome& pair : pairs) {
    pass = pass && pair.pass();
    warned = warned || !pair.warnings.pass();
    if (pair.error.empty()) continue;
    any_error = true;
    only_sizes = only_sizes && pair.sizes_differ;
  }
  if (!idiff_codes) return any_error ? ExitCode::failed : pass ? ExitCode::done : ExitCode::no;
  if (any_error) return only_sizes ? ExitCode::sizes_differ : ExitCode::unreadable;
  return !pass ? ExitCode::failed : warned ? ExitCode::no : ExitCode::done;
}

ExitCode show(const CompareCommand& command, const jobs::ComparePlan& plan,
              const jobs::CompareResult& pairs) {
  if (plan.request().is_batch) {
    write_to_stdout(command.json ? compare::batch_json(pairs) : batch_text(pairs));
  } else {
    const compare::PairOutcome& pair = pairs.front();
    write_to_stdout(command.json ? compare::comparison_json(*pair.comparison, pair.verdict, pair.warnings)
                                 : comparison_text(*pair.comparison, pair.verdict));
  }
  return exit_code(pairs, command.idiff_codes);
}

/// Runs the command with the exit codes of idiff for errors, whose 2 is a difference.
ExitCode run_with_idiff_codes(const Run& run, const CommandLine& words) {
  try {
    return run(words);
  } catch (const Cancelled&) {
    throw;
  } catch (const compare::SizeMismatch& error) {
    say_error(error.what());
    return ExitCode::sizes_differ;
  } catch (const std::bad_alloc&) {
    say_error("not enough memory");
  } catch (const std::exception& error) {
    say_error(error.what());
  }
  return ExitCode::unreadable;
}

/// The names of thresholds with what they are, as lines.
std::string names_of_metrics() {
  std::string text;
  std::string_view group;
  for (const compare::MetricKind& kind : compare::metric_kinds()) {
    if (kind.group != group) text += fmt::format("  {}\n", group = kind.group);
    text += manual_row(fmt::format("    {}", kind.name), kind.note, 23);
  }
  return text;
}

}  // namespace

Command add_compare(const Options& program) {
  const auto command = std::make_shared<CompareCommand>();
  const Options compare =
      program.command("compare", "Compare an image with a reference: metrics, maps, regions, report");
  jobs::add_compare_fields(compare, command->request, [&] {
    compare.group("Verdict").flag(
        "--idiff-codes",
        "exit codes of OpenImageIO's idiff: 0 pass, 1 warning, 2 fail, 3 sizes differ, 4 other errors; "
        "invalid options remain 2",
        command->idiff_codes);
    compare.group("Answers").flag("--json", "print the result as JSON instead of a table", command->json);
  });
  add_job_options(compare, *command);
  compare.manual(fmt::format(fmt::runtime(manual("compare")), fmt::arg("metrics", names_of_metrics())));
  const std::shared_ptr<JobCommand<jobs::CompareRequest>> job = command;
  Command added = job_command(
      compare, job, [command](const auto& plan, const auto& pairs) { return show(*command, plan, pairs); });
  added.run = [command, run = added.run](const CommandLine& words) {
    return command->idiff_codes ? run_with_idiff_codes(run, words) : run(words);
  };
  return added;
}

}  // namespace alidade::tools
