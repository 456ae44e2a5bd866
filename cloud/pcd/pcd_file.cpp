// SPDX-License-Identifier: MIT
#include "cloud/pcd/pcd_file.h"

#include <array>
#include <cmath>
#include <cstring>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <optional>
#include <string_view>

#include "base/ray.h"
#include "base/text_scanner.h"
#include "cloud/table_reader.h"

namespace alidade {

bool decode_lzf(std::span<const std::byte> input, std::span<std::byte> output) {
  const std::byte* from = input.data();
  const std::byte* const from_end = from + input.size();
  std::byte* to = output.data();
  std::byte* const to_end = to + output.size();
  const auto next = [&] { return std::to_integer<std::size_t>(*from++); };

  while (from != from_end) {
    const std::size_t control = next();
    if (control < 32) {
      const std::size_t length = control + 1;
      if (length > static_cast<std::size_t>(from_end - from) ||
          length > static_cast<std::size_t>(to_end - to))
        return false;
      std::memcpy(to, from, length);
      from += length;
      to += length;
      continue;
    }
    std::size_t length = control >> 5;
    if (from_end - from < (length == 7 ? 2 : 1)) return false;
    if (length == 7) length += next();
    length += 2;
    const std::size_t distance = ((control & 31) << 8 | next()) + 1;
    if (distance > static_cast<std::size_t>(to - output.data()) ||
        length > static_cast<std::size_t>(to_end - to))
      return false;
    // The ranges may overlap: a short pattern repeats because the bytes just written are copied again.
    for (const std::byte* source = to - distance; length > 0; --length) *to++ = *source++;
  }
  return to == to_end;
}

namespace {

using Words = std::vector<std::string_view>;

/// Most bytes per point that are accepted; keeps products of sizes within 64 bits.
constexpr std::uint64_t k_largest_point = 1 << 20;

std::optional<ScalarType> scalar_type(char kind, std::uint64_t size) {
  constexpr std::string_view k_kinds = " UIUIUIUIFF";  // in the order of the types
  for (std::size_t i = 1; i < k_kinds.size(); ++i) {
    const auto type = static_cast<ScalarType>(i);
    if (k_kinds[i] == kind && static_cast<std::uint64_t>(scalar_size(type)) == size) return type;
  }
  return std::nullopt;
}

/// The values of the header's lines, before they are combined.
struct Lines {
  std::vector<std::string> fields;
  std::vector<std::uint64_t> sizes, counts;
  std::vector<char> types;
  std::optional<std::uint64_t> width, height, points;
};

std::uint64_t require_count(const TextScanner& scanner, std::string_view word) {
  if (const auto count = parse_count(word)) return *count;
  scanner.fail("invalid value", "an integer, at least 0", quote(word));
}

/// The values after the keyword, one per field.
std::vector<std::uint64_t> require_counts(const TextScanner& scanner, const Words& words,
                                          const Lines& lines) {
  if (words.size() - 1 != lines.fields.size())
    scanner.fail("wrong number of values", std::to_string(lines.fields.size()) + ", one per field",
                 std::to_string(words.size() - 1));
  std::vector<std::uint64_t> counts;
  for (std::size_t i = 1; i < words.size(); ++i) counts.push_back(require_count(scanner, words[i]));
  return counts;
}

PcdFormat require_pcd_format(const TextScanner& scanner, const Words& words) {
  if (words.size() == 2 && words[1] == "ascii") return PcdFormat::ascii;
  if (words.size() == 2 && words[1] == "binary") return PcdFormat::binary;
  if (words.size() == 2 && words[1] == "binary_compressed") return PcdFormat::binary_compressed;
  scanner.fail("unsupported data type", "ascii, binary or binary_compressed",
               words.size() > 1 ? quote(words[1]) : "nothing");
}

/// Seven numbers: the position, then the quaternion w, x, y, z; empty if these are invalid. Errors: words
/// that are not numbers.
std::optional<PcdViewpoint> viewpoint_from(const TextScanner& scanner, const Words& words) {
  std::array<double, 7> numbers{};
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::optional<double> number = parse_number(words[i]);
    if (!number) scanner.fail("invalid viewpoint", "numbers", quote(words[i]));
    if (i <= numbers.size()) numbers[i - 1] = *number;
  }
  const auto& [x, y, z, qw, qx, qy, qz] = numbers;
  const double length = std::hypot(std::hypot(qw, qx), std::hypot(qy, qz));
  if (words.size() != 1 + numbers.size() || !is_finite(glm::dvec3(x, y, z)) ||
      !(length > 1e-100 && length < 1e100))
    return std::nullopt;
  const glm::dquat quaternion(qw / length, qx / length, qy / length, qz / length);
  return PcdViewpoint{.position = {x, y, z}, .rotation = glm::mat3_cast(quaternion)};
}

void take_line(const TextScanner& scanner, const Words& words, Lines& lines, PcdHeader& header) {
  const std::string_view keyword = words[0];
  const auto single = [&] {
    if (words.size() != 2) scanner.fail("invalid line", "one value after " + std::string(keyword));
    return require_count(scanner, words[1]);
  };
  if (keyword == "VERSION") {
    header.version = words.size() > 1 ? words[1] : "";
  } else if (keyword == "FIELDS" || keyword == "COLUMNS") {
    require_few_columns(scanner, words.size() - 1);
    lines.fields.assign(words.begin() + 1, words.end());
  } else if (keyword == "SIZE") {
    lines.sizes = require_counts(scanner, words, lines);
  } else if (keyword == "COUNT") {
    lines.counts = require_counts(scanner, words, lines);
  } else if (keyword == "TYPE") {
    if (words.size() - 1 != lines.fields.size())
      scanner.fail("wrong number of types", std::to_string(lines.fields.size()) + ", one per field",
                   std::to_string(words.size() - 1));
    lines.types.clear();
    for (std::size_t i = 1; i < words.size(); ++i)
      lines.types.push_back(words[i].size() == 1 ? words[i][0] : '?');
  } else if (keyword == "WIDTH") {
    lines.width = single();
  } else if (keyword == "HEIGHT") {
    lines.height = single();
  } else if (keyword == "POINTS") {
    lines.points = single();
  } else if (keyword == "VIEWPOINT") {
    header.viewpoint = viewpoint_from(scanner, words);
    header.has_invalid_viewpoint = !header.viewpoint;
  } else {
    scanner.fail("unknown header line",
                 "VERSION, FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, VIEWPOINT, POINTS or DATA",
                 quote(keyword));
  }
}

void take_fields(const TextScanner& scanner, const Lines& lines, PcdHeader& header) {
  if (lines.fields.empty()) scanner.fail("missing FIELDS", "FIELDS before DATA");
  if (lines.sizes.size() != lines.fields.size()) scanner.fail("missing SIZE", "SIZE after FIELDS");
  if (lines.types.size() != lines.fields.size()) scanner.fail("missing TYPE", "TYPE after FIELDS");
  std::uint64_t point_size = 0;
  for (std::size_t i = 0; i < lines.fields.size(); ++i) {
    const auto type = scalar_type(lines.types[i], lines.sizes[i]);
    if (!type)
      scanner.fail("unsupported type of the field " + quote(lines.fields[i]),
                   "I or U of 1, 2, 4, 8 bytes, F of 4 or 8",
                   quote(std::string_view(&lines.types[i], 1)) + " of " + std::to_string(lines.sizes[i]));
    const std::uint64_t count = i < lines.counts.size() ? lines.counts[i] : 1;
    if (count > k_largest_point) scanner.fail("field too long", "at most 1 MiB", std::to_string(count));
    header.fields.push_back({lines.fields[i], *type, count});
    point_size += header.fields.back().size();
    if (point_size > k_largest_point) scanner.fail("points too long", "at most 1 MiB each");
  }
}

void take_point_count(const TextScanner& scanner, const Lines& lines, PcdHeader& header) {
  if (!lines.width && !lines.points) scanner.fail("missing number of points", "WIDTH or POINTS");
  const std::uint64_t width = lines.width ? *lines.width : *lines.points;
  const std::uint64_t height = lines.width && lines.height ? *lines.height : 1;
  if (height != 0 && width > std::numeric_limits<std::uint64_t>::max() / height)
    scanner.fail("WIDTH times HEIGHT exceeds 64 bits");
  header.point_count = width * height;
  header.width = width;
  header.height = height;
  if (lines.points && *lines.points != header.point_count)
    scanner.fail("POINTS is not WIDTH times HEIGHT", std::to_string(header.point_count),
                 std::to_string(*lines.points));
}

}  // namespace

