// SPDX-License-Identifier: MIT
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "extensions/change/job.h"
#include "python/answer_columns.h"
#include "python/python_jobs.h"

namespace alidade::extensions {
namespace {

using namespace python;

py::object answer_of_change(const jobs::ChangePlan&, const jobs::ChangeResult& result) {
  const auto epoch = [](const jobs::EpochResult& found, std::uint8_t number) {
    py::dict rows;
    std::vector<std::string> names;
    for (int kind = 0; kind < visibility::k_change_classes; ++kind)
      names.emplace_back(name_of(static_cast<visibility::ChangeClass>(kind)));
    const auto add = [&](const char* name, const auto& value) {
      rows[name] = array_of(found.classes.size(), [&](std::size_t i) { return value(found.classes[i]); });
    };
    const auto add_median = [&](const char* name, std::optional<double> visibility::ChangeSummary::*member) {
      add(name,
          [member](const visibility::ChangeSummary& one) { return (one.*member).value_or(k_no_number); });
    };
    rows["class"] = texts_of(names.size(), [&](std::size_t i) -> const std::string& { return names[i]; });
    add("count", [](const visibility::ChangeSummary& one) { return one.count; });
    add("area", [](const visibility::ChangeSummary& one) { return one.area; });
    add("measured", [](const visibility::ChangeSummary& one) { return one.measured; });
    add_median("median_distance", &visibility::ChangeSummary::median_distance);
    add_median("median_absolute_distance", &visibility::ChangeSummary::median_absolute_distance);
    add_median("median_detection_level", &visibility::ChangeSummary::median_detection_level);
    return points_of(columns_of_points(jobs::columns_of(found.points, number), found.points.classes.size()),
                     rows, found.crs);
  };
  return answer_type("Change")(epoch(result.before, 1), epoch(result.after, 2));
}

void add_fields(const jobs::Fields& fields, jobs::ChangeRequest& request) {
  jobs::add_change_fields(fields, request);
}

}  // namespace

void add_change(PythonHooks& hooks) {
  hooks.jobs.push_back(job("change",
                           "Find what has moved, gone or come between two scans, or was never seen: an "
                           "alidade.Change.",
                           &add_fields, answer_of_change));
}

}  // namespace alidade::extensions
