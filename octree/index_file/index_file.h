// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/progress.h"
#include "base/scratch_file.h"
#include "cloud/cloud_inputs.h"
#include "cloud/large_cloud.h"
#include "cloud/point_cloud.h"
#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "octree/octree.h"

// Index files (.alidade): the octree over a cloud with all attributes of its points and the metadata of the
// cloud's files, so that one file replaces the LAS and is queried without building anything. Flat
// little-endian arrays; docs/index_file.md has them byte by byte.
//
//   save_index("site.alidade", build(cloud), cloud);  // octree/index_file/save_index.h
//   const IndexFile index = open_index("site.alidade");
//   if (std::optional<Hit> hit = closest(index.octree(), ray, {.radius = 0.05}))
//     use(index.columns().colors[hit->point_id]);
//
// A damaged file is an Error, never a crash, however it is used. What that costs, and when:
// - open_index() checks all counts, sizes and offsets, the first page, and the metadata with their checksums,
//   and opens a file of any number of points in under 10 ms.
// - octree() reads nodes and ids once (about 5 bytes per point), in parallel, before the first query:
//   checksums, links and ids. Queries then end and stay inside the arrays. About a quarter of a second of
//   processor time for 10^8 points in memory, shared by the cores; otherwise as fast as the disk delivers.
//   The nodes (about 1 byte per point) are copied; all else is read from the mapped file (base/local_map.h).
// - coordinates and attribute columns may hold any values without harm to a program; only verify_index()
//   reads them all. Without it, a damaged coordinate is a wrong answer.
//
// Of a remote file, opening it fetches header and metadata, and records() the records. octree(), columns()
// and verify() need it all: the first of them fetches the file (RemoteFile::map()), with those errors, too.

namespace alidade {

struct IndexHeader;

/// An open index file. Copies share the map; safe to use from many threads.
class IndexFile {
 public:
  /// Errors: as open_index().
  explicit IndexFile(const InputFile& file);

  const std::string& name() const;
  /// Number of points, bounds, lattice, and the section table.
  const IndexHeader& header() const;
  /// The metadata of the cloud's files: coordinate reference system, files, warnings, extra dimensions
  /// without values, GPS time; records without their data. It has no points.
  const PointCloud& description() const;
  /// The attribute columns in the map; row = point id. Valid as long as a copy of this object or an octree of
  /// it.
  const AttributeColumns& columns() const;
  AttributeSet attributes() const;
  /// The records with their data. Cost: that of copying them. Errors: their checksum is wrong.
  std::vector<VariableLengthRecord> records() const;

  /// The tree in the map. The first call checks nodes and ids, see above; later ones are free. `progress` is
  /// in bytes checked. Errors: a wrong checksum or link; they name section and byte.
  const TreeView& tree(const Progress& progress = {}) const;
  /// tree() as an octree with the layers of the file, which keeps the map alive.
  Octree octree(const Progress& progress = {}) const;

  /// Reads everything: all checksums, that the tree is one and holds each point once inside its boxes, and
  /// that the gaps between the sections are zero. `progress` is in bytes. Cost: as fast as the disk delivers,
  /// 12 B of memory per node and 1/4 B per point. Errors: the first damage, with section and byte.
  void verify(const Progress& progress = {}) const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

/// Opens an index file. Cost: under 10 ms at any number of points, since only header and metadata are read.
/// Errors: missing or unreadable; not an index file; of another byte order or version; truncated; a count,
/// size or offset that does not fit the file; damaged header or metadata. They name the byte.
IndexFile open_index(const std::filesystem::path& path);

/// open_index() and IndexFile::verify().
void verify_index(const std::filesystem::path& path, const Progress& progress = {});

/// Index files as clouds (resolve_clouds()): points come back in the rows they had.
extern const CloudFormat k_index_format;

/// Index files and file_formats().
CloudFormats index_and_file_formats();

/// A cloud ready for queries: octree, and attributes by point id. The octree of one index file comes straight
/// from the map; everything else is read and built.
struct IndexedCloud {
  Octree octree;
  /// The metadata of the files; the attribute columns if they were read; no positions.
  PointCloud cloud;
  std::optional<IndexFile> index;     ///< the columns lie in here if it is there
  std::shared_ptr<LargeCloud> large;  ///< or in here

  /// The attribute columns, wherever they are; valid as long as this object is neither moved nor changed.
  AttributeColumns columns() const;
};

struct IndexCloudOptions {
  ReadOptions read{};    ///< attributes and colour depth; an index file gives all that it has, unchanged
  BuildOptions build{};  ///< of files that have no octree yet
  /// For clouds larger than memory: points and octree lie in scratch files, and so does what is measured
  /// later. Requires `read_large`, which an extension has.
  std::optional<ScratchSpace> scratch{};
  ReadLargeCloud read_large = nullptr;
};

/// Loads clouds for queries: a single index file is mapped and checked (IndexFile::tree), unless its heights
/// are wanted in another unit; anything else goes through read_cloud() and build(). read.progress is in
/// bytes; while the octree is built it repeats the last numbers. `cloud.files` are the files that the points
/// come from, also those an index was made of. Errors: as read_cloud(), build() and open_index(). Memory: for
/// an index file about 1 B per point; with IndexCloudOptions::scratch what `read_large` and
/// build_in_scratch() take.
IndexedCloud load_indexed_cloud(const CloudInputs& inputs, const IndexCloudOptions& options = {});

}  // namespace alidade
