// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "cloud/crs.h"
#include "geo/write_catalog.h"
#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"

namespace alidade::jobs {

/// A list of many cloud files with their bounds, so that few need be opened. The output is .catalog.json, or
/// .gpkg with the footprints.
struct CatalogRequest : CloudRequest {
  bool measure = false;  ///< read all points; else plausible boxes in headers are believed
};

/// Declares all fields.
void add_catalog_fields(const Fields& fields, CatalogRequest& request);

/// A checked request.
using CatalogPlan = Plan<CatalogRequest>;

/// Errors: an output of an unknown format, or that cannot be replaced or written.
CatalogPlan plan(const CatalogRequest& request);

struct CatalogResult {
  std::vector<geo::CatalogFile> files;
  std::vector<Crs> systems;  ///< of the files, each once
};

/// Opens all files, and writes the catalog. Errors: those of reading; a file outside of the folder of the
/// catalog, or with a name that no reader of it finds; footprints in different reference systems. Cancelled.
CatalogResult run(const CatalogPlan& plan, Listener& listener);

}  // namespace alidade::jobs
