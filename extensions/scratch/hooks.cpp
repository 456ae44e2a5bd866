// SPDX-License-Identifier: MIT
#include <memory>

#include "extensions/scratch/index_reading.h"
#include "extensions/scratch/scratch_cloud.h"
#include "jobs/large_clouds.h"

namespace alidade::extensions {
namespace {

std::unique_ptr<LargeCloud> read(const CloudInputs& inputs, const ReadOptions& options,
                                 const ScratchSpace& scratch) {
  return std::make_unique<ScratchCloud>(inputs, options, scratch);
}

}  // namespace

void set_up_scratch() {
  jobs::set_large_clouds({.read = read,
                          .add_index_fields = jobs::add_reading_fields,
                          .check_index = jobs::check_reading,
                          .read_for_index = jobs::read_for_index});
}

}  // namespace alidade::extensions
