// SPDX-License-Identifier: MIT
#include "cloud/read_in_pieces.h"

#include <fmt/format.h>
#include <algorithm>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/bounds.h"
#include "base/error.h"
#include "base/parallel.h"
#include "cloud/catalog.h"
#include "cloud/crs.h"
#include "cloud/input_view.h"
#include "cloud/joined_files.h"
#include "cloud/rows.h"

namespace alidade {
namespace {

/// Points that are read into pieces at once, or an eighth of all points if that is more.
constexpr std::uint64_t k_few_points = 1 << 22;

/// Opens a file, or notes that a catalog says that no point of it is needed.
CloudSource open_source(const CloudInput& input, Unwanted unwanted, const ReadOptions& options) {
  CloudSource source;
  if (unwanted != Unwanted::no) {
    source.facts.file.path = public_name(input.name.string());
    source.facts.file.format = input.format->name;
    source.survey = {.bounds = input.stated->box, .finite_count = input.stated->point_count};
    if (unwanted == Unwanted::left_out)
      source.facts.file.left_out_count = std::exchange(source.survey.finite_count, 0);
    source.is_skipped = true;
    return source;
  }
  source.reader = open_cloud(input, options.partial ? Damage::read_over : Damage::reject);
  source.facts = source.reader->facts();
  source.is_skipped = options.region && !options.partial && source.has_lattice() && source.facts.box &&
                      !meet(*source.facts.box, *options.region);
  source.reader->rest();
  return source;
}

std::vector<CloudSource> open_sources(const CloudInputs& inputs, const ReadOptions& options) {
  inputs.check_files();
  std::vector<CloudSource> sources(inputs.size());
  // The facts of the cloud are those of the first file, its lattice is that of the first file with points.
  const auto with_points = std::ranges::find_if(
      inputs.inputs, [](const CloudInput& input) { return !input.stated || input.stated->point_count > 0; });
  const auto first_with_points = static_cast<std::size_t>(with_points - inputs.inputs.begin());
  in_parallel(inputs.size(), 1, k_most_files_at_once, [&](std::size_t i) {
    const bool is_needed = i == 0 || i == first_with_points;
    const CloudInput& input = inputs.inputs[i];
    sources[i] = open_source(input, is_needed ? Unwanted::no : what_is_unwanted(input, options), options);
  });
  return sources;
}

/// A file that was read into a cloud of its own.
struct ReadPiece {
  PointCloud cloud;
  FileRead done;
};

/// Joins sources one by one, in their order.
class Joining {
 public:
  Joining(PointCloud& cloud, const ReadOptions& options, const CloudPieces& pieces)
      : cloud_(cloud), options_(options), given_pieces_(pieces) {
    if (!pieces.take) return;
    pieces_ = {pieces.most_bytes, pieces.bytes_beside, [this](PointCloud&) { hand_over(); }, pieces.recall};
  }

  /// Takes the next file: its points from `piece` if they have been read into one, else from the file.
  void add(CloudSource& source, ReadPiece* piece, const Progress& progress) {
    const std::size_t first_record = cloud_.records.size();
    const std::uint64_t first_row = row_count();
    const AttributeSet attributes = source.facts.attributes;
    const bool is_colored =
        is_las(source.facts.file) && (attributes & options_.attributes).contains(Attribute::color);
    if (is_colored) colored_.push_back({source.name(), first_row});
    FileRead done;
    if (piece == nullptr) {
      done = source.reader->read(cloud_, options_.attributes, pieces_, progress);
    } else {
      append_cloud(cloud_, std::move(piece->cloud));
      done = std::move(piece->done);
    }
    source.reader.reset();
    join_records(first_record);
    if (is_colored) {
      // The depth of a file is that of all its points, selected or not.
      ColoredRows& rows = colored_.back();
      rows.end = row_count();
      rows.largest_color = std::max(rows.largest_color, done.left_out_colors.color);
      rows.largest_near_infrared = std::max(rows.largest_near_infrared, done.left_out_colors.near_infrared);
    }
    if (row_count() > first_row) {
      given_.emplace_back(source.name(), attributes);
      attributes_ = attributes_ | cloud_.attributes() | (attributes & options_.attributes);
    }
    warn_of_rounding(source);
    warn_of_losses(source, done);
    for (CloudFile& file : done.files) {
      file.is_rounded = file.is_rounded || is_rounded(source, cloud_.lattice);
      cloud_.files.push_back(std::move(file));
    }
  }

  void skip(CloudSource& source) {
    CloudFile& file = cloud_.files.emplace_back(std::move(source.facts.file));
    file.skipped_count = source.point_count();
    file.point_count = 0;
    source.reader.reset();
  }

  /// Adds the warnings about all files; returns how their colours are to be spread.
  ColorSpread finish() {
    measure();
    ColorSpread spread = choose_spread(std::move(colored_), options_.color_depth, cloud_.warnings);
    warn_of_gaps();
    if (is_geographic(cloud_.crs) || is_geocentric(cloud_.crs)) {
      bounds_.grow(cloud_.bounds());
      if (const auto problem = implausible_crs(cloud_.crs, bounds_)) cloud_.warnings.push_back(*problem);
    }
    return spread;
  }

