// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/options.h"
#include "tools/visibility/blocking_cloud.h"
#include "visibility/objects.h"

namespace alidade::tools {

/// The options of objects whose visibility a map shows.
struct ObjectOptions {
  std::vector<visibility::GivenObserver> segments;  ///< --object
  std::filesystem::path file;                       ///< --objects; empty: none
  std::string reference;                            ///< --objects-crs
  std::optional<double> spacing, width;             ///< --object-spacing, --object-width

  bool any() const { return !segments.empty() || !file.empty(); }
  /// Name of the first option that was given; empty: none.
  std::string given() const;
};

/// Declares the options in a group of their own; they fill `options`.
void add_object_options(const Options& command, ObjectOptions& options);

/// Reads the objects, in the cloud's reference system, those of the command line first, and divides them into
/// samples; prints their numbers. Errors: those of read_objects() and sample_objects().
visibility::SampledObjects load_objects(const ObjectOptions& options, double max_distance, const Crs& crs,
                                        const visibility::GroundHeight& ground, Verbosity verbosity);

}  // namespace alidade::tools
