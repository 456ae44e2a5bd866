// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "jobs/clouds/catalog.h"
#include "jobs/clouds/convert.h"
#include "jobs/clouds/generate.h"
#include "jobs/clouds/index.h"
#include "jobs/clouds/info.h"
#include "jobs/compare/compare.h"
#include "jobs/query/query.h"
#include "jobs/render/merge.h"
#include "jobs/render/render.h"
#include "jobs/sql/load.h"
#include "jobs/sql/rewrite.h"
#include "jobs/sql/statement.h"
#include "jobs/visibility/horizon.h"
#include "jobs/visibility/lines.h"
#include "jobs/visibility/points.h"
#include "jobs/visibility/raster.h"
#include "jobs/visibility/sky.h"
#include "jobs/visibility/summary.h"
#include "jobs/visibility/sun.h"
#include "python/answer_columns.h"

// The results of jobs as the named tuples of alidade/_answers.py. Names of columns and their values are those
// of the files that the jobs write.

namespace alidade::python {

py::object answer_of(const jobs::RasterPlan& plan, const jobs::RasterResult& result);
py::object answer_of(const jobs::PointsPlan& plan, const jobs::PointsResult& result);
py::object answer_of(const jobs::HorizonPlan& plan, const jobs::HorizonResult& result);
py::object answer_of(const jobs::SkyPlan& plan, const jobs::SkyResult& result);
py::object answer_of(const jobs::SunPlan& plan, const jobs::SunResult& result);
py::object answer_of(const jobs::LinesPlan& plan, const jobs::LinesResult& result);
py::object answer_of(const jobs::SummaryPlan& plan, const jobs::SummaryResult& result);
py::object answer_of(const jobs::InfoPlan& plan, const jobs::InfoResult& result);
py::object answer_of(const jobs::ConvertPlan& plan, const jobs::ConvertResult& result);
py::object answer_of(const jobs::IndexPlan& plan, const jobs::IndexResult& result);
py::object answer_of(const jobs::CatalogPlan& plan, const jobs::CatalogResult& result);
py::object answer_of(const jobs::GeneratePlan& plan, PointCloud& result);
py::object answer_of(const jobs::ComparePlan& plan, const jobs::CompareResult& result);
py::object answer_of(const jobs::LoadPlan& plan, const database::StoredFiles& result);
py::object answer_of(const jobs::RewritePlan& plan, const std::vector<database::RewrittenStatement>& result);

py::object answer_of(const jobs::SqlPlan& plan, const jobs::SqlResult& result);
py::object answer_of(const jobs::QueryPlan& plan, const jobs::QueryResult& result);
py::object answer_of(const jobs::RenderPlan& plan, const jobs::RenderResult& result);
py::object answer_of(const jobs::MergePlan& plan, const renderer::MergedImage& result);

}  // namespace alidade::python
