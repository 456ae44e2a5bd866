// SPDX-License-Identifier: MIT
#include "cloud/input_view.h"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <iterator>
#include <utility>

#include "base/error.h"
#include "base/ray.h"
#include "cloud/rows.h"

namespace alidade {
namespace {

constexpr std::uint64_t k_piece_bytes = std::uint64_t{64} << 20;

/// Moves the rows out of a piece that a reader fills further: its columns stay, without values.
PointCloud take_rows(PointCloud& piece, AttributeSet wanted) {
  PointCloud rows;
  rows.lattice = piece.lattice;
  rows.positions = std::exchange(piece.positions, {});
  for_each_column(rows, piece, [&](Attribute attribute, auto& column, auto& own) {
    if (wanted.contains(attribute)) column = std::move(own);
    own.clear();
  });
  for (ExtraDimension& dimension : piece.extra_dimensions) {
    if (wanted.contains(Attribute::extra_dimensions)) {
      rows.extra_dimensions.push_back(description_of(dimension));
      rows.extra_dimensions.back().values = std::move(dimension.values);
    }
    dimension.values.clear();
  }
  return rows;
}

class ViewReader final : public CloudReader {
 public:
  ViewReader(std::unique_ptr<CloudReader> inner, std::shared_ptr<const InputView> view,
             ReferenceChange change, Damage damage)
      : inner_(std::move(inner)), view_(std::move(view)), change_(std::move(change)) {
    facts_ = inner_->facts();
    facts_.crs = change_.crs;
    facts_.heights_note = change_.heights_note;
    if (change_.height_factor != 1.0 && (change_.move || !facts_.lattice)) {
      only_heights_ = !change_.move;
      change_.move = [factor = std::exchange(change_.height_factor, 1.0),
                      move = std::move(change_.move)](std::span<glm::dvec3> positions) {
        for (glm::dvec3& position : positions) position.z *= factor;
        if (move) move(positions);
      };
    }
    stretch(facts_.file.stated_bounds);
    stretch(facts_.box);
    const std::optional<Bounds>& wanted = view_->selection.box;
    is_outside_ =
        damage == Damage::reject && wanted && facts_.box && facts_.lattice && !meet(*wanted, *facts_.box);
    if (facts_.lattice) {
      facts_.lattice->scale.z *= change_.height_factor;
      facts_.lattice->offset.z *= change_.height_factor;
    }
    if (change_.move) {
      facts_.lattice.reset();
      facts_.point_count.reset();
      facts_.coordinate_types = {};
    }
    if (is_outside_) facts_.point_count = 0;
    left_.resize(std::max<std::size_t>(facts_.sources.size(), 1));
  }

  void rest() override { inner_->rest(); }

  CoordinateSurvey survey(const Progress& progress) override {
    const CoordinateSurvey survey = change_.move ? survey_moved(progress) : inner_->survey(progress);
    facts_.attributes = inner_->facts().attributes;
    return survey;
  }

  FileRead read(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                const Progress& progress) override {
    std::ranges::copy(change_.warnings, std::back_inserter(cloud.warnings));
    if (is_outside_) {
      left_out_ = inner_->facts().point_count.value_or(0);
      return selected({.files = inner_->facts().source_files()});
    }
    const PointSelection& selection = view_->selection;
    AttributeSet needed = wanted;
    if (selection.classes) needed = needed | Attribute::classification;
    if (selection.condition) needed = AttributeSet::all();
    PointCloud piece;
    piece.lattice = change_.move || change_.height_factor != 1.0 ? own_lattice() : cloud.lattice;
    const Lattice own = piece.lattice;
    const CloudPieces own_pieces{.most_bytes = std::min(k_piece_bytes, pieces.most_bytes),
                                 .bytes_beside = pieces.bytes_beside,
                                 .take = [&](PointCloud& part) {
                                   move_rows(part, cloud.lattice);
                                   select_rows(part);
                                   hand_over(part, cloud, wanted, pieces);
                                   part.lattice = own;
                                 }};
    FileRead done = inner_->read(piece, needed, own_pieces, progress);
    own_pieces.take(piece);
    // The facts of the file beside its points.
    piece.lattice = cloud.lattice;
    piece.extra_dimensions.clear();
    for (ScannerPosition& scanner : piece.scanner_positions) {
      scanner.position.z *= change_.height_factor;
      if (!change_.move) continue;
      change_.move(std::span(&scanner.position, 1));
      scanner.axes.reset();  // the other system has another north
    }
    append_cloud(cloud, std::move(piece));
    return selected(std::move(done));
  }

 private:
  std::string name() const { return facts_.file.path.string(); }

