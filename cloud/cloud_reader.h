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

/// How points are handed over while a cloud is read that memory does not hold, fewer than 2^32 at a time. As
/// it stands: not at all, they all stay in the cloud.
struct CloudPieces {
  std::uint64_t most_bytes = UINT64_MAX;  ///< of the points of a piece, and of what they need beside
  std::uint64_t bytes_beside = 0;         ///< per point, for what `take` makes of them
  /// Takes the points of a cloud, all or some of a file's or of several; it must leave none, and the extra
  /// dimensions without values. Nothing else of the cloud may change.
  std::function<void(PointCloud&)> take{};
  /// Fills `count` rows of the cloud from `first` on, if they were handed over in an earlier run: positions and colours,
  /// as `take` needs no more of them. Returns whether it did: then a reader need not unpack them. Where it is empty, or
  /// a reader does not call it, all rows are read.
  std::function<bool(PointCloud&, std::size_t first, std::size_t count)> recall{};
};

/// Whether the last rows of a cloud, which have just been made, were recalled.
inline bool recalls(const CloudPieces& pieces, PointCloud& cloud, std::size_t count) {
  return pieces.recall && pieces.recall(cloud, cloud.size() - count, count);
}

/// For how many of `wanted` further points, with these attributes beside those of the cloud, a piece has
/// room, which is handed over first if it has none; 1 or more, unless `wanted` is 0.
std::size_t room_in_piece(PointCloud& cloud, AttributeSet coming, std::uint64_t wanted,
                          const CloudPieces& pieces);

/// Rows of a cloud that a reader fills one by one.
class RowsToFill {
 public:
  /// Whether as many rows came as were announced.
  bool complete() const { return next_ == cloud_.size() && left_ == 0; }

 protected:
  /// Rows for `count` points to come, with the columns of `filled`. `pieces` must outlive the object.
  RowsToFill(PointCloud& cloud, AttributeSet filled, std::uint64_t count, const CloudPieces& pieces)
      : cloud_(cloud), filled_(filled), pieces_(pieces), next_(cloud.size()), left_(count) {}

  /// Makes rows of zeros for the points to come, as far as a piece has room; to be called once at the start.
  void make_rows();

  /// Goes on to the next row and gives it its position. False if the cloud's lattice cannot hold it or more
  /// rows come than were announced: the file is not what the first pass saw.
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

/// What a file says about all of its points at once.
struct FileFacts {
  Crs crs{};
  std::string heights_note{};  ///< how heights were converted (HeightChange::note); empty: they were not
  std::optional<bool> gps_time_is_standard{};  ///< as PointCloud's; empty if the format cannot say
  std::array<std::uint8_t, 16> project_id{};   ///< as PointCloud's, and so is the next one
  std::uint16_t file_source_id = 0;
  /// Box of all points, world coordinates: widened_header_box(). Empty if the header states none, or one that
  /// cannot be true.
  std::optional<Bounds> box{};
};

/// The largest channels of some colours, as the file has them.
struct LargestColors {
  int color = 0, near_infrared = 0;
};

/// The box that a header states, made larger by what programs round it by: 8 steps of the lattice, or a
/// hundred-thousandth of its longest side if that is more. Empty if it is no box, does not lie on the
/// lattice, or is a single position, as boxes are that nobody filled in.
std::optional<Bounds> widened_header_box(const Bounds& stated, const Lattice& lattice);

/// One cloud file, opened and its header understood, points not read yet. One class per format, made by
/// `open_*` below; read_in_pieces.cpp joins them. Not thread safe.
class CloudReader {
 public:
  virtual ~CloudReader() = default;

  /// Format, version, point format. point_count is final after read().
  virtual const CloudFile& file() const = 0;

  /// The files that the points come from: this one, or those an index file was made of.
  virtual std::vector<CloudFile> sources() const { return {file()}; }

  /// Attributes the file has.
  virtual AttributeSet attributes() const = 0;

  /// The file's own lattice (LAS); empty for formats of free coordinates.
  virtual std::optional<Lattice> lattice() const { return std::nullopt; }

