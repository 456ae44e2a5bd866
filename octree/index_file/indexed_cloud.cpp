// SPDX-License-Identifier: MIT
#include "octree/index_file/indexed_cloud.h"

#include <utility>

#include "cloud/cloud_inputs.h"

namespace alidade {

IndexedCloud load_indexed_cloud(const CloudInputs& inputs, const IndexCloudOptions& options) {
  IndexedCloud loaded;
  if (const CloudInput* const index = inputs.only(k_index_format)) {
    loaded.index = IndexFile(index->file());
    loaded.octree = loaded.index->octree(options.read.progress);
    loaded.cloud = loaded.index->description();
    return loaded;
  }
  // Reading counts the work; what follows only asks whether to go on, at the count where reading ended.
  std::uint64_t done = 0, total = 0;
  ReadOptions read = options.read;
  read.progress = [&](std::uint64_t bytes, std::uint64_t all_bytes) {
    done = bytes;
    total = all_bytes;
    return !options.read.progress || options.read.progress(bytes, all_bytes);
  };
  loaded.cloud = read_cloud(inputs, read);
  BuildOptions build_options = options.build;
  if (!build_options.progress) {
    build_options.progress = [&](std::uint64_t, std::uint64_t) { return read.progress(done, total); };
  }
  loaded.octree = build(std::move(loaded.cloud), build_options);
  return loaded;
}

}  // namespace alidade
