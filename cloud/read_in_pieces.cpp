// SPDX-License-Identifier: MIT
#include "cloud/read_in_pieces.h"

#include <fmt/format.h>
#include <algorithm>
#include <glm/common.hpp>
#include <iterator>
#include <optional>
#include <utility>

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

/// A reader of an unwanted file, which stays unopened: it has no points, and its survey is that of the
/// catalog.
class UnwantedFile final : public CloudReader {
 public:
  UnwantedFile(const CloudInput& input, bool is_left_out) : box_(input.stated->box) {
    file_.path = public_name(input.name.string());
    file_.format = input.format->name;
    (is_left_out ? file_.left_out_count : count_) = input.stated->point_count;
  }

  const CloudFile& file() const override { return file_; }
  AttributeSet attributes() const override { return {}; }
  CoordinateSurvey survey(const Progress&) override { return {.bounds = box_, .finite_count = count_}; }
  void read_in_pieces(PointCloud&, AttributeSet, const CloudPieces&, const Progress&) override {}

 private:
  CloudFile file_;
  Bounds box_;
  std::uint64_t count_ = 0;
};

/// Opens the files and marks those outside of the region as skipped.
std::vector<CloudSource> open_sources(const CloudInputs& inputs, const ReadOptions& options) {
  inputs.check_files();
  const Damage damage = options.partial ? Damage::read_over : Damage::reject;
  std::vector<CloudSource> sources(inputs.size());
  // The facts of the cloud are those of the first file, its lattice is that of the first file with points.
  const auto with_points = std::ranges::find_if(
      inputs.inputs, [](const CloudInput& input) { return !input.stated || input.stated->point_count > 0; });
  const auto first_with_points = static_cast<std::size_t>(with_points - inputs.inputs.begin());
  in_parallel(inputs.size(), 1, k_most_files_at_once, [&](std::size_t i) {
    CloudSource& source = sources[i];
    const Unwanted unwanted = what_is_unwanted(inputs.inputs[i], options);
    if (unwanted != Unwanted::no && i != 0 && i != first_with_points) {
      source.reader = std::make_unique<UnwantedFile>(inputs.inputs[i], unwanted == Unwanted::left_out);
      source.is_skipped = unwanted == Unwanted::skipped;
      source.is_open = false;
      return;
    }
    InputFile file = inputs.inputs[i].file();
    source.bytes = file.size();
    source.reader = open_cloud(inputs.inputs[i], std::move(file), damage);
    source.work = std::max(source.bytes, source.reader->work());
    source.has_lattice = source.reader->lattice().has_value();
    source.facts = source.reader->facts();
    source.is_skipped = options.region && !options.partial && source.has_lattice && source.facts.box &&
                        !meet(*source.facts.box, *options.region);
    source.reader->rest();
  });
  return sources;
}

/// Joins sources one by one, in their order.
class Joining {
 public:
  Joining(PointCloud& cloud, const ReadOptions& options, const CloudPieces& pieces)
      : cloud_(cloud), options_(options), given_pieces_(pieces) {
    if (!pieces.take) return;
    pieces_ = {pieces.most_bytes, pieces.bytes_beside, [this](PointCloud&) { hand_over(); }, pieces.recall};
  }

  /// Takes the next file: its points from `piece` if they have been read into one, else from the file.
  void add(CloudSource& source, PointCloud* piece, const Progress& progress) {
    const std::size_t first_record = cloud_.records.size();
    const std::uint64_t first_row = row_count();
    join_facts(source);
    const AttributeSet attributes = source.reader->attributes();
    const bool is_colored =
        is_las(source.reader->file()) && (attributes & options_.attributes).contains(Attribute::color);
    if (is_colored) colored_.push_back({source.path().string(), first_row});
    if (piece == nullptr) {
      source.reader->read_in_pieces(cloud_, options_.attributes, pieces_, progress);
    } else {
      append_cloud(cloud_, std::move(*piece));
    }
    records_.join(first_record);
    if (is_colored) {
      // The depth of a file is that of all its points, selected or not.
      const LargestColors others = source.reader->left_out_colors();
      ColoredRows& rows = colored_.back();
      rows.end = row_count();
      rows.largest_color = std::max(rows.largest_color, others.color);
      rows.largest_near_infrared = std::max(rows.largest_near_infrared, others.near_infrared);
    }
    const CloudFile& file = source.reader->file();
    given_.push_back({file.path.string(), file.point_count, attributes});
    if (row_count() > first_row)
      attributes_ = attributes_ | cloud_.attributes() | (attributes & options_.attributes);
    warn_of_rounding(source, cloud_);
    std::vector<CloudFile> files = source.reader->sources();
    warn_of_losses(*source.reader, files, cloud_);
    for (CloudFile& own : files) own.is_rounded = own.is_rounded || source.is_rounded;
    std::ranges::move(files, std::back_inserter(cloud_.files));
    source.reader.reset();
  }

  void skip(CloudSource& source) {
    join_facts(source);
    CloudFile file = source.reader->file();
    file.skipped_count = source.point_count();
    file.point_count = 0;
    cloud_.files.push_back(std::move(file));
    source.reader.reset();
  }

