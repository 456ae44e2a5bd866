// SPDX-License-Identifier: MIT
#include "jobs/outputs.h"

#include <system_error>

#include "base/error.h"
#include "base/output_file.h"
#include "base/words.h"

namespace alidade::jobs {

void check_writable(const std::filesystem::path& output, bool overwrite,
                    std::span<const std::filesystem::path> inputs) {
  std::error_code error;
  for (const std::filesystem::path& input : inputs) {
    // A missing file equals none; reading it reports that it is missing.
    if (std::filesystem::equivalent(output, input == "-" ? "/dev/stdin" : input, error))
      throw file_error(output, "the output is also an input", "another output name");
  }
  if (has_extension(output.stem(), {".copc"}) && has_extension(output, {".las"}))
    throw file_error(output, "COPC is compressed", "the extension .copc.laz");
  if (!overwrite && std::filesystem::is_regular_file(output, error))
    throw file_error(output, "the file exists", "another name, or --overwrite");
  // Opened and given up at once: this finds a missing or read-only folder as the later writing would.
  const OutputFile attempt(output, overwrite);
}

void check_extension(const std::filesystem::path& file, std::initializer_list<std::string_view> extensions) {
  const std::string name = lower_case(file.filename().string());
  std::string expected = "the extension ";
  for (const std::string_view& extension : extensions) {
    if (name.size() > extension.size() && name.ends_with(extension)) return;
    if (&extension != extensions.begin()) expected += &extension + 1 == extensions.end() ? " or " : ", ";
    expected += extension;
  }
  throw file_error(file, "unknown output format", expected);
}

void check_outputs(std::span<const std::filesystem::path> outputs, bool overwrite,
                   std::span<const std::filesystem::path> inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (outputs[i].empty()) continue;
    check_writable(outputs[i], overwrite, inputs);
    for (const std::filesystem::path& earlier : outputs.first(i)) {
      if (earlier.empty() || !same_file(earlier, outputs[i])) continue;
      throw file_error(outputs[i], "two outputs have this name", "different names");
    }
  }
}

bool same_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  const auto canonical = [](const std::filesystem::path& path) {
    std::error_code error;
    return std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error);
  };
  return canonical(a) == canonical(b);
}

std::string kept_name(const std::filesystem::path& given) {
  const std::filesystem::path file = public_name(given.string());
  if (!file.is_absolute()) return file.string();
  // Of "/site/tiles/" the last part is empty.
  return (file.has_filename() ? file : file.parent_path()).filename().string();
}

}  // namespace alidade::jobs
