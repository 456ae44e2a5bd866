// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/bounds.h"
#include "base/input_file.h"
#include "base/progress.h"
#include "cloud/cloud_inputs.h"
#include "cloud/damage.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// How the points of a cloud that is larger than memory are handed over in pieces, fewer than 2^32 points at
/// a time. By default all points stay in the cloud.
struct CloudPieces {
  std::uint64_t most_bytes = UINT64_MAX;  ///< of the points of a piece, including bytes_beside
  std::uint64_t bytes_beside = 0;         ///< per point, that `take` needs in addition
  /// Takes the points of a cloud, all or some of those of one or several files. Must leave the cloud without
  /// points, and its extra dimensions without values, and must not change anything else.
  std::function<void(PointCloud&)> take{};
  /// Fills positions and colours of `count` rows of the cloud from `first` on, if they were handed over in an
  /// earlier run; `take` then needs nothing else of them. Returns whether it did: then a reader need not
  /// unpack them. If it is empty, or a reader does not call it, all rows are read.
  std::function<bool(PointCloud&, std::size_t first, std::size_t count)> recall{};
};

/// Recalls the last `count` rows of a cloud, which have just been made; returns whether it did.
inline bool recalls(const CloudPieces& pieces, PointCloud& cloud, std::size_t count) {
  return pieces.recall && pieces.recall(cloud, cloud.size() - count, count);
}

/// How many of `wanted` further points, which have the attributes `coming` beside those of the cloud, fit
/// into the piece: at least 1, unless `wanted` is 0. A full piece is handed over first.
std::size_t room_in_piece(PointCloud& cloud, AttributeSet coming, std::uint64_t wanted,
                          const CloudPieces& pieces);

/// Rows of a cloud that a reader fills one by one.
class RowsToFill {
 public:
  /// Whether all announced rows have been filled.
  bool complete() const { return next_ == cloud_.size() && left_ == 0; }

 protected:
  /// Announces rows for `count` points, with the columns of `filled`. `pieces` must outlive the object.
  RowsToFill(PointCloud& cloud, AttributeSet filled, std::uint64_t count, const CloudPieces& pieces)
      : cloud_(cloud), filled_(filled), pieces_(pieces), next_(cloud.size()), left_(count) {}

  /// Appends rows of zeros for the next points, as far as a piece has room. Call once at the start.
  void make_rows();

  /// Begins the next row with its position. Returns false if the cloud's lattice cannot hold it, or if there
  /// are more rows than announced: the file has changed since the first pass.
  bool begin_row(const glm::dvec3& world) {
    const auto position = to_lattice(cloud_.lattice, world);
    if (!position || complete()) return false;
    if (next_ == cloud_.size()) make_rows();
    row_ = next_++;
    cloud_.positions[row_] = *position;
    return true;
  }

  PointCloud& cloud_;
  std::size_t row_ = 0;  ///< the one to be filled

 private:
  AttributeSet filled_;
  const CloudPieces& pieces_;
  std::size_t next_;
  std::uint64_t left_;  ///< rows that have not been made yet
};

/// What a file states, before its points are read.
struct FileFacts {
  CloudFile file{};  ///< with the number of points that the header states, if any
  /// The files that the points come from, if they are others, as those that an index file was made of.
  std::vector<CloudFile> sources{};
  std::uint64_t bytes = 0;  ///< of the file; 0 for a table of a server
  std::uint64_t work = 0;   ///< of a pass, in bytes, if it is more than `bytes`
  AttributeSet attributes{};
  std::optional<Lattice> lattice{};  ///< the file's own (LAS); empty for formats of free coordinates
  /// Number of points that reading appends, if known without a pass (LAS), already checked against the file's
  /// size. With Damage::read_over an upper bound: lost points have no rows.
  std::optional<std::uint64_t> point_count{};
  /// Types of the numbers that state x, y and z; empty if they are unknown, or if nothing is lost.
  std::array<std::optional<ScalarType>, 3> coordinate_types{};
  Crs crs{};
  std::string heights_note{};  ///< how heights were converted (HeightChange::note); empty: they were not
  std::optional<bool> gps_time_is_standard{};  ///< as in PointCloud; empty if the format has no such mark
  std::array<std::uint8_t, 16> project_id{};   ///< as in PointCloud
  std::uint16_t file_source_id = 0;            ///< as in PointCloud
  /// Box of all points, world coordinates: widened_header_box(). Empty if the header states none, or an
  /// invalid one.
  std::optional<Bounds> box{};

