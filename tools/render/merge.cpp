// SPDX-License-Identifier: MIT
#include "renderer/merge_parts.h"

#include <fmt/format.h>

#include "base/shown_text.h"
#include "image/image_file.h"
#include "tools/command.h"
#include "tools/options.h"

namespace alidade::tools {
namespace {

/// The command line of `alidade merge`.
struct MergeRequest {
  std::vector<std::filesystem::path> parts;
  std::filesystem::path output;
  bool overwrite = false;
  Verbosity verbosity = Verbosity::normal;
};

ExitCode run(const MergeRequest& request) {
  image::check_image_name(request.output);
  check_writable(request.output, request.overwrite, request.parts);
  const renderer::MergedImage merged = renderer::merge_parts(request.parts, request.output);
  image::write_image(merged.film, merged.output, merged.facts, request.overwrite);
  say_note(request.verbosity,
           fmt::format("{} parts, {} camera rays; wrote {}", merged.parts,
                       short_count(static_cast<double>(merged.samples_taken)), request.output.string()));
  if (merged.film.sees_anything()) return ExitCode::done;
  say_warnings(request.verbosity, {fmt::format("{}: the camera sees nothing", request.output.string())});
  return ExitCode::no;
}

}  // namespace

Command add_merge(const Options& program) {
  const Options merge = program.command("merge", "Join the parts of an image that machines have rendered");
  const auto request = std::make_shared<MergeRequest>();
  merge.required().words("parts", "PART...",
                         "all files that 'alidade render --part' wrote for the image, in any order",
                         [request = request.get()](const std::vector<std::string>& words) {
                           request->parts.assign(words.begin(), words.end());
                         });
  merge.required().file("-o,--output", "FILE",
                        "output image: .exr for parts of an EXR, else .png, .jpg or .tif", request->output);
  merge.flag("--overwrite", "replace an existing image", request->overwrite);
  add_verbosity(merge, request->verbosity);
  return {merge, [request](const CommandLine&) { return run(*request); }};
}

}  // namespace alidade::tools