  CoordinateSurvey survey_moved(const Progress& progress) {
    CoordinateSurvey survey;
    survey.dropped_count = inner_->facts().lattice ? 0 : survey_own().dropped_count;
    for_each_position_block(progress, [&](std::span<glm::dvec3> positions) {
      if (survey.finite_count == 0 && !positions.empty()) survey.resolution = resolution_at(positions[0]);
      change_.move(positions);
      for (const glm::dvec3& position : positions) {
        if (is_finite(position)) {
          survey.bounds.grow(position);
          ++survey.finite_count;
        } else {
          ++survey.dropped_count;
        }
      }
    });
    dropped_ = survey.dropped_count;
    return survey;
  }

  /// What was read, after the selection.
  FileRead selected(FileRead done) const {
    for (std::size_t i = 0; i < done.files.size(); ++i) {
      CloudFile& file = done.files[i];
      file.left_out_count = left_.size() == 1 ? left_out_ : file.point_count - left_[i];
      file.point_count = left_[i];
      stretch(file.stated_bounds);
    }
    done.files.front().dropped_count += dropped_;
    done.left_out_colors = largest_;
    return done;
  }

  /// The lattice that the positions have before they move.
  Lattice own_lattice() {
    if (const auto& lattice = inner_->facts().lattice) return *lattice;
    const CoordinateSurvey survey = survey_own();
    return with_file(name(), [&] { return fit_lattice(std::span(&survey, 1)); });
  }

  const CoordinateSurvey& survey_own() {
    if (!own_survey_) own_survey_ = inner_->survey({});
    return *own_survey_;
  }

  /// Changes a box of positions to that of the changed positions; empty, as unknown, if they move.
  void stretch(std::optional<Bounds>& box) const {
    if (change_.move) box.reset();
    if (!box || box->empty()) return;
    box->min.z *= change_.height_factor;
    box->max.z *= change_.height_factor;
  }

  template <class Visit>
  void for_each_position_block(const Progress& progress, const Visit& visit) {
    PointCloud piece;
    piece.lattice = own_lattice();
    std::vector<glm::dvec3> positions;
    const CloudPieces pieces{.most_bytes = k_piece_bytes, .take = [&](PointCloud& part) {
                               positions.resize(part.size());
                               for (std::size_t row = 0; row < part.size(); ++row)
                                 positions[row] = part.world(row);
                               part.positions.clear();
                               visit(std::span(positions));
                             }};
    inner_->read(piece, AttributeSet(), pieces, progress);
    pieces.take(piece);
  }

  /// Half of the distance by which the image of a position moves if the position moves by a step; of heights
  /// that are only multiplied a hundredth of it.
  glm::dvec3 resolution_at(const glm::dvec3& position) {
    const glm::dvec3 step = own_lattice().scale;
    std::array<glm::dvec3, 4> images = {position, position + glm::dvec3(step.x, 0, 0),
                                        position + glm::dvec3(0, step.y, 0),
                                        position + glm::dvec3(0, 0, step.z)};
    change_.move(images);
    glm::dvec3 largest(0.0);
    for (int axis = 1; axis < 4; ++axis) {
      const glm::dvec3 moved = glm::abs(images[static_cast<std::size_t>(axis)] - images[0]);
      if (is_finite(moved)) largest = glm::max(largest, moved);
    }
    // Whole feet must not become whole decimetres.
    constexpr double k_share = 0.01;
    return 0.5 * glm::dvec3(largest.x, largest.y, (only_heights_ ? k_share : 1.0) * largest.z);
  }

  /// Moves a part of the file to the cloud's lattice; removes rows without an image.
  void move_rows(PointCloud& part, const Lattice& lattice) const {
    if (change_.height_factor != 1.0) {
      const LatticeShift shift(*facts_.lattice, lattice, name());
      for (LatticePosition& position : part.positions) position = shift(position);
      part.lattice = lattice;
    }
    if (!change_.move) return;
    std::vector<glm::dvec3> positions(part.size());
    for (std::size_t row = 0; row < part.size(); ++row) positions[row] = part.world(row);
    change_.move(positions);
    std::vector<std::uint8_t> marks(part.size());
    for (std::size_t row = 0; row < part.size(); ++row) {
      const auto moved = to_lattice(lattice, positions[row]);
      marks[row] = moved ? 1 : 0;
      if (moved) part.positions[row] = *moved;
    }
    part.lattice = lattice;
    if (std::ranges::find(marks, 0) != marks.end()) keep_rows(part, marks);
  }