  /// `sources`, or else the file.
  std::vector<CloudFile> source_files() const { return sources.empty() ? std::vector{file} : sources; }
  /// The resolution of coordinate_types for coordinates within these bounds (CoordinateSurvey::resolution); 0
  /// if it is unknown, or if nothing is lost.
  glm::dvec3 resolution(const Bounds& bounds) const;
};

/// The largest channels of some colours, as stored in the file.
struct LargestColors {
  int color = 0, near_infrared = 0;
};

/// What reading has made of the points of a file.
struct FileRead {
  /// FileFacts::source_files() with the points that were taken, dropped and left out.
  std::vector<CloudFile> files;
  /// The points that could not be read, by their locations in the order of the file; each point once. Empty
  /// with Damage::reject.
  std::vector<LostPoints> lost{};
  LargestColors left_out_colors{};  ///< of points that were read, and left out by a selection
};

/// The box that a header states, enlarged because programs round it: by 8 steps of the lattice, or a
/// hundred-thousandth of its longest side if that is more. Empty if the box is invalid, exceeds the lattice,
/// or is a single point, as in headers whose box was never filled in.
std::optional<Bounds> widened_header_box(const Bounds& stated, const Lattice& lattice);

/// An opened cloud file: its header is read, its points are not read yet. One class per format, made by
/// `open_*` below; read_in_pieces() joins them. Not thread safe.
class CloudReader {
 public:
  virtual ~CloudReader() = default;

  /// What is known before the points are read. survey() may correct attributes and work.
  const FileFacts& facts() const { return facts_; }

  /// First pass, for files without a lattice only. `progress` is in bytes, or in units of FileFacts::work.
  virtual CoordinateSurvey survey(const Progress&) { return {}; }

  /// Appends the file's points to `cloud`, whose lattice is set and, if the file has one, differs from that
  /// by a whole number of steps. Keeps only `wanted` attributes; columns that the file has and the cloud
  /// lacks are first filled with zeros up to the cloud's size, and columns that the cloud has and the file
  /// lacks get zeros for the new rows. The caller has reserved room. Records, scanner positions and warnings,
  /// but none about lost points, are added to `cloud` by this call; facts and files by the caller. The call
  /// does not depend on the cloud's other contents: it may have the files before this one or be a piece of
  /// its own. See cloud/rows.h. Memory: with `pieces`, a piece; for LAZ some 64 MB of records (or its largest
  /// chunk unpacked); for compressed PCD all its points.
  virtual FileRead read(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                        const Progress& progress) = 0;

  /// Releases file handle and buffers (InputFile::rest) until the next call that needs them; called while
  /// other files of a large set are read.
  virtual void rest() {}

 protected:
  /// The result for a file that is its own source.
  FileRead read_rows(std::uint64_t taken, std::uint64_t dropped = 0, std::vector<LostPoints> lost = {}) const;

  FileFacts facts_;
};

/// Opens a cloud by its format, as changed by its view. Errors: it cannot be read; it is empty or of an
/// unknown format; names of columns are given for another format than text.
std::unique_ptr<CloudReader> open_cloud(const CloudInput& input, Damage damage = Damage::reject);

/// open_cloud() without the selection and the change of positions of the view.
std::unique_ptr<CloudReader> open_stored_cloud(const CloudInput& input, Damage damage);

/// One function per format, in read_<format>.cpp. Errors: the content is not of that format.
std::unique_ptr<CloudReader> open_las(InputFile file, Damage damage = Damage::reject);
std::unique_ptr<CloudReader> open_ply(InputFile file, Damage damage = Damage::reject);
std::unique_ptr<CloudReader> open_pcd(InputFile file, Damage damage = Damage::reject);
/// XYZ, CSV with header names, PTS.
std::unique_ptr<CloudReader> open_text(InputFile file, Damage damage = Damage::reject);
/// open_text() with these names for the columns of a file without titles (cloud/text/text_layout.h).
std::unique_ptr<CloudReader> open_text(InputFile file, Damage damage, std::span<const std::string> columns);
std::unique_ptr<CloudReader> open_ptx(InputFile file, Damage damage = Damage::reject);
std::unique_ptr<CloudReader> open_e57(InputFile file, Damage = Damage::reject);

}  // namespace alidade
