// SPDX-License-Identifier: MIT
#include "cloud/unwanted_file.h"

#include "base/public_name.h"
#include "cloud/catalog.h"
#include "cloud/input_view.h"

namespace alidade {
namespace {

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

std::unique_ptr<CloudReader> open_unwanted(const CloudInput& input, Unwanted unwanted) {
  return std::make_unique<UnwantedFile>(input, unwanted == Unwanted::left_out);
}

}  // namespace alidade
