// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "base/error.h"
#include "base/text_scanner.h"
#include "cloud/cloud_inputs.h"
#include "octree/index_file/index_header.h"

namespace alidade {
namespace {

constexpr std::size_t k_looked_at = 4096;
constexpr const char* k_supported = "LAS, LAZ, PLY, PCD, E57, PTX, PTS, CSV, XYZ or an index file";

/// The next line without spaces at its ends; `text` keeps what follows.
std::string_view next_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = trim(text.substr(0, end));
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

/// Neither NUL nor any other control character that text does not have.
bool is_text(std::string_view start) {
  return std::none_of(start.begin(), start.end(), [](char c) {
    const unsigned char byte = static_cast<unsigned char>(c);
    return (byte < 0x20 && c != '\t' && c != '\n' && c != '\r' && c != '\f') || byte == 0x7f;
  });
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

/// How many numbers a line holds; -1 if it holds anything else.
int count_numbers(std::string_view line) {
  if (line.find_first_not_of("0123456789+-.eE \t") != std::string_view::npos) return -1;
  int count = 0;
  for (std::size_t place = 0; (place = line.find_first_not_of(" \t", place)) != std::string_view::npos;
       ++count) {
    place = std::min(line.find_first_of(" \t", place), line.size());
  }
  return count;
}

/// A PTX scan begins with columns, rows, four lines of three numbers (the scanner) and four of four (the
/// transform).
bool is_ptx(std::string_view start) {
  for (const int expected : {1, 1, 3, 3, 3, 3, 4, 4, 4, 4}) {
    if (count_numbers(next_line(start)) != expected) return false;
  }
  return true;
}

}  // namespace

std::unique_ptr<CloudReader> open_cloud(InputFile file, Damage damage) {
  if (const CloudDatabase* const database = find_database_named(file.name()))
    return database->open(file.name());
  const std::span<const std::byte> bytes = file.view_up_to(0, k_looked_at);
  // A copy, because the file is handed on.
  const std::string copy(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::string_view start = copy;
  if (start.empty()) throw Error({.file = file.name(), .problem = "is empty", .expected = k_supported});
  if (start.starts_with("LASF")) return open_las(std::move(file), damage);
  if (is_index_file(std::as_bytes(std::span(start)))) return open_index_cloud(std::move(file));
  if (start.starts_with("ASTM-E57")) return open_e57(std::move(file));
  if (const CloudDatabase* const database = find_database_begun_by(copy)) return database->open(file.name());
  // Every reader of text skips a byte order mark.
  if (start.starts_with(k_byte_order_mark)) start.remove_prefix(k_byte_order_mark.size());
  if (start.starts_with("ply") && start.size() > 3 && (is_blank(start[3]) || start[3] == '\n')) {
    return open_ply(std::move(file), damage);
  }
  if (is_pcd(start)) return open_pcd(std::move(file), damage);
  if (!is_text(start)) {
    throw Error({.file = file.name(),
                 .problem = "is of no known format",
                 .expected = k_supported,
                 .found = "binary data"});
  }
  if (is_ptx(start)) return open_ptx(std::move(file), damage);
  return open_text(std::move(file), damage);
}

}  // namespace alidade
