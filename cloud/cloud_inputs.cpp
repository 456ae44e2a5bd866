// SPDX-License-Identifier: MIT
#include "cloud/cloud_inputs.h"

#include <fmt/format.h>
#include <fnmatch.h>
#include <algorithm>
#include <array>

#include "base/error.h"
#include "base/parallel.h"
#include "base/words.h"
#include "cloud/catalog.h"
#include "cloud/cloud_reader.h"
#include "cloud/copc/copc_file.h"
#include "cloud/input_view.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t k_start_bytes = 4096;

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The next line without spaces at its ends; `text` keeps what follows.
std::string_view next_line(std::string_view& text) {
  const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
  const std::string_view line = trim(text.substr(0, end));
  text.remove_prefix(end);
  for (const char character : {'\r', '\n'})
    if (text.starts_with(character)) text.remove_prefix(1);
  return line;
}

/// Whether there is neither NUL nor any other control character that text does not contain.
bool is_text(std::string_view start) {
  return std::none_of(start.begin(), start.end(), [](char c) {
    const unsigned char byte = static_cast<unsigned char>(c);
    return (byte < 0x20 && c != '\t' && c != '\n' && c != '\r' && c != '\f') || byte == 0x7f;
  });
}

bool is_ply(std::string_view start) {
  return start.starts_with("ply") && start.size() > 3 && (is_blank(start[3]) || start[3] == '\n');
}

/// A PCD header begins with one of its keywords, after comments.
bool is_pcd(std::string_view start) {
  static constexpr std::array<std::string_view, 10> k_keywords = {
      "VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "POINTS", "VIEWPOINT", "DATA"};
  if (start.starts_with("# .PCD")) return true;
  while (!start.empty()) {
    const std::string_view line = next_line(start);
    if (line.empty() || line.front() == '#') continue;
    const std::string_view word = line.substr(0, line.find_first_of(" \t"));
    return std::find(k_keywords.begin(), k_keywords.end(), word) != k_keywords.end();
  }
  return false;
}

/// How many numbers a line has; -1 if it has anything else.
int count_numbers(std::string_view line) {
  if (line.find_first_not_of("0123456789+-.eE \t") != std::string_view::npos) return -1;
  std::vector<std::string_view> numbers;
  split_words(line, numbers);
  return static_cast<int>(numbers.size());
}

/// A PTX scan begins with columns, rows, four lines of three numbers (the scanner) and four of four (the
/// transform).
bool is_ptx(std::string_view start) {
  if (!is_text(start)) return false;
  for (const int expected : {1, 1, 3, 3, 3, 3, 4, 4, 4, 4}) {
    if (count_numbers(next_line(start)) != expected) return false;
  }
  return true;
}

/// Whether a file begins with text that `is` accepts. Leaves out the byte order mark, as all readers of text
/// do.
template <bool (*is)(std::string_view)>
bool begins(std::span<const std::byte> start) {
  const std::string_view text = text_of(start);
  return is(text.substr(text.starts_with(k_byte_order_mark) ? k_byte_order_mark.size() : 0));
}
bool begins_las(std::span<const std::byte> start) {
  return text_of(start).starts_with("LASF");
}

bool begins_e57(std::span<const std::byte> start) {
  return text_of(start).starts_with("ASTM-E57");
}

/// The first format for which `accepts` returns true; null if it does for none.
template <class Accepts>
const CloudFormat* first_format(CloudFormats formats, const Accepts& accepts) {
  const auto found = std::ranges::find_if(formats, accepts);
  return found == formats.end() ? nullptr : *found;
}

const CloudFormat* format_begun_by(std::span<const std::byte> start, CloudFormats formats) {
  return first_format(formats, [&](const CloudFormat* format) {
    return !start.empty() && format->is_begun_by && format->is_begun_by(start);
  });
}

/// The format of a file; null if it is missing, empty or of an unknown format.
const CloudFormat* format_of(const fs::path& path, CloudFormats formats) {
  try {
    InputFile file(path);
    return format_begun_by(file.view_up_to(0, k_start_bytes), formats);
  } catch (const Error&) {
    return nullptr;
  }
}

constexpr std::array<std::string_view, 10> k_extensions = {"las", "laz", "ply", "pcd", "e57",
                                                           "pts", "ptx", "xyz", "txt", "csv"};

/// The characters behind the last '.', in lower case.
std::string extension_of(const fs::path& path) {
  const std::string extension = file_extension(path);
  return extension.empty() ? extension : extension.substr(1);
}

bool has_cloud_extension(const fs::path& path) {
  return std::ranges::find(k_extensions, extension_of(path)) != k_extensions.end();
}

bool is_pattern(const std::string& text) {
  return text.find_first_of("*?[") != std::string::npos;
}

/// The entries of a folder, sorted. Errors: it cannot be read.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  fs::directory_iterator entry(folder.empty() ? fs::path(".") : folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error))
    entries.push_back(folder / entry->path().filename());
  if (error) throw Error({.file = folder.string(), .problem = "cannot list the folder: " + error.message()});
  std::ranges::sort(entries, {}, &fs::path::native);
  return entries;
}

