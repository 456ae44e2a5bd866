// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include "octree/copc_tree.h"
#include "tools/query/query.h"

namespace alidade {

/// A COPC file that a run asks where it lies.
struct CopcSource {
  std::unique_ptr<CopcFile> file;
  std::unique_ptr<CopcCache> cache;
};

/// Whether the run asks a COPC file in place: it is the only cloud, nothing but positions and classes is
/// needed of it, and nobody asked for it to be loaded. Errors: the file cannot be opened.
bool asks_in_place(const QueryCommand& command, AnswerForm form);

/// Opens it; only points of the command's classes are there. Reading it ends when the program is interrupted.
/// Errors: CopcFile's.
CopcSource open_copc(const QueryCommand& command);

/// What --explain adds for a COPC file: chunks and points decoded, and how much of the file that is.
std::string copc_table(const CopcCache& cache);

}  // namespace alidade
