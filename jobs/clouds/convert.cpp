// SPDX-License-Identifier: MIT
#include "jobs/clouds/convert.h"

#include <fmt/format.h>
#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <span>
#include <utility>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/parallel.h"
#include "base/words.h"
#include "cloud/axis_units.h"
#include "cloud/cloud_reader.h"
#include "cloud/las/repack_las.h"
#include "cloud/las/write_las.h"
#include "cloud/rows.h"
#include "cloud/select_points.h"
#include "geo/reproject.h"
#include "jobs/cloud_fields.h"
#include "jobs/clouds/index.h"
#include "jobs/large_clouds.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"
#include "jobs/write_points.h"
#include "surface/point_surface.h"

namespace alidade::jobs {
namespace {

std::size_t memory_of(const ConvertRequest& request) {
  return request.memory.value_or(std::size_t{4} << 30);
}

/// The extension's output that the request names; null: a format of files or an index file.
const CloudStore* store_of(const ConvertRequest& request) {
  return store_of(request.stores, request.output, true);
}

StoreTarget target_of(const ConvertRequest& request) {
  return {.output = request.output, .overwrite = request.overwrite};
}

/// Whether points change after reading: some are dropped, or they get normals.
bool chooses_points(const ConvertRequest& request) {
  return request.every > 1 || request.spacing.has_value() || request.normals;
}

/// Whether nothing changes but how the points of one LAS file are packed.
bool only_packing_changes(const ConvertRequest& request) {
  const bool chooses = request.files.inputs.front().is_changed() || chooses_points(request);
  return has_extension(request.output, {".las", ".laz"}) && !is_copc_name(request.output) &&
         request.files.size() == 1 && !chooses && request.color_depth == ColorDepth::automatic &&
         !request.partial && can_repack(request.files.first_name());
}

constexpr const char* k_one_unit = "--reproject SYSTEM, which brings heights to the unit of x and y";

/// What is wrong if x and y have another unit than heights, by the first cloud; else empty.
std::string unit_problem(const ConvertRequest& request) {
  if (request.files.empty()) return {};
  const CloudInput& first = request.files.inputs.front();
  if (first.format == nullptr) return {};
  const Crs crs = open_cloud(first, request.partial ? Damage::read_over : Damage::reject)->facts().crs;
  const AxisUnits units = axis_units(crs);
  if (!units.plane || !units.heights || *units.plane == *units.heights) return {};
  return fmt::format("the unit of x and y is {}, that of heights {}", units.plane->name, units.heights->name);
}

/// Whether the points, and measurements of them, are too large for memory.
bool is_large(const ConvertRequest& request) {
  constexpr std::uint64_t k_octree = 52, k_thinning = 17;  // bytes per point
  const StatedSize size = stated_size(request.files);
  // Files that do not state their number of points: coordinates rarely take less than those of a lattice.
  const std::uint64_t points = size.point_count + size.uncounted_bytes / sizeof(LatticePosition);
  const std::uint64_t beside = request.normals ? k_octree : request.spacing ? k_thinning : 0;
  return size.bytes() + beside * points > memory_of(request);
}

/// Thins the cloud.
void choose_points(HeldCloud& held, const ConvertRequest& request, Listener& listener) {
  LargeCloud* const large = large_of(held);
  if (request.every > 1 && large == nullptr) keep_every(std::get<PointCloud>(held), request.every);
  if (request.every > 1 && large != nullptr)
    in_stage(listener, "choosing", "points",
             [&](const Progress& progress) { large->keep_every(request.every, progress); });
  if (!request.spacing) return;
  in_stage(listener, "thinning", "points", [&](const Progress& progress) {
    with_file(request.files.title(), [&] {
      large != nullptr ? large->thin(*request.spacing, progress)
                       : thin(std::get<PointCloud>(held), *request.spacing, progress);
    });
  });
}

/// Calls work(first, end) for pieces of so many rows, until the job stops. Errors: Cancelled.
template <class Work>
void in_pieces(std::size_t rows, Listener& listener, const Work& work) {
  constexpr std::size_t k_piece = std::size_t{1} << 20;
  for (std::size_t first = 0; first < rows; first += k_piece) {
    if (listener.stops()) throw Cancelled();
    work(first, std::min(first + k_piece, rows));
  }
}

/// Gives every point the normal of the surface around it, towards the nearest scanner, or upwards where no
/// scanner is known; zero where there is no surface.
void measure_normals(const Octree& built, const PointColumns& points,
                     std::span<const ScannerPosition> scanners, std::span<glm::vec3> normals,
                     Listener& listener) {
  const Octree octree = with_surfaces(with_spacings(built, k_surface_neighbours, listener), listener);
  const auto measure = [&](std::size_t row) {
    const PointSurface surface = surface_of(octree.layers(), row);
    normals[row] = glm::vec3(0.0f);
    if (!surface.exists) return;
    const glm::dvec3 position = points.world(row);
    glm::dvec3 outwards(0.0, 0.0, 1.0);
    double nearest = std::numeric_limits<double>::infinity();
    for (const ScannerPosition& scanner : scanners) {
      const glm::dvec3 towards = scanner.position - position;
      if (glm::dot(towards, towards) >= nearest) continue;
      nearest = glm::dot(towards, towards);
      outwards = towards;
    }
    normals[row] = glm::vec3(glm::dot(surface.normal, outwards) < 0.0 ? -surface.normal : surface.normal);
  };
  in_pieces(points.size(), listener, [&](std::size_t first, std::size_t end) {
    in_parallel(end - first, 256, [&](std::size_t i) { measure(first + i); });
  });
}

/// The octree over positions that are kept: of a large cloud, a copy is used up.
Octree built(HeldCloud& held, Listener& listener) {
  LargeCloud* const large = large_of(held);
  const PointColumns points = points_of(held);
  HugeArray<LatticePosition> copy;
  if (large != nullptr) {
    copy = HugeArray<LatticePosition>(points.size(), large->scratch().folder);
    in_pieces(points.size(), listener, [&](std::size_t first, std::size_t end) {
      std::ranges::copy(points.positions.subspan(first, end - first), copy.data() + first);
    });
  }
  return in_stage(listener, "building", "points", [&](const Progress& progress) {
    if (large == nullptr) return build(std::as_const(std::get<PointCloud>(held)), {.progress = progress});
    return build_in_scratch(points.lattice, {copy.data(), copy.size()}, large->scratch(),
                            {.progress = progress});
  });
}

void add_normals(HeldCloud& held, Listener& listener) {
  const Octree octree = built(held, listener);
  std::span<glm::vec3> normals;
  if (LargeCloud* const large = large_of(held)) {
    normals = large->add_normals();
  } else {
    std::vector<glm::vec3>& column = std::get<PointCloud>(held).normals;
    column.resize(octree.size());
    normals = column;
  }
  measure_normals(octree, points_of(held), facts_of(held).scanner_positions, normals, listener);
}

/// All rows of a cloud in memory at once; of a large one so many.
PointPieces pieces_of(HeldCloud& held, std::size_t rows_at_once) {
  if (const auto* const cloud = std::get_if<PointCloud>(&held))
    return [cloud](std::size_t) -> const PointCloud& { return *cloud; };
  return [large = large_of(held), size = points_of(held).size(), rows_at_once,
          some = PointCloud()](std::size_t first) mutable -> const PointCloud& {
    return some = large->rows(first, std::min(rows_at_once, size - first));
  };
}

void write(const ConvertRequest& request, HeldCloud& held, Listener& listener) {
  if (has_extension(request.output, {".alidade"})) {
    write_index(request.output, held, {}, request.overwrite, listener);
    return;
  }
  // The formats of files copy rows, and others sort them.
  constexpr std::size_t k_sorting = 36, k_least_rows = std::size_t{1} << 14,
                        k_most_rows = std::size_t{1} << 20;
  const PointCloud& facts = facts_of(held);
  const std::size_t count = points_of(held).size();
  const AttributeSet attributes = points_of(held).attributes.attributes();
  const std::size_t row = 2 * bytes_per_point(facts, attributes) + k_sorting;
  const std::size_t room = std::clamp<std::size_t>(memory_of(request) / row, k_least_rows, UINT32_MAX);
  const CloudStore* const store = store_of(request);
  if (store == nullptr) {
    const PointRows rows{facts, attributes, count, pieces_of(held, std::min(room, k_most_rows))};
    write_rows(request.output, rows, request.overwrite, memory_of(request) / 2, listener);
    return;
  }
  in_stage(listener, "writing", "points", [&](const Progress& progress) {
    const OpenStore output = store->open(target_of(request));
    const auto sorted = [&] {
      if (large_of(held) == nullptr) return database::OrderedCloud(facts);
      // Merging takes memory for each piece.
      const PointPieces pieces = pieces_of(held, room);
      return database::OrderedCloud(output.folder, facts, count, [&](std::size_t first) -> const PointCloud& {
        report(progress, 0, count);
        return pieces(first);
      });
    };
    database::OrderedCloud cloud = sorted();
    output.store(cloud, progress);
  });
}

ConvertResult repack(const ConvertRequest& request, Listener& listener) {
  const RepackedFile repacked = in_stage(listener, "converting", "B", [&](const Progress& progress) {
    return repack_las(request.files.first_name(), request.output,
                      {.overwrite = request.overwrite, .progress = progress});
  });
  warn_all(listener, repacked.warnings);
  listener.note(fmt::format("wrote all {} points to {}, with unchanged records", repacked.point_count,
                            request.output.string()));
  return {repacked.point_count, repacked.point_count, {}};
}

/// Notes what was written. `before`: points of the files that were selected.
ConvertResult result_of(const ConvertRequest& request, std::uint64_t count, std::uint64_t before,
                        const std::vector<CloudFile>& files, const std::optional<Bounds>& bounds,
                        Listener& listener) {
  for (const CloudFile& file : files) before += file.left_out_count;
  listener.note(fmt::format("wrote {} of {} points to {}", count, before, request.output.string()));
  return {count, before, bounds};
}

/// Points of a cloud that memory need not hold, since they are sorted in any case.
ConvertResult convert_sorted(const ConvertRequest& request, const CloudStore& store, Listener& listener) {
  const database::StoredFiles stored =
      store_in_stages(request.files, {.color_depth = request.color_depth, .partial = request.partial},
                      memory_of(request), "writing", store.open(target_of(request)), listener);
  return result_of(request, stored.point_count, stored.point_count, stored.files, {}, listener);
}

/// ".las", ...: the extensions of all formats that are written.
std::vector<std::string> extensions_of(const ConvertRequest& request) {
  std::vector<std::string> all = {".las", ".laz", ".copc.laz", ".ply", ".csv", ".xyz", ".alidade"};
  for (const auto& store : request.stores) {
    if (store->is_file()) all.push_back(store->form());
  }
  return all;
}

}  // namespace

void add_convert_fields(const Fields& fields, ConvertRequest& request) {
  add_cloud_files(fields.required(), "files", "FILE...", k_files_help + ", or index files" + database_help(),
                  request.files, add_view_fields(fields, {}, HeightUse::as_stored));
  fields.required().file("-o,--output", fmt::format("FILE{}", fmt::join(extensions_of(request), "|")),
                         "output file; the extension selects the format", request.output);
  fields.count("--every", "N", "keep the first point and every N-th after it", request.every, 1, UINT64_MAX);
  fields.length(
      "--spacing", "LENGTH",
      "keep one point per cube of this edge length, in the unit of the CRS, mostly metres: the point nearest "
      "to the mean of the cube's points, with the mean of their colours and intensities",
      request.spacing);
  fields.flag(
      "--normals",
      "give the points normals, of the planes through their neighbours: towards the nearest scanner where "
      "the file has scanner positions (E57, PTX, PCD), else upwards; zero for points without a surface",
      request.normals);
  for (const auto& store : request.stores) store->add_fields(fields);
  fields.choice("--color-depth",
                "bits in use of LAS colours (default: 8 if none exceeds 255); the output has 16",
                request.color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  add_partial(fields, request.partial);
  fields.value(
      "--memory", "SIZE",
      "memory for points: bytes, or a number with k, M, G or T (default: 4G); those of a larger cloud "
      "use temporary files next to the output; the output is the same",
      request.memory, parse_memory);
  fields.flag("--overwrite", "replace an existing output", request.overwrite);
}

ConvertPlan plan(const ConvertRequest& request) {
  check_extension(request.output, extensions_of(request));
  for (const auto& store : request.stores) {
    if (const std::string problem = store->misplaced(); !problem.empty() && store.get() != store_of(request))
      throw file_error(request.output, problem, "the extension " + store->form());
  }
  check_writable(request.output, request.overwrite, request.inputs());
  if (request.spacing || request.normals) {
    if (const std::string problem = unit_problem(request); !problem.empty())
      throw file_error(request.files.first_name(), "--spacing and --normals measure: " + problem, k_one_unit);
  }
  return ConvertPlan(request,
                     {.clouds = request.files, .partial = request.partial, .writes = {request.output}});
}

ConvertResult run(const ConvertPlan& plan, Listener& listener) {
  const ConvertRequest& request = plan.request();
  const CloudStore* const store = store_of(request);
  if (store != nullptr && !request.spacing && !request.normals) {
    if (const std::string problem = unit_problem(request); !problem.empty())
      listener.warn(fmt::format("{}: {}; distances need one unit: {}", request.files.first_name().string(),
                                problem, k_one_unit));
  }
  if (only_packing_changes(request)) return repack(request, listener);
  if (store != nullptr && !chooses_points(request)) return convert_sorted(request, *store, listener);
  std::optional<ScratchSpace> scratch;
  const bool exceeds_memory = is_large(request);
  if (exceeds_memory && large_clouds() == nullptr) {
    listener.note("the points exceed --memory and lie in memory, as the extension scratch is missing");
  } else if (exceeds_memory) {
    scratch = scratch_beside(request.output, memory_of(request) / 2);
    listener.note("the points exceed --memory and lie in temporary files in " + scratch->folder.string());
  }
  HeldCloud cloud = hold_cloud(
      request.files, {.color_depth = request.color_depth, .partial = request.partial}, scratch, listener);
  warn_all(listener, facts_of(cloud).warnings);
  const std::size_t before = points_of(cloud).size();
  choose_points(cloud, request, listener);
  const PointColumns points = points_of(cloud);
  const std::size_t count = points.size();
  const Bounds bounds = bounds_of(points.lattice, points.positions);
  if (request.normals && count > 0) add_normals(cloud, listener);
  write(request, cloud, listener);
  return result_of(request, count, before, facts_of(cloud).files, bounds, listener);
}

}  // namespace alidade::jobs