std::vector<fs::path> files_of_folder(const fs::path& folder) {
  const std::vector<fs::path> entries = entries_of(folder);
  std::vector<fs::path> files;
  for (const fs::path& entry : entries) {
    std::error_code error;
    const bool is_hidden = entry.filename().native().starts_with('.');
    if (!is_hidden && has_cloud_extension(entry) && !fs::is_directory(entry, error)) files.push_back(entry);
  }
  if (files.empty()) {
    throw Error({.file = folder.string(),
                 .problem = "the folder contains no cloud files",
                 .expected = fmt::format("the extension .{}", fmt::join(k_extensions, ", .")),
                 .found = entries.empty() ? "nothing" : fmt::format("{} other files", entries.size())});
  }
  return files;
}

/// Whether the last part of a pattern takes this file, which it matches. A broken link is a file, which
/// cannot be opened later.
bool takes(const std::string& part, const fs::path& file) {
  std::error_code error;
  if (fs::is_directory(file, error)) return false;
  if (part.find('.') == std::string::npos) return has_cloud_extension(file);
  return extension_of(file) != "alidade" || extension_of(part) == "alidade";
}

/// The names that match a pattern; folders only if its last part is the name of one.
std::vector<fs::path> matches_of(const fs::path& pattern) {
  std::vector<fs::path> found = {fs::path()};
  for (auto part = pattern.begin(); part != pattern.end(); ++part) {
    const std::string text = part->string();
    const bool is_last = std::next(part) == pattern.end();
    std::vector<fs::path> next;
    for (const fs::path& folder : found) {
      std::error_code error;
      if (fs::exists(folder / *part, error)) {
        next.push_back(folder / *part);
        continue;
      }
      // It is not an error if only some of the matches have the folder.
      if (!is_pattern(text)) continue;
      if (!folder.empty() && !fs::is_directory(folder, error)) continue;
      for (const fs::path& entry : entries_of(folder)) {
        if (fnmatch(text.c_str(), entry.filename().c_str(), FNM_PERIOD | FNM_NOESCAPE) != 0) continue;
        if (is_last ? takes(text, entry) : fs::is_directory(entry, error)) next.push_back(entry);
      }
    }
    found = std::move(next);
  }
  return found;
}

std::vector<fs::path> files_of_pattern(const fs::path& pattern) {
  std::vector<fs::path> files;
  for (const fs::path& match : matches_of(pattern)) {
    std::error_code error;
    if (fs::is_directory(match, error)) {
      std::ranges::move(files_of_folder(match), std::back_inserter(files));
    } else {
      files.push_back(match);
    }
  }
  if (files.empty()) {
    throw Error({.file = pattern.string(),
                 .problem = "no matching cloud file",
                 .expected = "a file, a folder, or a pattern"});
  }
  std::ranges::sort(files, {}, &fs::path::native);
  return files;
}