  /// Adds the warnings about all files; returns how their colours are to be spread.
  ColorSpread finish() {
    measure();
    ColorSpread spread = choose_spread(std::move(colored_), options_.color_depth, cloud_.warnings);
    warn_of_gaps(given_, attributes_, cloud_.warnings);
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

  /// Takes over the facts of the first file. The kind of times is that of the first file that has times and
  /// states their kind; a warning names a file of another kind.
  void join_facts(const CloudSource& source) {
    if (cloud_.files.empty()) {
      cloud_.gps_time_is_standard = source.facts.gps_time_is_standard.value_or(false);
      cloud_.project_id = source.facts.project_id;
      cloud_.file_source_id = source.facts.file_source_id;
    }
    const std::optional<bool> is_standard = source.facts.gps_time_is_standard;
    const bool has_times =
        source.point_count() > 0 && source.reader->attributes().contains(Attribute::gps_time);
    if (!is_standard || !has_times) return;
    if (timed_file_.empty()) {
      timed_file_ = source.path().string();
      cloud_.gps_time_is_standard = *is_standard;
    } else if (cloud_.gps_time_is_standard != *is_standard &&
               options_.attributes.contains(Attribute::gps_time)) {
      cloud_.warnings.push_back(fmt::format(
          "{}: the GPS time system (week or standard) differs from that of {}; times are not comparable",
          source.path().string(), timed_file_));
    }
  }

  PointCloud& cloud_;
  const ReadOptions& options_;
  const CloudPieces& given_pieces_;
  CloudPieces pieces_{};
  std::uint64_t taken_ = 0;  ///< points handed over
  Bounds bounds_;            ///< of the points handed over
  AttributeSet attributes_;
  std::string timed_file_;  ///< the first that has GPS times
  JoinedRecords records_{cloud_.records};
  std::vector<GivenRows> given_;
  std::vector<ColoredRows> colored_;
};

/// The end of the lot of files from `first` on, at least one, that are read into pieces at once.
std::size_t end_of_lot(const std::vector<CloudSource>& sources, std::size_t first,
                       std::uint64_t most_points) {
  std::uint64_t points = sources[first].is_skipped ? 0 : sources[first].point_count();
  std::size_t end = first + 1;
  while (end < sources.size() && end - first < k_most_files_at_once) {
    points += sources[end].is_skipped ? 0 : sources[end].point_count();
    if (points > most_points) break;
    ++end;
  }
  return end;
}

/// Reads a lot of files at once, each into a cloud of its own; empty for files that are skipped.
std::vector<std::optional<PointCloud>> read_pieces(std::vector<CloudSource>& sources, std::size_t first,
                                                   std::size_t end, const Lattice& lattice,
                                                   AttributeSet wanted, JoinedProgress& progress) {
  std::vector<std::optional<PointCloud>> pieces(end - first);
  in_parallel(pieces.size(), 1, [&](std::size_t i) {
    CloudSource& source = sources[first + i];
    if (source.is_skipped) return;
    PointCloud& piece = pieces[i].emplace();
    piece.lattice = lattice;
    piece.positions.reserve(static_cast<std::size_t>(std::min(source.point_count(), source.bytes)));
    source.reader->read(piece, wanted, progress.pass(source.work));
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
    work += source.is_skipped ? 0 : source.has_lattice ? source.work : 2 * source.work;
    bytes += source.is_skipped ? 0 : source.work;
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
    if (sources[i].has_lattice) return;
    sources[i].survey = sources[i].reader->survey(progress.pass(sources[i].work));
    sources[i].reader->rest();
  });

  PiecewiseCloud whole;
  PointCloud& cloud = whole.rest;
  cloud.lattice = common_lattice(sources);
  cloud.crs = common_crs(sources);
  std::uint64_t point_count = 0;
  for (const CloudSource& source : sources) {
    // Packed points rarely take less than a byte each; a larger number is accepted once they are unpacked.
    point_count += source.is_skipped ? 0 : std::min(source.point_count(), source.bytes);
  }
  const std::uint64_t most_in_piece = pieces.most_bytes / (sizeof(LatticePosition) + pieces.bytes_beside);
  cloud.positions.reserve(static_cast<std::size_t>(std::min(point_count, most_in_piece)));
  warn_of_missing_crs(sources, cloud);
  warn_of_other_crs(sources, cloud);
  warn_of_heights(sources, cloud);
  warn_of_lattices(sources, cloud);

  Joining joining(cloud, options, pieces);
  const bool is_parallel = !pieces.take && thread_count() > 1;
  const std::uint64_t most_points = std::max(k_few_points, point_count / 8);
  for (std::size_t first = 0; first < sources.size();) {
    const std::size_t end = is_parallel ? end_of_lot(sources, first, most_points) : first + 1;
    std::vector<std::optional<PointCloud>> lot(1);
    if (end - first > 1) lot = read_pieces(sources, first, end, cloud.lattice, options.attributes, progress);
    for (std::size_t i = first; i < end; ++i) {
      std::optional<PointCloud>& piece = lot[i - first];
      if (sources[i].is_skipped) {
        joining.skip(sources[i]);
      } else {
        joining.add(sources[i], piece ? &*piece : nullptr,
                    piece ? Progress() : progress.pass(sources[i].work));
      }
      piece.reset();
    }
    first = end;
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
