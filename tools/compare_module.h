// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compare/batch.h"
#include "compare/comparison.h"
#include "compare/report/page.h"

// What `alidade compare` has the module do for it (tools/load_module.h): everything that reads or writes
// pictures.

namespace alidade {

/// compare_files() of compare/comparison.h. Errors, here and below: those of load_module_function().
using FileComparer = void (*)(const std::filesystem::path& reference, const std::filesystem::path& test,
                              const ComparisonOptions& options, const Progress& progress,
                              Comparison& comparison);
FileComparer load_file_comparer();

/// compare_pairs() of compare/batch.h.
using PairComparer = void (*)(const std::vector<ImagePair>& pairs, const BatchOptions& options,
                              const Progress& progress, std::vector<PairOutcome>& outcomes);
PairComparer load_pair_comparer();

/// report_page() of compare/report/page.h.
using ReportMaker = void (*)(const Comparison& comparison, const Verdict& verdict, PicturePacking packing,
                             const Verdict& warnings, std::string& page);
ReportMaker load_report_maker();

/// write_difference() of compare/difference_map.h.
using DifferenceWriter = void (*)(const DifferenceMap& map, const std::filesystem::path& file,
                                  bool overwrite);
DifferenceWriter load_difference_writer();

}  // namespace alidade
