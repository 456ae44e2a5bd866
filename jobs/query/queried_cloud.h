// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "database/point_filter.h"
#include "jobs/listener.h"
#include "jobs/query/query.h"
#include "octree/copc_tiles.h"
#include "octree/index_file/index_file.h"

namespace alidade::jobs {

/// Whether the job reads COPC in place: a single file, or files of a catalog that states their boxes, if only
/// positions and classes are needed. Errors: the file cannot be opened.
bool queries_in_place(const CheckedQuery& query);

/// The COPC files of the query, with the points of its classes only. Reading them ends when the listener
/// stops. Errors: CopcTiles'.
std::unique_ptr<CopcTiles> open_copc(const CheckedQuery& query, Listener& listener);

/// A cloud, all or some of whose points have been loaded.
struct QueriedCloud {
  IndexedCloud indexed;
  std::optional<database::CloudPart> part{};  ///< of a database; its cloud has been moved from

  /// The number that a row has in the whole cloud; empty if it is the row. The cloud must outlive it.
  std::function<std::uint64_t(std::uint64_t row)> ids() const;

  /// Admits points of the chosen classes; empty if the query chooses none. The cloud must outlive it.
  /// Errors: the cloud has no classes.
  CandidateFilter class_filter(const CheckedQuery& query) const;
};

/// Loads the points that can answer the targets, from a first pass through them and from what files and
/// databases state; the whole cloud if they are not known: without a radius, for half-spaces in files, for
/// targets that come through a pipe or are more than a million, and where answers depend on other points
/// (levels, colours in LAS). Errors: those of targets and of load_cloud(); the cloud lacks levels or classes.
template <class Target>
QueriedCloud load_queried(const CheckedQuery& query, Listener& listener);

}  // namespace alidade::jobs