  std::uint64_t row_count() const { return taken_ + cloud_.size(); }
  AttributeSet attributes() const { return attributes_; }

 private:
  void measure() {
    if (options_.color_depth != ColorDepth::bits_16) measure_colors(cloud_, taken_, colored_);
  }
  void hand_over() {
    measure();
    bounds_.grow(cloud_.bounds());
    taken_ += cloud_.size();
    given_pieces_.take(cloud_);
  }

  /// Removes those records of the last file that an earlier file has: the tiles of a survey repeat them.
  /// Repetitions within one file stay.
  void join_records(std::size_t first) {
    std::vector<VariableLengthRecord>& all = cloud_.records;
    std::size_t kept = first;
    for (std::size_t i = first; i < all.size(); ++i) {
      if (records_.contains(i)) continue;
      if (kept != i) all[kept] = std::move(all[i]);
      ++kept;
    }
    all.resize(kept);
    for (std::size_t i = first; i < kept; ++i) records_.insert(i);
  }

  /// The resolution of floats at the size of the coordinates does not matter: far from the origin it is
  /// centimetres.
  void warn_of_rounding(const CloudSource& source) {
    constexpr double k_matters = 1e-6;
    if (source.has_lattice() || source.point_count() == 0) return;
    const glm::dvec3 sides = source.survey.bounds.max - source.survey.bounds.min;
    const double longest = std::max({sides.x, sides.y, sides.z});
    for (int axis = 0; axis < 3; ++axis) {
      const double resolution = source.survey.resolution[axis], step = cloud_.lattice.scale[axis];
      if (resolution == 0.0 || 0.5 * step <= std::max(resolution * (1 + 1e-9), k_matters * longest)) continue;
      cloud_.warnings.push_back(
          fmt::format("{}: coordinates are rounded to steps of {}", source.name(), step));
      return;
    }
  }

  /// Warns of points that could not be read, and counts them in the first of the files, their own.
  void warn_of_losses(const CloudSource& source, FileRead& done) {
    constexpr std::size_t k_most_reported = 10;
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < done.lost.size(); ++i) {
      const auto& [points, location, problem] = done.lost[i];
      count += points;
      if (i >= k_most_reported) continue;
      cloud_.warnings.push_back(fmt::format("{}{}{}: {}; {} lost", source.name(), location.empty() ? "" : ":",
                                            location, problem,
                                            points == 0   ? std::string("an unknown number of points is")
                                            : points == 1 ? std::string("1 point is")
                                                          : fmt::format("{} points are", points)));
    }
    if (done.lost.size() > k_most_reported)
      cloud_.warnings.push_back(fmt::format("{}: corrupt in {} more locations; {} points are lost in total",
                                            source.name(), done.lost.size() - k_most_reported, count));
    if (!done.files.empty()) done.files.front().lost_count = count;
  }

  /// Warns of attributes of the cloud that were filled with zeros.
  void warn_of_gaps() {
    Remarks gaps;
    for (const auto& [file, attributes] : given_) {
      AttributeSet missing;
      missing.bits = attributes_.bits & ~attributes.bits;
      if (missing.bits == 0) continue;
      gaps.add(fmt::format("no {}; using 0", fmt::join(attribute_names(missing), ", ")), file);
    }
    gaps.write(cloud_.warnings);
  }

  /// Compares records by their contents.
  struct RecordOrder {
    const std::vector<VariableLengthRecord>* records;
    bool operator()(std::size_t a, std::size_t b) const {
      const auto key = [this](std::size_t index) {
        const VariableLengthRecord& record = (*records)[index];
        return std::tie(record.record_id, record.user_id, record.description, record.extended, record.data);
      };
      return key(a) < key(b);
    }
  };