  /// Known when the file is open, so that files can be compared before any is read.
  virtual FileFacts facts() const { return {}; }

  /// How finely its own numbers are rounded for coordinates within these bounds (CoordinateSurvey::resolution); 0 where
  /// that is not known, or nothing is lost.
  virtual glm::dvec3 resolution(const Bounds&) const { return glm::dvec3(0.0); }

  /// Number of points the file will deliver if known without a pass (LAS), already checked against the file's
  /// size. With Damage::read_over the most it can be: points that turn out to be lost are fewer rows.
  virtual std::optional<std::uint64_t> point_count() const { return std::nullopt; }

  /// How much a pass takes, in bytes, where the points lie in no file that could be measured; 0 for files.
  virtual std::uint64_t work() const { return 0; }

  /// First pass, only for readers without a lattice: others have nothing to find out. `progress` is in bytes,
  /// or of what work() says.
  virtual CoordinateSurvey survey(const Progress&) { return {}; }

  /// Appends the file's points to `cloud`, whose lattice is set and, where lattice() is given, differs from
  /// it by a whole number of steps. Keeps only `wanted` attributes; columns the file has and the cloud lacks
  /// are first filled with zeros up to the cloud's size, and columns the cloud has and the file lacks get
  /// zeros for the new rows. The caller has reserved room. Records, scanner positions and warnings are added
  /// to `cloud` by this call; facts() and file() by the caller. The call does not depend on the cloud's other
  /// contents: it may hold the files before this one or be a piece of its own. See cloud/rows.h.
  void read(PointCloud& cloud, AttributeSet wanted, const Progress& progress) {
    read_in_pieces(cloud, wanted, {}, progress);
  }

  /// The same with a cloud that is emptied on the way: memory for a piece, some 64 MB of records of LAZ (or
  /// its largest chunk unpacked), and of PCD that is compressed all its points.
  virtual void read_in_pieces(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                              const Progress& progress) = 0;

  /// The points that are missing from what read() gave, position by position in the order of the file; each
  /// point once. Final after read(), which adds no warnings about them: the caller does. Always empty with
  /// Damage::reject.
  virtual std::vector<LostPoints> lost() const { return {}; }

  /// Colours of points that the last read() has seen and left out; nothing unless a selection does.
  virtual LargestColors left_out_colors() const { return {}; }

  /// Gives back file handle and buffers (InputFile::rest) until the next call that needs them; called while
  /// other files of a large set are read.
  virtual void rest() {}
};

/// Opens a cloud by its format, as its view wants it. Errors: it cannot be read; it is empty or of no known format;
/// columns are named of another format than text.
std::unique_ptr<CloudReader> open_cloud(const CloudInput& input, InputFile file, Damage damage);
inline std::unique_ptr<CloudReader> open_cloud(const CloudInput& input, Damage damage = Damage::reject) {
  return open_cloud(input, input.file(), damage);
}

/// The same without what the view selects and moves.
std::unique_ptr<CloudReader> open_stored_cloud(const CloudInput& input, InputFile file, Damage damage);

/// One function per format; each throws Error if the content is not of that format. Each lives in
/// read_<format>.cpp.
std::unique_ptr<CloudReader> open_las(InputFile file, Damage damage = Damage::reject);
std::unique_ptr<CloudReader> open_ply(InputFile file, Damage damage = Damage::reject);
std::unique_ptr<CloudReader> open_pcd(InputFile file, Damage damage = Damage::reject);
std::unique_ptr<CloudReader> open_text(InputFile file,
                                       Damage damage = Damage::reject);  ///< XYZ, CSV with header names, PTS
/// The same with these names for the columns of a file without titles (cloud/text/text_layout.h).
std::unique_ptr<CloudReader> open_text(InputFile file, Damage damage, std::span<const std::string> columns);
std::unique_ptr<CloudReader> open_ptx(InputFile file, Damage damage = Damage::reject);
std::unique_ptr<CloudReader> open_e57(InputFile file, Damage = Damage::reject);

}  // namespace alidade
