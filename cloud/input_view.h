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

/// Which points of a cloud are wanted: those for which everything that is given holds. Coordinates are those
/// that the cloud has after ReferenceChange.
struct PointSelection {
  /// Faces included, as crop(); sides may be infinite.
  std::optional<Bounds> box{};
  /// Makes the polygons for a cloud of this reference system; points in one of them are wanted, as crop().
  std::function<std::vector<PlanePolygon>(const Crs&)> polygons{};
  /// ASPRS classes. Classes of other numbers are not wanted.
  std::optional<std::bitset<256>> classes{};
  /// Sets the mark of every row for which a condition does not hold to 0; `rows` have all attributes of their
  /// file. Several threads may call it. Errors: the condition is on an attribute that the file lacks.
  std::function<void(const PointCloud& rows, std::span<std::uint8_t> marks)> condition{};

  bool empty() const { return !box && !polygons && !classes && !condition; }
};

/// Brings the positions of a file to another reference system.
struct ReferenceChange {
  Crs crs{};  ///< of the positions afterwards
  /// Multiplies heights before positions move: the lattice alone, where a file has one and positions do not move, so
  /// that no height is rounded.
  double height_factor = 1.0;
  std::string heights_note{};  ///< FileFacts::heights_note
  /// Moves positions; one without an image becomes not finite. Empty: positions stay, and only the name of
  /// their system is another. For one thread at a time.
  std::function<void(std::span<glm::dvec3>)> move{};
  std::vector<std::string> warnings{};
};

/// How the clouds of a command are to be taken. Whoever opens a CloudInput that has one sees only the
/// selected points, in their order, as if the file held no others, in the system that is wanted: every
/// command alike.
struct InputView {
  PointSelection selection{};
  /// Plans the change for a file by what it states. One that moves heights brings them to one unit, if that is wanted.
  /// Many threads may call it.
  std::function<ReferenceChange(const std::filesystem::path& file, const FileFacts& facts)>
      change_reference{};
  /// Names of the columns of text files without titles; empty: their own, or by content.
  std::vector<std::string> columns{};
  /// Whether heights are wanted in the unit of x and y, which everything needs that measures: heights_in_plane_unit(),
  /// after change_reference().
  bool has_one_unit = false;
  std::optional<LengthUnit> height_unit{};  ///< of files that state none

  /// Whether all points are wanted as they are, but for the unit of heights.
  bool empty() const { return selection.empty() && !change_reference; }
  /// What becomes of the positions of a file. Errors: those of change_reference() and heights_in_plane_unit(); a file
  /// in another unit of which a catalog states the box.
  ReferenceChange change_of(const CloudInput& input, const FileFacts& facts) const;
};

/// The clouds with heights in the unit of x and y.
CloudInputs in_one_unit(CloudInputs clouds);

/// A reader that gives what the view shows of another one. Points that are not selected count in
/// CloudFile::left_out_count, those without an image in the other system in CloudFile::dropped_count. A file
/// whose header says that none of its points is in the selection's box is not read, unless damage is read
/// over: headers of damaged files may be wrong. Positions that move get a lattice of their own, as
/// those of files without one (fit_lattice()), not finer than the image of a step of theirs. `change` is what
/// view->change_of() answers for the file.
///
/// Errors: a class or a condition is wanted of a file without classes; those of the view's functions. Memory:
/// a piece of some 64 MB beside the points that are selected. Cost: that of reading, for each point that of
/// the view's functions, and a second pass for positions that move.
std::unique_ptr<CloudReader> open_view(std::unique_ptr<CloudReader> reader,
                                       std::shared_ptr<const InputView> view, ReferenceChange change,
                                       Damage damage);

}  // namespace alidade
