// SPDX-License-Identifier: MIT
#include "jobs/clouds/index.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/date_time.h"
#include "base/error.h"
#include "base/fingerprint.h"
#include "base/input_file.h"
#include "jobs/cloud_fields.h"
#include "jobs/outputs.h"
#include "octree/index_file/save_index.h"
#include "octree/spacing.h"
#include "surface/point_surface.h"

namespace alidade::jobs {
namespace {

/// The attribute of a name. Errors: an unknown name.
AttributeSet attribute_of(const std::string& name) {
  for (AttributeSet one(Attribute::color); one.bits <= AttributeSet::all().bits; one.bits <<= 1) {
    if (std::ranges::count(attribute_names(one), name) > 0) return one;
  }
  throw UsageError(fmt::format("unknown attribute; expected none or some of {}; found '{}'",
                               fmt::join(attribute_names(AttributeSet::all()), ", "), name));
}

/// "color,intensity", or "none". return_number and number_of_returns are kept together. Errors: an unknown
/// name.
AttributeSet parse_attributes(const std::string& text) {
  AttributeSet attributes;
  if (text == "none") return attributes;
  for (const std::string& word : split_list(text)) attributes = attributes | attribute_of(word);
  return attributes;
}

Octree measured(const Octree& octree, const IndexContents& contents, Listener& listener) {
  const std::optional<int> neighbours =
      contents.surfaces ? k_surface_neighbours : contents.spacing_neighbours;
  if (!neighbours) return octree;
  const Octree with = with_spacings(octree, *neighbours, listener);
  return contents.surfaces ? with_surfaces(with, listener) : with;
}

}  // namespace

void add_index_fields(const Fields& fields, IndexRequest& request) {
  IndexContents& contents = request.contents;
  add_cloud_files(fields.required(), "files", "FILE...", k_files_help, request.files,
                  add_view_fields(fields));
  fields.required().file("-o,--output", "FILE.alidade", "output index file", request.output);
  fields.choice(
      "--organisation",
      "how the octree stores points, without effect on answers (default adaptive): cells split until few "
      "points remain, a grid of equal cells, or coarse to fine, so that the first levels are a thinned cloud",
      contents.organisation,
      {{"adaptive", Organisation::adaptive},
       {"fixed", Organisation::fixed},
       {"layered", Organisation::layered}});
  fields.length("--cell-size", "LENGTH",
                "longest side of a cell of --organisation fixed, in the unit of the CRS, mostly metres "
                "(default: cells with 32 points on average)",
                contents.cell_size);
  fields.flag("--stored-order",
              "number the points in the order of the octree: saves 4 bytes per point, but point ids differ "
              "from those of the input",
              contents.stored_order);
  fields.choice("--color-depth",
                "bits in use of LAS colours (default: 8 if none exceeds 255); colours of 8 bits take "
                "3 bytes per point in the index, others 6",
                request.color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  fields.value("--attributes", "LIST",
               "attributes to keep, by the names that 'alidade info' prints, such as "
               "color,intensity,classification, or none (default: all)",
               request.attributes, parse_attributes);
  fields.count("--spacings", "N",
               "store the distance of every point to its N-th nearest neighbour, 1 to 64 (usually 8): "
               "'alidade render --radius adapted' then measures nothing; 2 bytes per point and 16 per node",
               contents.spacing_neighbours, 1, k_most_spacing_neighbours);
  fields.flag("--surfaces",
              "store the surface around each point for 'alidade visibility', which then measures nothing; "
              "implies --spacings 8; 4 bytes per point",
              contents.surfaces);
  if (large_clouds() != nullptr) large_clouds()->add_index_fields(fields, request);
  fields.flag("--overwrite", "replace an existing output", request.overwrite);
  add_partial(fields, request.partial);
}

IndexPlan plan(const IndexRequest& request) {
  const IndexContents& contents = request.contents;
  check_that(contents.cell_size == 0.0 || contents.organisation == Organisation::fixed,
             "--cell-size requires --organisation fixed");
  check_extension(request.output, {".alidade"});
  if (contents.surfaces && contents.spacing_neighbours &&
      *contents.spacing_neighbours != k_surface_neighbours) {
    throw input_error("--surfaces requires the 8th neighbour", "--spacings 8, or none",
                      std::to_string(*contents.spacing_neighbours));
  }
  check_that(!request.memory || !contents.stored_order, "--memory excludes --stored-order");
  check_writable(request.output, request.overwrite, request.inputs());
  check_that(request.memory || request.checkpoint.file.empty(), "--checkpoint requires --memory");
  if (large_clouds() != nullptr) large_clouds()->check_index(request);
  // Points in scratch files take memory of that size only.
  return IndexPlan(request, {.clouds = request.files,
                             .partial = request.partial,
                             .writes = {request.output, request.checkpoint.file},
                             .bytes_per_point = request.memory ? 0.0 : 39.0});
}

IndexResult run(const IndexPlan& plan, Listener& listener) {
  const IndexRequest& request = plan.request();
  const ReadOptions options{
      .attributes = request.attributes, .color_depth = request.color_depth, .partial = request.partial};
  const std::optional<ScratchSpace> scratch = scratch_beside(request.output, request.memory);
  HeldCloud cloud = scratch ? large_clouds()->read_for_index(request, options, *scratch, listener)
                            : hold_cloud(request.files, options, {}, listener);
  warn_all(listener, facts_of(cloud).warnings);
  const IndexResult result =
      write_index(request.output, cloud, request.contents, request.overwrite, listener);
  if (scratch) large_of(cloud)->finish();
  return result;
}

IndexResult write_index(const std::filesystem::path& path, HeldCloud& cloud, const IndexContents& contents,
                        bool overwrite, Listener& listener) {
  LargeCloud* const large = large_of(cloud);
  Octree octree = in_stage(listener, "building", "points", [&](const Progress& progress) {
    const BuildOptions options{
        .organisation = contents.organisation, .cell_size = contents.cell_size, .progress = progress};
    if (large != nullptr)
      return build_in_scratch(large->facts().lattice, large->positions(), large->scratch(), options);
    PointCloud& in_memory = std::get<PointCloud>(cloud);
    return contents.stored_order ? build_in_stored_order(in_memory, options)
                                 : build(std::move(in_memory), options);
  });
  octree = measured(octree, contents, listener);
  in_stage(listener, "writing", "B", [&](const Progress& progress) {
    SaveIndexOptions options{.overwrite = overwrite, .progress = progress};
    if (large != nullptr) options.written = discard_scratch_pages;
    save_index(path, octree, facts_of(cloud), points_of(cloud).attributes, options);
  });
  const IndexResult result{octree.size(), std::filesystem::file_size(path), octree.memory()};
  const auto per_point = [&](std::uint64_t bytes) {
    return octree.size() > 0 ? static_cast<double>(bytes) / static_cast<double>(octree.size()) : 0.0;
  };
  listener.note(fmt::format("{} points, {:.1f} bytes each, {:.1f} of them octree; wrote {}", octree.size(),
                            per_point(result.bytes), per_point(result.octree_bytes), path.string()));
  return result;
}

}  // namespace alidade::jobs
