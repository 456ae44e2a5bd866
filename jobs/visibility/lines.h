// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "jobs/additions.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/long_run.h"
#include "jobs/plan.h"
#include "jobs/visibility/visibility_cloud.h"
#include "visibility/lines/line_files.h"
#include "visibility/observers.h"

namespace alidade::jobs {

/// The ends of lines of sight.
struct PairRequest {
  std::filesystem::path pairs, places;  ///< --pairs, --places; empty: none
  std::string places_crs;
  visibility::ObserverDefaults defaults;  ///< --end-height
};

/// What an extension measures of lines (visibility/lines/line_measure.h) if its fields request it.
class AddedLineMeasure : public Addition {
 public:
  virtual bool is_requested() const = 0;
  // Requires is_requested(), here and below:
  /// The factor of the Earth's radius that bends lines by default, if this is the first measure.
  virtual double earth_factor() const = 0;
  /// The largest size of a result.
  virtual std::size_t bytes_per_line() const = 0;
  /// `unit`: metres of the cloud's unit.
  virtual std::shared_ptr<visibility::LineMeasure> measure(double unit) const = 0;
};

/// Lines of sight between pairs of positions.
struct LinesRequest : VisibilityRequest {
  PairRequest pairs;
  Additions<AddedLineMeasure> measures = make_additions<AddedLineMeasure>();
  std::optional<std::optional<double>> earth_factor;  ///< empty inside: off
  double end_margin = 0.0;
  CheckpointRequest checkpoint;
};

/// Declares all fields.
void add_lines_fields(const Fields& fields, LinesRequest& request);

/// A checked request.
using LinesPlan = Plan<LinesRequest>;

/// Checks all that can be checked before a point is read. Errors: no lines; --places-crs alone; files that
/// cannot be replaced or written.
LinesPlan plan(const LinesRequest& request);

/// What was found of every line.
struct LinesResult {
  std::unique_ptr<const VisibilityCloud> cloud;  ///< holds the classes of `table`; without occluders
  visibility::LineTable table;
};

/// Tests the lines, and writes them where the request has an output. Errors: those of load_cloud_alone(),
/// read_pair_table() and load_observers(); names of no position, or of two; coordinates beside --places; a
/// single position; a measure or a bent line without a linear unit; a margin that leaves nothing of a line;
/// too many lines for the memory; those of visibility::report_lines(); Cancelled.
LinesResult run(const LinesPlan& plan, Listener& listener);

}  // namespace alidade::jobs
