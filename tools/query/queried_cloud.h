// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "base/bounds.h"
#include "base/progress.h"
#include "database/point_filter.h"
#include "octree/copc_tiles.h"
#include "tools/query/answers.h"
#include "tools/query/query.h"

namespace alidade::tools {

/// Whether the run reads COPC in place: a single file, or files of a catalog that states their boxes, if only
/// positions and classes are needed, without --load. Errors: the file cannot be opened.
bool queries_in_place(const QueryCommand& command, AnswerForm form);

/// The COPC files of the command, with the points of its classes only. Reading them ends when the program is
/// interrupted. Errors: CopcTiles'.
std::unique_ptr<CopcTiles> open_copc(const QueryCommand& command);

/// What --explain adds for COPC: files opened, chunks and points decoded, and what share of all that is.
std::string copc_table(const CopcTiles& tiles);

/// A box that contains all points that can answer, from a first pass through the targets and from the headers
/// of the files; empty if it is unknown: for one file, for half-spaces, without a radius, for targets that
/// come through a pipe or are more than a million, and where the answer also depends on points outside of the
/// box (levels, colours in LAS). Errors: those of targets, and of opening files.
template <class Target>
std::optional<Bounds> query_region(const QueryCommand& command, AnswerForm form);

using QueryPart = std::optional<database::CloudPart>;

/// The part of a cloud in a database that can answer, from a first pass through the targets; empty if that is
/// the whole cloud, or unknown: without a radius, for targets that come through a pipe or are more than a
/// million, and for levels. Errors: those of targets, and of the database.
template <class Target>
QueryPart read_query_part(const QueryCommand& command, AttributeSet attributes, const Progress& progress);

}  // namespace alidade::tools
