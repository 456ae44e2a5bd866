// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "extensions/placement/job.h"
#include "python/answer_columns.h"
#include "python/python_jobs.h"

namespace alidade::extensions {
namespace {

using namespace python;

py::object answer_of_place(const jobs::PlacePlan&, const jobs::PlaceResult& result) {
  py::dict facts;
  facts["total"] = result.placement.total;
  facts["best_possible"] = result.placement.best_possible;
  facts["candidates"] = result.candidates.size();
  facts["targets"] = result.targets.size();
  return rows_of(visibility::placement_rows(result.placement, result.candidates), result.crs, facts);
}

}  // namespace

void add_placement(PythonHooks& hooks) {
  hooks.jobs.push_back(
      job("visibility place",
          "Choose the few observer positions that see most: alidade.Rows, one per position; none if "
          "no candidate sees a target.",
          &jobs::add_place_fields, answer_of_place));
}

}  // namespace alidade::extensions