  PointCloud& cloud_;
  const ReadOptions& options_;
  const CloudPieces& given_pieces_;
  CloudPieces pieces_{};
  std::uint64_t taken_ = 0;  ///< points handed over
  Bounds bounds_;            ///< of the points handed over
  AttributeSet attributes_;
  std::set<std::size_t, RecordOrder> records_{RecordOrder{&cloud_.records}};  ///< of the files so far
  std::vector<std::pair<std::string, AttributeSet>> given_;  ///< the files with points, and what they have
  std::vector<ColoredRows> colored_;
};

/// The end of the lot of files from `first` on, at least one, that are read into pieces at once.
std::size_t end_of_lot(std::span<const CloudSource> sources, std::size_t first, std::uint64_t most_points) {
  const auto wanted = [&](std::size_t i) { return sources[i].is_skipped ? 0 : sources[i].point_count(); };
  std::uint64_t points = wanted(first);
  std::size_t end = first + 1;
  while (end < sources.size() && end - first < k_most_files_at_once && (points += wanted(end)) <= most_points)
    ++end;
  return end;
}

/// Reads a lot of files at once, each into a cloud of its own; empty for files that are skipped.
std::vector<std::optional<ReadPiece>> read_pieces(std::span<const CloudSource> lot, const Lattice& lattice,
                                                  AttributeSet wanted, JoinedProgress& progress) {
  std::vector<std::optional<ReadPiece>> pieces(lot.size());
  in_parallel(lot.size(), 1, [&](std::size_t i) {
    const CloudSource& source = lot[i];
    if (source.is_skipped) return;
    ReadPiece& piece = pieces[i].emplace();
    piece.cloud.lattice = lattice;
    piece.cloud.positions.reserve(static_cast<std::size_t>(source.least_points()));
    piece.done = source.reader->read(piece.cloud, wanted, {}, progress.pass(source.work()));
    source.reader->rest();
  });
  return pieces;
}

/// Errors: there are points, and a selection leaves none of them.
void check_selection(const CloudInputs& inputs, const PiecewiseCloud& whole) {
  if (whole.point_count > 0) return;
  std::uint64_t left_out = 0;
  Bounds box;
  for (const CloudFile& file : whole.rest.files) {
    left_out += file.left_out_count;
    if (file.left_out_count > 0 && file.stated_bounds) box.grow(*file.stated_bounds);
  }
  if (left_out == 0) return;
  std::string found = fmt::format("none of {} points", left_out);
  if (!box.empty())
    found += fmt::format(" from {}, {}, {} to {}, {}, {}", box.min.x, box.min.y, box.min.z, box.max.x,
                         box.max.y, box.max.z);
  throw file_error(inputs.title(), "no points are selected", "a selection that some points meet", found);
}

}  // namespace

Unwanted what_is_unwanted(const CloudInput& input, const ReadOptions& options) {
  const bool has_lattice = input.is(k_copc_format) || input.is(k_las_format);
  if (!input.stated || !has_lattice || options.partial) return Unwanted::no;
  if (input.is_changed()) {
    const auto& box = input.view->selection.box;
    const bool is_outside = box && !input.view->change_reference && !meet(input.stated->box, *box);
    return is_outside ? Unwanted::left_out : Unwanted::no;
  }
  return options.region && !meet(input.stated->box, *options.region) ? Unwanted::skipped : Unwanted::no;
}

PiecewiseCloud read_in_pieces(const CloudInputs& inputs, const ReadOptions& options,
                              const CloudPieces& pieces) {
  std::vector<CloudSource> sources = open_sources(inputs, options);
  std::uint64_t work = 0, bytes = 0;
  for (const CloudSource& source : sources) {
    work += source.has_lattice() ? source.work() : 2 * source.work();
    bytes += source.work();
  }
  // Two passes over a file are reported as one: its bytes count once.
  const Progress shown = [&](std::uint64_t done, std::uint64_t total) {
    const double share = total > 0 ? static_cast<double>(done) / static_cast<double>(total) : 1.0;
    return !options.progress ||
           options.progress(
               done == total ? bytes : static_cast<std::uint64_t>(share * static_cast<double>(bytes)), bytes);
  };
  JoinedProgress progress(shown, work);
  in_parallel(sources.size(), 1, k_most_files_at_once, [&](std::size_t i) {
    CloudSource& source = sources[i];
    if (!source.reader || source.has_lattice()) return;
    source.survey = source.reader->survey(progress.pass(source.work()));
    source.facts.attributes = source.reader->facts().attributes;
    source.reader->rest();
  });

  PiecewiseCloud whole;
  PointCloud& cloud = whole.rest;
  join_facts(sources, options.attributes, cloud);
  std::uint64_t point_count = 0;
  for (const CloudSource& source : sources) point_count += source.is_skipped ? 0 : source.least_points();
  const std::uint64_t most_in_piece = pieces.most_bytes / (sizeof(LatticePosition) + pieces.bytes_beside);
  cloud.positions.reserve(static_cast<std::size_t>(std::min(point_count, most_in_piece)));

  Joining joining(cloud, options, pieces);
  const bool is_parallel = !pieces.take && thread_count() > 1;
  const std::uint64_t most_points = std::max(k_few_points, point_count / 8);
  for (std::size_t first = 0; first < sources.size();) {
    const std::size_t end = is_parallel ? end_of_lot(sources, first, most_points) : first + 1;
    std::vector<std::optional<ReadPiece>> lot(1);
    if (end - first > 1)
      lot = read_pieces(std::span(sources).subspan(first, end - first), cloud.lattice, options.attributes,
                        progress);
    for (std::optional<ReadPiece>& piece : lot) {
      CloudSource& source = sources[first++];
      if (source.is_skipped) {
        joining.skip(source);
      } else {
        joining.add(source, piece ? &*piece : nullptr, piece ? Progress() : progress.pass(source.work()));
      }
      piece.reset();
    }
  }
  whole.spread = joining.finish();
  whole.point_count = joining.row_count();
  whole.attributes = joining.attributes();
  report(shown, work, work);
  check_selection(inputs, whole);
  warn_of_twins(inputs, cloud);
  return whole;
}

}  // namespace alidade
