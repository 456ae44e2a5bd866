// SPDX-License-Identifier: MIT
#pragma once

namespace alidade::bench {

/// Registers, for every size of the site,
///   closest/SET/MODE/POINTS and occluded/SET/MODE/POINTS   SET as in bench_site.h; MODE: single, batch (the
///   whole set
///     in one call), blocks_of_256; each also with _2_threads
///   instruction_set/NAME/closest/SET/MODE/POINTS           single and batch with every instruction set
///   build/octree/POINTS, build/octree_2_threads/POINTS     with memory
void register_octree_rays();

/// Registers embree/closest/SET/MODE/POINTS, embree/occluded/..., with MODE single, packet16,
/// packet16_coherent, stream, stream_coherent, stream_of_256 and _2_threads after each; and
/// embree/build/POINTS.
void register_embree_rays();

}  // namespace alidade::bench
