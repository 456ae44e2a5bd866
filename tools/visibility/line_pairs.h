// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/console.h"
#include "tools/options.h"
#include "tools/visibility/blocking_cloud.h"
#include "visibility/lines/line_report.h"
#include "visibility/observers.h"

namespace alidade::tools {

/// Which sight lines were asked for on the command line.
struct PairRequest {
  std::filesystem::path pairs, places;    ///< --pairs, --places; empty: none
  std::string places_crs;                 ///< --places-crs
  visibility::ObserverDefaults defaults;  ///< --end-height
};

/// Declares the options in a group of their own; they fill `request`.
void add_pair_options(const Options& command, PairRequest& request);

/// Errors that need no cloud: nothing asked for, --places-crs alone.
void check_pair_request(const PairRequest& request);

/// The ends of lines.
struct LineEnds {
  std::vector<visibility::Observer> places;
  bool are_pairs = false;  ///< first and second end of each line after each other; else all are paired
};

/// Reads places and pairs and gives them their places on the cloud. Surfaces need not be measured. Errors:
/// those of read_pair_table() and load_observers(); names that no place or two have; coordinates beside
/// --places; a single place.
LineEnds load_line_ends(const PairRequest& request, const VisibilityCloud& cloud, Verbosity verbosity);

/// What is reported on beside the lines themselves.
enum class LineZones { none, fresnel };

/// Errors: more lines than fit into memory, each with all obstructions that it can have.
void check_report_memory(const LineEnds& ends, LineZones zones);

/// Errors: a margin at either end that leaves nothing of a line.
void check_margin(const LineEnds& ends, double margin);

/// The lines: the pairs of a file, or every place with every other.
std::vector<visibility::LinePair> pairs_of(const LineEnds& ends, const visibility::Occluders& occluders);

}  // namespace alidade::tools