std::uint64_t PcdHeader::point_size() const {
  std::uint64_t size = 0;
  for (const PcdField& field : fields) size += field.size();
  return size;
}

std::uint64_t PcdHeader::value_count() const {
  std::uint64_t count = 0;
  for (const PcdField& field : fields) count += field.count;
  return count;
}

PcdHeader read_pcd_header(InputFile& input, Damage damage) {
  TextScanner scanner(input);
  PcdHeader header;
  Lines lines;
  Words words;
  while (true) {
    const auto line = scanner.next_line();
    if (!line) scanner.fail("truncated header", "DATA", "the end of the file");
    split_words(*line, words);
    if (words.empty() || words[0].starts_with('#')) continue;
    if (words[0] == "DATA") break;
    take_line(scanner, words, lines, header);
  }
  header.format = require_pcd_format(scanner, words);
  take_fields(scanner, lines, header);
  take_point_count(scanner, lines, header);
  header.data_offset = scanner.offset();
  header.line_count = scanner.line_number();
  // The sizes of compressed points precede the data.
  const bool is_text = header.format == PcdFormat::ascii;
  if (header.format != PcdFormat::binary_compressed)
    check_room(input,
               {.offset = header.data_offset,
                .count = header.point_count,
                .smallest_row = is_text ? header.value_count() : header.point_size(),
                .is_text = is_text},
               damage);
  return header;
}

}  // namespace alidade
