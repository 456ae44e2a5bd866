// SPDX-License-Identifier: MIT
#include "jobs/outputs.h"

#include <set>
#include <system_error>

#include "base/error.h"
#include "base/output_file.h"
#include "base/words.h"

namespace alidade::jobs {
namespace {

/// A name that is the same for every name of a file, which need not exist.
std::filesystem::path canonical_name(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error);
}

}  // namespace

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

void check_extension(const std::filesystem::path& file, const std::vector<std::string>& extensions) {
  const std::string name = lower_case(file.filename().string());
  std::string expected = "the extension ";
  for (const std::string& extension : extensions) {
    if (name.size() > extension.size() && name.ends_with(extension)) return;
    if (&extension != &extensions.front()) expected += &extension == &extensions.back() ? " or " : ", ";
    expected += extension;
  }
  throw file_error(file, "unknown output format", expected);
}

void check_outputs(std::span<const std::filesystem::path> outputs, bool overwrite,
                   std::span<const std::filesystem::path> inputs,
                   std::span<const std::filesystem::path> others) {
  std::set<std::filesystem::path> taken;
  for (const std::filesystem::path& other : others)
    if (!other.empty()) taken.insert(canonical_name(other));
  for (const std::filesystem::path& output : outputs) {
    if (output.empty()) continue;
    check_writable(output, overwrite, inputs);
    if (!taken.insert(canonical_name(output)).second)
      throw file_error(output, "two outputs have this name", "different names");
  }
}

bool same_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  return canonical_name(a) == canonical_name(b);
}

std::string kept_name(const std::filesystem::path& given) {
  const std::filesystem::path file = public_name(given.string());
  if (!file.is_absolute()) return file.string();
  // Of "/site/tiles/" the last part is empty.
  return (file.has_filename() ? file : file.parent_path()).filename().string();
}

}  // namespace alidade::jobs
