// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "base/progress.h"
#include "cloud/copc/copc_file.h"
#include "cloud/laz/chunk_codec.h"
#include "octree/boxed_points.h"

namespace alidade {

/// What was read of a COPC file so far.
struct CopcReads {
  std::uint64_t chunks_decoded = 0;  ///< again counts again
  std::uint64_t points_decoded = 0;
  std::uint64_t chunks_met = 0;  ///< decoded at least once
};

/// Points of a COPC file, node by node, decoded when they are asked for and kept while there is room. Thread
/// safe: who asks for a node that another thread is decoding waits for it.
class CopcCache {
 public:
  struct Options {
    std::size_t byte_count = std::size_t{512} << 20;  ///< most to keep; what is in use may be more
    std::optional<std::bitset<256>> classes{};        ///< only points of these
    /// Asked whenever a node was decoded, by one thread at a time, in points decoded so far and points of the
    /// file; points that are decoded again count again.
    Progress progress{};
  };

  /// The file must outlive the cache.
  CopcCache(const CopcFile& file, const Options& options);
  ~CopcCache();

  const CopcFile& file() const { return file_; }

  /// The points of a node of the file's hierarchy; none if it has no chunk. Rows count within the node. Those
  /// asked for least recently give way to new ones. Errors: the chunk is damaged, or a point lies outside
  /// CopcFile::bounds() of its node. Cancelled, if the progress function says so. Cost: about 0.2
  /// microseconds per point if they are not there.
  std::shared_ptr<const BoxedPoints> points(std::uint32_t node) const;

  CopcReads reads() const;

 private:
  struct Slot;
  struct Workshop {  ///< of a thread
    ChunkDecoder decoder;
    std::vector<std::byte> bytes;
  };

  std::shared_ptr<const BoxedPoints> decode(std::uint32_t node) const;
  std::shared_ptr<const BoxedPoints> find(std::uint32_t node) const;
  void keep(std::uint32_t node, std::shared_ptr<const BoxedPoints> points) const;

  const CopcFile& file_;
  Options options_;
  std::unique_ptr<Slot[]> slots_;
  mutable tbb::enumerable_thread_specific<Workshop> workshops_;
  mutable std::mutex mutex_;               ///< of all that follows
  mutable std::list<std::uint32_t> kept_;  ///< nodes, those asked for last first
  mutable std::size_t kept_bytes_ = 0;
  mutable CopcReads reads_;
};

}  // namespace alidade