/// The files that a name expands to.
std::vector<fs::path> files_of_name(const fs::path& name) {
  if (is_remote_name(name.string())) return {name};
  std::error_code error;
  const fs::file_status status = fs::status(name, error);
  if (fs::is_directory(status)) return files_of_folder(name);
  return !fs::exists(status) && is_pattern(name.string()) ? files_of_pattern(name) : std::vector{name};
}

}  // namespace

const CloudFormat k_copc_format{.name = "COPC", .is_begun_by = is_copc, .open = open_las};
const CloudFormat k_las_format{.name = "LAS", .is_begun_by = begins_las, .open = open_las};
const CloudFormat k_e57_format{.name = "E57", .is_begun_by = begins_e57, .open = open_e57};
const CloudFormat k_ply_format{.name = "PLY", .is_begun_by = begins<is_ply>, .open = open_ply};
const CloudFormat k_pcd_format{.name = "PCD", .is_begun_by = begins<is_pcd>, .open = open_pcd};
const CloudFormat k_ptx_format{.name = "PTX", .is_begun_by = begins<is_ptx>, .open = open_ptx};
const CloudFormat k_text_format{.name = "text", .is_begun_by = begins<is_text>, .open = open_text};

CloudFormats file_formats() {
  static constexpr const CloudFormat* k_formats[] = {&k_copc_format, &k_las_format, &k_e57_format,
                                                     &k_ply_format,  &k_pcd_format, &k_ptx_format,
                                                     &k_text_format};
  return k_formats;
}

std::vector<const CloudFormat*> with_file_formats(std::initializer_list<const CloudFormat*> first) {
  std::vector<const CloudFormat*> formats(first);
  std::ranges::copy(file_formats(), std::back_inserter(formats));
  return formats;
}

InputFile CloudInput::file() const {
  const bool is_file = format == nullptr || format->is_named == nullptr || !format->is_named(name.string());
  if (memory || !is_file) return InputFile(memory.value_or(std::span<const std::byte>()), name.string());
  return InputFile(name);
}

bool CloudInput::is_changed() const {
  return view != nullptr && !view->empty();
}

bool CloudInput::changes_heights() const {
  return view != nullptr && view->has_one_unit &&
         view->change_of(*this, open_stored_cloud(*this, Damage::read_over)->facts()).height_factor != 1.0;
}

std::vector<fs::path> CloudInputs::names() const {
  std::vector<fs::path> names;
  for (const CloudInput& input : inputs) names.push_back(input.name);
  return names;
}

std::string CloudInputs::title() const {
  const std::string first = inputs.empty() ? "the cloud" : public_name(first_name().string());
  return inputs.size() > 1 ? fmt::format("{} and {} more", first, inputs.size() - 1) : first;
}

const CloudInput* CloudInputs::only(const CloudFormat& format) const {
  if (inputs.size() != 1 || !inputs.front().is(format) || inputs.front().is_changed()) return nullptr;
  return &inputs.front();
}

void CloudInputs::check_files() const {
  for (const CloudInput& input : inputs) {
    if (input.format == nullptr) input.file();
  }
}

CloudInputs resolve_clouds(std::span<const fs::path> names, CloudFormats formats) {
  CloudInputs clouds;
  for (const fs::path& name : names) {
    const auto is_named = [&](const CloudFormat* format) {
      return format->is_named && format->is_named(name.string());
    };
    if (const CloudFormat* const format = first_format(formats, is_named)) {
      clouds.inputs.push_back({name, format});
    } else if (is_catalog_name(name.string())) {
      std::ranges::move(read_catalog(name), std::back_inserter(clouds.inputs));
    } else {
      for (fs::path& file : files_of_name(name)) clouds.inputs.push_back({std::move(file)});
    }
  }
  in_parallel(clouds.size(), 1, k_most_files_at_once, [&](std::size_t i) {
    CloudInput& input = clouds.inputs[i];
    if (input.format == nullptr) input.format = format_of(input.name, formats);
  });
  return clouds;
}

CloudInput cloud_in_memory(std::span<const std::byte> bytes, std::string name, CloudFormats formats) {
  const auto start = bytes.first(std::min(bytes.size(), k_start_bytes));
  return {std::move(name), format_begun_by(start, formats), bytes};
}

}  // namespace alidade
