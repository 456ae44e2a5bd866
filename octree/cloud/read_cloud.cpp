// SPDX-License-Identifier: MIT
#include "octree/cloud/read_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>

#include "octree/cloud/cloud_reader.h"
#include "octree/cloud/fit_lattice.h"
#include "octree/cloud/join_records.h"
#include "octree/cloud/spread_colors.h"
#include "octree/error.h"

namespace alidade {
namespace {

/// A file that waits to be read.
struct Source {
  std::unique_ptr<CloudReader> reader;
  std::uint64_t bytes = 0;
  CoordinateSurvey survey;  ///< of files without a lattice

  bool has_lattice() const { return reader->lattice().has_value(); }
  const std::filesystem::path& path() const { return reader->file().path; }
  std::uint64_t point_count() const {
    return has_lattice() ? reader->point_count().value_or(0) : survey.finite_count;
  }
};

/// Progress over several passes, each of which counts its own bytes.
class JoinedProgress {
 public:
  JoinedProgress(const Progress& progress, std::uint64_t total) : progress_(progress), total_(total) {}

  /// What to give to the next pass, over a file of `bytes` bytes.
  Progress pass(std::uint64_t bytes) {
    const std::uint64_t before = done_;
    done_ += bytes;
    if (!progress_) return {};
    return [this, before, bytes](std::uint64_t done, std::uint64_t) {
      return progress_(before + std::min(done, bytes), total_);
    };
  }

 private:
  const Progress& progress_;
  std::uint64_t total_;
  std::uint64_t done_ = 0;
};

Lattice shared_lattice(const std::vector<Source>& sources) {
  const Source* first = nullptr;
  for (const Source& source : sources) {
    // The lattice of a file without points binds nobody, unless there is no other.
    if (!source.has_lattice() || (first && (first->point_count() > 0 || source.point_count() == 0))) continue;
    first = &source;
  }
  if (!first) {
    std::vector<CoordinateSurvey> surveys;
    for (const Source& source : sources) surveys.push_back(source.survey);
    return fit_lattice(surveys);
  }
  const Lattice lattice = *first->reader->lattice();
  for (const Source& source : sources) {
    if (source.point_count() == 0) continue;
    if (source.has_lattice()) {
      const Lattice own = *source.reader->lattice();
      if (steps_between(own, lattice)) continue;
      throw Error({.file = source.path().string(),
                   .problem = "does not share the lattice of " + first->path().string(),
                   .expected = fmt::format("scale {}, {}, {} and an offset that differs by whole steps",
                                           lattice.scale.x, lattice.scale.y, lattice.scale.z),
                   .found = fmt::format("scale {}, {}, {} and offset {}, {}, {}", own.scale.x, own.scale.y,
                                        own.scale.z, own.offset.x, own.offset.y, own.offset.z)});
    }
    const Bounds& bounds = source.survey.bounds;
    if (!to_lattice(lattice, bounds.min) || !to_lattice(lattice, bounds.max)) {
      throw Error({.file = source.path().string(),
                   .problem = "lies too far away for the lattice of " + first->path().string(),
                   .found = fmt::format("a box from {}, {}, {} to {}, {}, {}", bounds.min.x, bounds.min.y,
                                        bounds.min.z, bounds.max.x, bounds.max.y, bounds.max.z)});
    }
  }
  return lattice;
}

/// The rule stands at read_cloud(). It does not ask what floats of the size of the coordinates could tell
/// apart: far from the origin that is centimetres.
void warn_of_rounding(const Source& source, PointCloud& cloud) {
  constexpr double k_matters = 1e-6;
  if (source.has_lattice() || source.point_count() == 0) return;
  const glm::dvec3 sides = source.survey.bounds.max - source.survey.bounds.min;
  const double longest = std::max({sides.x, sides.y, sides.z});
  for (int axis = 0; axis < 3; ++axis) {
    const double resolution = source.survey.resolution[axis];
    const double rounding = 0.5 * cloud.lattice.scale[axis];
    if (resolution == 0.0 || rounding <= std::max(resolution * (1 + 1e-9), k_matters * longest)) continue;
    cloud.warnings.push_back(fmt::format("{}: coordinates are rounded to steps of {}", source.path().string(),
                                         cloud.lattice.scale[axis]));
    return;
  }
}

/// What one file gave to the cloud.
struct GivenRows {
  std::string file_name;
  std::uint64_t point_count = 0;
  AttributeSet attributes;
};

/// Says which attributes were filled with zeros, and where.
void warn_of_gaps(const std::vector<GivenRows>& given, AttributeSet wanted, PointCloud& cloud) {
  const AttributeSet present = cloud.attributes() & wanted;
  for (const GivenRows& rows : given) {
    AttributeSet missing;
    missing.bits = present.bits & ~rows.attributes.bits;
    if (missing.bits == 0 || rows.point_count == 0) continue;
    cloud.warnings.push_back(fmt::format("{}: has no {}, which is filled with zeros", rows.file_name,
                                         fmt::join(attribute_names(missing), ", ")));
  }
}

}  // namespace

PointCloud join_files(std::vector<InputFile> files, const ReadOptions& options) {
  std::vector<Source> sources;
  std::uint64_t bytes_to_read = 0;
  for (InputFile& file : files) {
    const std::uint64_t bytes = file.size();
    Source& source = sources.emplace_back(Source{open_cloud(std::move(file)), bytes, {}});
    bytes_to_read += source.has_lattice() ? bytes : 2 * bytes;
    source.reader->rest();
  }
  JoinedProgress progress(options.progress, bytes_to_read);
  for (Source& source : sources) {
    if (source.has_lattice()) continue;
    source.survey = source.reader->survey(progress.pass(source.bytes));
    source.reader->rest();
  }

  PointCloud cloud;
  cloud.lattice = shared_lattice(sources);
  std::uint64_t point_count = 0;
  for (const Source& source : sources) point_count += source.point_count();
  cloud.positions.reserve(static_cast<std::size_t>(point_count));

  std::vector<GivenRows> given;
  std::vector<ColoredRows> colored;
  JoinedRecords records(cloud.records);
  for (Source& source : sources) {
    const std::size_t first_row = cloud.size(), first_record = cloud.records.size();
    source.reader->read(cloud, options.attributes, progress.pass(source.bytes));
    records.join(first_record);
    const CloudFile& file = source.reader->file();
    given.push_back({file.path.string(), file.point_count, source.reader->attributes()});
    warn_of_rounding(source, cloud);
    if (file.format == "LAS" && cloud.size() > first_row &&
        (given.back().attributes & options.attributes).contains(Attribute::color)) {
      colored.push_back({file.path.string(), first_row, cloud.size()});
    }
    std::ranges::move(source.reader->sources(), std::back_inserter(cloud.files));
    source.reader.reset();
  }
  spread_colors(cloud, colored, options.color_depth);
  warn_of_gaps(given, options.attributes, cloud);
  report(options.progress, bytes_to_read, bytes_to_read);
  return cloud;
}

PointCloud read_cloud(std::span<const std::filesystem::path> paths, const ReadOptions& options) {
  std::vector<InputFile> files;
  for (const std::filesystem::path& path : paths) files.emplace_back(path).rest();
  return join_files(std::move(files), options);
}

PointCloud read_cloud(const std::filesystem::path& file, const ReadOptions& options) {
  return read_cloud(std::span(&file, 1), options);
}

}  // namespace alidade
