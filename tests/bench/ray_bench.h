// SPDX-License-Identifier: MIT
#pragma once

// What octree_bench measures. Each function registers benchmarks; names are words joined by '/', the number
// of points last.

namespace alidade::bench {

/// Rays on the campus, SET as in bench_site.h, MODE single, batch (the whole set in one call), both also with
/// _2_threads, and blocks_of_256:
/// - closest/SET/MODE/POINTS and occluded/SET/MODE/POINTS
/// - instruction_set/NAME/closest/SET/MODE/POINTS: single and batch with every instruction set
void register_octree_rays();

/// MODE single, packet16, stream, all also with _2_threads:
/// - embree/closest/SET/MODE/POINTS and embree/occluded/SET/MODE/POINTS
void register_embree_rays();

/// Bytes per point of the octree, and at the peak of its build beside the cloud; all also with _2_threads:
/// - build/octree/POINTS
/// - build/wide/POINTS: more than 2^21 lattice steps on an axis
/// - build/without_ids/POINTS: in stored order
/// - build/surfaces/POINTS: the surface of every point, in seconds per point
void register_octree_builds();

/// - build/embree_2_threads/POINTS, with the points in the octree's order
void register_embree_builds();

/// The other questions to rays, one thread, each query by itself:
/// - uniform/nearest/K/POINTS, uniform/radius/R/POINTS, uniform/closest_K/R/POINTS: Figure 5 of the paper
/// - site/nearest/K/POINTS, site/closest_by_t/POINTS: 3000 primary rays of the campus
/// - identical/closest/POINTS, identical/occluded/POINTS: all points at one position
void register_ray_questions();

}  // namespace alidade::bench
