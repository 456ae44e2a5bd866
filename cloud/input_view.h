// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/bounds.h"
#include "cloud/axis_units.h"
#include "cloud/cloud_inputs.h"
#include "cloud/cloud_reader.h"
#include "cloud/crs.h"
#include "cloud/select_points.h"

namespace alidade {

/// Which points of a cloud are wanted: those that fulfil all conditions that are set. Coordinates are those
/// of the cloud after ReferenceChange.
struct PointSelection {
  /// Points in it or on its faces, as crop(); sides may be infinite.
  std::optional<Bounds> box{};
  /// Makes the polygons for a cloud of this reference system; points in one of them are wanted, as crop().
  std::function<std::vector<PlanePolygon>(const Crs&)> polygons{};
  /// The wanted ASPRS classes.
  std::optional<std::bitset<256>> classes{};
  /// Sets the mark of every row to 0 for which a condition does not hold; `rows` have all attributes of their
  /// file. Several threads may call it. Errors: the condition is on an attribute that the file lacks.
  std::function<void(const PointCloud& rows, std::span<std::uint8_t> marks)> condition{};

  bool empty() const { return !box && !polygons && !classes && !condition; }
};

/// Changes the positions of a file to another reference system.
struct ReferenceChange {
  Crs crs{};  ///< of the changed positions
  /// Multiplies heights before positions move. If a file has a lattice and positions do not move, only the
  /// lattice changes, so that no height is rounded.
  double height_factor = 1.0;
  std::string heights_note{};  ///< FileFacts::heights_note
  /// Moves positions; one without an image becomes not finite. Empty: positions stay, and only their system
  /// changes. For one thread at a time.
  std::function<void(std::span<glm::dvec3>)> move{};
  std::vector<std::string> warnings{};
};

/// Selection and reference system of the clouds of a command. A CloudInput with a view is read, by every
/// command, as if its file had only the selected points, in their order and in the wanted system.
struct InputView {
  PointSelection selection{};
  /// Plans the change for a file by its facts. A change that moves heights also gives them the wanted unit
  /// (has_one_unit). Many threads may call it.
  std::function<ReferenceChange(const std::filesystem::path& file, const FileFacts& facts)>
      change_reference{};
  /// Names of the columns of text files without titles; empty: their own, or by content.
  std::vector<std::string> columns{};
  /// Whether heights are wanted in the unit of x and y, as for all measurements: heights_in_plane_unit(),
  /// after change_reference().
  bool has_one_unit = false;
  std::optional<LengthUnit> height_unit{};  ///< of files that state none

  /// Whether all points are wanted unchanged, except for the unit of heights.
  bool empty() const { return selection.empty() && !change_reference; }
  /// The change of a file's positions. Errors: those of change_reference() and heights_in_plane_unit(); a
  /// catalog states the box of a file whose heights are in another unit.
  ReferenceChange change_of(const CloudInput& input, const FileFacts& facts) const;
};

/// The clouds with heights in the unit of x and y.
CloudInputs in_one_unit(CloudInputs clouds);

/// A reader of the points of another reader that the view selects. Points that are not selected count in
/// CloudFile::left_out_count, those without an image in the other system in CloudFile::dropped_count. A file
/// is not read if its header states a box that does not meet that of the selection, except with
/// Damage::read_over, as headers of damaged files may be wrong. Positions that move get a lattice of their
/// own, as those of files without one (fit_lattice()), not finer than the image of a step of the file's
/// lattice. `change` is the result of view->change_of() for the file.
///
/// Errors: classes are selected from a file without classes; those of the view's functions. Memory: a piece
/// of some 64 MB beside the selected points. Cost: that of reading, for each point that of the view's
/// functions, and a second pass for positions that move.
std::unique_ptr<CloudReader> open_view(std::unique_ptr<CloudReader> reader,
                                       std::shared_ptr<const InputView> view, ReferenceChange change,
                                       Damage damage);

}  // namespace alidade
