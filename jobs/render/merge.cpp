// SPDX-License-Identifier: MIT
#include "jobs/render/merge.h"

#include <fmt/format.h>

#include "base/shown_text.h"
#include "image/image_file.h"
#include "jobs/long_run.h"
#include "jobs/outputs.h"

namespace alidade::jobs {

void add_merge_fields(const Fields& fields, MergeRequest& request) {
  fields.required().words("parts", "PART...",
                          "all files that 'alidade render --part' wrote for the image, in any order",
                          [&request](const std::vector<std::string>& words) {
                            request.parts.assign(words.begin(), words.end());
                          });
  fields.required().file("-o,--output", "FILE",
                         "output image: .exr for parts of an EXR, else .png, .jpg or .tif", request.output);
  fields.flag("--overwrite", "replace an existing image", request.overwrite);
}

MergePlan plan(const MergeRequest& request) {
  if (!request.output.empty()) {
    image::check_image_name(request.output);
    check_writable(request.output, request.overwrite, request.parts);
  }
  renderer::check_parts(request.parts, request.output);
  return MergePlan(request, {.reads = request.parts, .writes = {request.output}});
}

renderer::MergedImage run(const MergePlan& plan, Listener& listener) {
  const MergeRequest& request = plan.request();
  renderer::MergedImage merged = renderer::merge_parts(request.parts, request.output);
  const std::string file = request.output.string();
  if (!file.empty()) image::write_image(merged.film, merged.output, merged.facts, request.overwrite);
  listener.note(fmt::format("{} parts, {} camera rays{}", merged.parts,
                            short_count(static_cast<double>(merged.samples_taken)), wrote_text(request)));
  if (!merged.film.sees_anything())
    listener.warn(fmt::format("{}the camera sees nothing", file.empty() ? "" : file + ": "));
  return merged;
}

}  // namespace alidade::jobs
