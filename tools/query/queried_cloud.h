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

/// Whether the run reads COPC in place: it is a single file, or files of a catalog that states their boxes,
/// nothing but positions and classes is needed of it, and nobody asked for it to be loaded. Errors: the file cannot be
/// opened.
bool asks_in_place(const QueryCommand& command, AnswerForm form);

/// Only points of the command's classes are there. Reading them ends when the program is interrupted.
/// Errors: CopcTiles'.
std::unique_ptr<CopcTiles> open_copc(const QueryCommand& command);

/// What --explain adds for COPC: files opened, chunks and points decoded, and what share of all that is.
std::string copc_table(const CopcTiles& tiles);

/// A box outside which no point answers, from a first look through the targets and at the headers of the
/// files; empty if there is none to be had: of one file, of half-spaces, without a radius, for targets that
/// come through a pipe or are more than a million, and where the answer also depends on points that are not
/// in it (levels, colours in LAS). Errors: those of targets, and of opening files.
template <class Target>
std::optional<Bounds> query_region(const QueryCommand& command, AnswerForm form);

using QueryPart = std::optional<database::CloudPart>;

/// What answers can come from of a cloud that lies in a database, from a first look through the targets;
/// empty if that is all of it, or cannot be known: without a radius, for targets that come through a pipe,
/// and for levels. Errors: those of targets, and of the database.
template <class Target>
QueryPart read_query_part(const QueryCommand& command, AttributeSet attributes, const Progress& progress);

}  // namespace alidade::tools
