// SPDX-License-Identifier: MIT
#include "extensions/postgres/job.h"
#include "python/python_jobs.h"

namespace alidade::extensions {

void add_postgres(python::PythonHooks& hooks) {
  namespace py = python::py;
  hooks.jobs.push_back(python::job(
      "sql shard-plan",
      "Plan the distribution of a cloud over several PostgreSQL servers: a dict with the number of points.",
      &jobs::add_shard_plan_fields,
      [](const jobs::ShardPlanPlan&, const database::StoredFiles& result) -> py::object {
        return py::dict(py::arg("points") = result.point_count);
      },
      python::Output::answer));
}

}  // namespace alidade::extensions