  void select_rows(PointCloud& part) {
    const PointSelection& selection = view_->selection;
    // So that rows are counted for their source file.
    part.files = sources_of(part.size());
    const std::size_t before = part.size();
    for (const Color16& color : part.colors)
      largest_.color = std::max<int>({largest_.color, color.x, color.y, color.z});
    for (const std::uint16_t value : part.near_infrared)
      largest_.near_infrared = std::max<int>(largest_.near_infrared, value);
    if (selection.classes && part.size() > 0) keep_classes(part, *selection.classes);
    if (selection.box) crop(part, *selection.box);
    if (selection.polygons) crop(part, polygons());
    if (selection.condition && part.size() > 0) {
      std::vector<std::uint8_t> marks(part.size(), 1);
      with_file(name(), [&] { selection.condition(part, marks); });
      keep_rows(part, marks);
    }
    left_out_ += before - part.size();
    for (std::size_t i = 0; i < part.files.size(); ++i) left_[i] += part.files[i].point_count;
    part.files.clear();
  }

  void keep_classes(PointCloud& part, const std::bitset<256>& classes) const {
    if (part.classifications.empty())
      throw file_error(facts_.file.path, "cannot select by class: the file has no classification",
                       "a classified cloud");
    std::vector<std::uint8_t> marks(part.size());
    for (std::size_t row = 0; row < part.size(); ++row)
      marks[row] = classes.test(part.classifications[row]) ? 1 : 0;
    keep_rows(part, marks);
  }

  std::span<const PlanePolygon> polygons() {
    if (!polygons_) polygons_ = view_->selection.polygons(facts_.crs);
    return *polygons_;
  }

  /// The sources of the next rows, with their numbers of rows.
  std::vector<CloudFile> sources_of(std::size_t count) {
    std::vector<CloudFile> files(left_.size());
    if (files.size() == 1) {
      files[0].point_count = count;
      return files;
    }
    std::uint64_t end = 0;
    const std::uint64_t first = std::exchange(next_row_, next_row_ + count);
    for (std::size_t i = 0; i < files.size(); ++i) {
      const std::uint64_t begin = std::exchange(end, end + facts_.sources[i].point_count);
      const std::uint64_t from = std::max(begin, first), to = std::min(end, next_row_);
      files[i].point_count = to > from ? to - from : 0;
    }
    return files;
  }

  static void hand_over(PointCloud& part, PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces) {
    PointCloud rows = take_rows(part, wanted);
    if (pieces.take && cloud.size() > 0 &&
        room_in_piece(cloud, rows.attributes(), rows.size(), pieces) < rows.size())
      pieces.take(cloud);
    if (rows.size() > 0) append_cloud(cloud, std::move(rows));
  }

  std::unique_ptr<CloudReader> inner_;
  std::shared_ptr<const InputView> view_;
  ReferenceChange change_;
  bool is_outside_ = false;          ///< no point can be in the selection's box
  std::vector<std::uint64_t> left_;  ///< selected points, of each source
  LargestColors largest_;            ///< of all points
  std::uint64_t left_out_ = 0, dropped_ = 0, next_row_ = 0;
  bool only_heights_ = false;  ///< of a file without a lattice are multiplied, and nothing else moves
  std::optional<CoordinateSurvey> own_survey_;
  std::optional<std::vector<PlanePolygon>> polygons_;
};

}  // namespace

ReferenceChange InputView::change_of(const CloudInput& input, const FileFacts& facts) const {
  ReferenceChange change{.crs = facts.crs};
  if (change_reference) change = change_reference(input.name, facts);
  // A change that moves positions also converts their heights.
  if (!has_one_unit || change.move || change.height_factor != 1.0) return change;
  HeightChange heights = heights_in_plane_unit(change.crs, height_unit, input.name);
  if (heights.factor == 1.0) return change;
  // Files whose box in a catalog is outside are not opened.
  if (input.stated && !change_reference)
    throw file_error(input.name, "a catalog of files whose heights are not in the unit of x and y",
                     "the files without the catalog, or files that 'alidade convert --reproject' wrote",
                     crs_name(facts.crs));
  change.crs = std::move(heights.crs);
  change.height_factor = heights.factor;
  change.heights_note = std::move(heights.note);
  return change;
}

CloudInputs in_one_unit(CloudInputs clouds) {
  static const auto view = std::make_shared<const InputView>(InputView{.has_one_unit = true});
  for (CloudInput& input : clouds.inputs) input.view = view;
  return clouds;
}

std::unique_ptr<CloudReader> open_view(std::unique_ptr<CloudReader> reader,
                                       std::shared_ptr<const InputView> view, ReferenceChange change,
                                       Damage damage) {
  return std::make_unique<ViewReader>(std::move(reader), std::move(view), std::move(change), damage);
}

}  // namespace alidade
