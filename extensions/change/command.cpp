// SPDX-License-Identifier: MIT
#include "extensions/change/job.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/command.h"

namespace alidade::extensions {
namespace {

using namespace tools;

using nlohmann::json;
using visibility::ChangeClass;
using visibility::ChangeSummary;

struct ChangeCommand : JobCommand<jobs::ChangeRequest> {
  bool json = false;
};

std::string table_of(const char* epoch, const jobs::EpochResult& found) {
  const auto length = [](const std::optional<double>& value) {
    const std::string text = value ? fmt::format("{:.4f}", *value) : "-";
    return text == "-0.0000" ? text.substr(1) : text;
  };
  std::string text =
      fmt::format("{:<18}{:>12}{:>9}{:>14}{:>16}{:>18}{:>20}{:>16}\n", epoch, "points", "share", "area",
                  "with distance", "median distance", "median |distance|", "median LoD95");
  for (std::size_t kind = 0; kind < found.classes.size(); ++kind) {
    const ChangeSummary& one = found.classes[kind];
    if (one.count == 0) continue;
    const double share =
        100.0 * static_cast<double>(one.count) / static_cast<double>(found.points.classes.size());
    text += fmt::format("{:<18}{:>12}{:>8.2f}%{:>14.2f}{:>16}{:>18}{:>20}{:>16}\n",
                        name_of(static_cast<ChangeClass>(kind)), one.count, share, one.area, one.measured,
                        length(one.median_distance), length(one.median_absolute_distance),
                        length(one.median_detection_level));
  }
  const auto reason = [&](const char* name, std::uint64_t count) {
    if (count > 0) text += fmt::format("  {:<16}{:>12}\n", name, count);
  };
  reason("no normal", found.points.without_normal);
  reason("too few points", found.points.too_few_points);
  return text;
}

json json_of(const jobs::EpochResult& found) {
  const auto length = [](const std::optional<double>& value) { return value ? json(*value) : json(); };
  json classes = json::object();
  for (std::size_t kind = 0; kind < found.classes.size(); ++kind) {
    const ChangeSummary& one = found.classes[kind];
    classes[name_of(static_cast<ChangeClass>(kind))] = {
        {"code", kind},
        {"points", one.count},
        {"area", one.area},
        {"with_distance", one.measured},
        {"median_distance", length(one.median_distance)},
        {"median_absolute_distance", length(one.median_absolute_distance)},
        {"median_lod95", length(one.median_detection_level)}};
  }
  json& unmeasured = classes[name_of(ChangeClass::not_measured)];
  unmeasured["no_normal"] = found.points.without_normal;
  unmeasured["too_few_points"] = found.points.too_few_points;
  return {{"points", found.points.classes.size()}, {"classes", classes}};
}

void show_changes(const jobs::ChangeResult& result, bool as_json) {
  write_to_stdout(
      as_json ? json{{"before", json_of(result.before)}, {"after", json_of(result.after)}}.dump(2) + "\n"
              : table_of("BEFORE", result.before) + "\n" + table_of("AFTER", result.after));
}

Command declare_change(const Options& program) {
  const auto command = std::make_shared<ChangeCommand>();
  const Options change =
      program.command("change", "Find what has moved, gone or come between two scans, or was never seen");
  jobs::add_change_fields(change, command->request, [&] {
    change.flag("--json", "print JSON instead of a table; the keys are below", command->json);
  });
  add_job_options(change, *command);
  const std::shared_ptr<JobCommand<jobs::ChangeRequest>> job = command;
  return job_command(change, job, [command](const jobs::ChangePlan&, const jobs::ChangeResult& result) {
    show_changes(result, command->json);
    return ExitCode::done;
  });
}

}  // namespace

void add_change(ProgramHooks& hooks) {
  hooks.commands.push_back({"", declare_change});
}

}  // namespace alidade::extensions
