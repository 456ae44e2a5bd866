// SPDX-License-Identifier: MIT
#include "jobs/fields.h"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "base/error.h"
#include "camera/camera.h"

namespace alidade::jobs {
namespace {

constexpr std::uint64_t k_largest_side = 65536;

/// Any double; NaN for text that is not a number.
double parse_double(const std::string& text) {
  double number = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && stop == end ? number : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

double parse_number(const std::string& text, double least, double most) {
  const double number = parse_double(text);
  if (!std::isfinite(number)) throw UsageError("invalid value; expected a number, found '" + text + "'");
  if (number < least || number > most)
    throw UsageError(
        fmt::format("invalid value; expected a number from {} to {}, found '{}'", least, most, text));
  return number;
}

double parse_limit(const std::string& text) {
  const double limit = parse_double(text);
  if (std::isnan(limit))
    throw UsageError("invalid value; expected a number, inf or -inf, found '" + text + "'");
  return limit;
}

std::optional<double> parse_length_limit(const std::string& text) {
  const double length = parse_double(text);
  if (!(length >= 0.0))
    throw UsageError("invalid value; expected a number, at least 0, or inf, found '" + text + "'");
  return std::isinf(length) ? std::nullopt : std::optional(length);
}

double parse_distance_limit(const std::string& text) {
  return parse_length_limit(text).value_or(std::numeric_limits<double>::infinity());
}

std::uint64_t parse_count(const std::string& text, std::uint64_t least, std::uint64_t most) {
  const auto reject = [&]() -> UsageError {
    return UsageError(
        fmt::format("invalid value; expected an integer from {} to {}, found '{}'", least, most, text));
  };
  std::uint64_t count = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, count);
  if (error != std::errc() || stop != end) {
    // Written with an exponent: exact as long as it is below 2^53.
    const double number = parse_number(text);
    if (!(number >= 0.0 && number <= 9007199254740992.0) || number != std::floor(number)) throw reject();
    count = static_cast<std::uint64_t>(number);
  }
  if (count < least || count > most) throw reject();
  return count;
}

ImageSize parse_image_size(const std::string& text) {
  const std::size_t cross = text.find('x');
  if (cross == std::string::npos)
    throw UsageError("invalid value; expected WIDTHxHEIGHT in pixels, such as 600x400, found '" + text + "'");
  const std::uint64_t width = parse_count(text.substr(0, cross), 1, k_largest_side);
  const std::uint64_t height = parse_count(text.substr(cross + 1), 1, k_largest_side);
  if (width * height > camera::k_max_pixels) {
    throw UsageError(fmt::format("invalid value; expected at most {} pixels in total, found {}",
                                 camera::k_max_pixels, width * height));
  }
  return {static_cast<int>(width), static_cast<int>(height)};
}

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> words;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    if (end == text.size()) return words;
    begin = end + 1;
  }
}

std::vector<std::string> split_list(const std::string& text, std::size_t count, const std::string& expected) {
  std::vector<std::string> words = split_list(text);
  if (words.size() != count)
    throw UsageError(fmt::format("invalid value; expected {}, found '{}'", expected, text));
  return words;
}

std::bitset<256> parse_classes(const std::string& text) {
  std::bitset<256> classes;
  for (const std::string& word : split_list(text))
    classes.set(static_cast<std::size_t>(parse_count(word, 0, 255)));
  return classes;
}

std::size_t parse_size(const std::string& text) {
  constexpr std::uint64_t k_most = std::uint64_t{1} << 50;
  const std::string_view units = "kMGT";
  const std::size_t unit = text.empty() ? units.npos : units.find(text.back());
  if (unit == units.npos) return static_cast<std::size_t>(parse_count(text, 1, k_most));
  const double factor = std::pow(1024.0, static_cast<double>(unit + 1));
  const double number =
      parse_number(text.substr(0, text.size() - 1), 0, static_cast<double>(k_most) / factor);
  return static_cast<std::size_t>(std::max(number * factor, 1.0));
}

std::size_t parse_memory(const std::string& text) {
  constexpr std::size_t k_least = std::size_t{1} << 20;
  const std::size_t memory = parse_size(text);
  if (memory < k_least) throw UsageError("invalid value; expected at least 1M, found '" + text + "'");
  return memory;
}

Moment parse_moment(std::string text) {
  constexpr std::size_t k_date_length = 10;
  if (text.size() > k_date_length && text[k_date_length] == ' ') text[k_date_length] = 'T';
  try {
    return parse_date_time(text);
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
}

Fields Fields::group(const std::string& heading) const {
  Fields fields = *this;
  fields.heading_ = heading;
  return fields;
}

Fields Fields::required() const {
  Fields fields = *this;
  fields.is_required_ = true;
  return fields;
}

Fields Fields::needs(const Field& other) const {
  Fields fields = *this;
  fields.needed_.push_back(other.index_);
  return fields;
}

Fields Fields::excludes(const Field& other) const {
  Fields fields = *this;
  fields.excluded_.push_back(other.index_);
  return fields;
}

Field Fields::declare(FieldEntry entry) const {
  entry.heading = heading_;
  entry.is_required = is_required_;
  entry.needed = needed_;
  entry.excluded = excluded_;
  return {sink_, sink_->declare(std::move(entry))};
}

Field Fields::value(const std::string& names, const std::string& kind, const std::string& help,
                    Take take) const {
  return declare(
      {.names = names, .kind = kind, .help = help, .read = [take = std::move(take)](const auto& texts) {
         take(texts.back());
       }});
}

Field Fields::values(const std::string& names, const std::string& kind, const std::string& help,
                     Take take) const {
  return declare(
      {.names = names,
       .kind = kind,
       .help = help,
       .form = FieldForm::repeated,
       .read = [take = std::move(take)](const auto& texts) { std::ranges::for_each(texts, take); }});
}

Field Fields::words(const std::string& names, const std::string& kind, const std::string& help,
                    std::function<void(const std::vector<std::string>&)> take, std::size_t least) const {
  return declare({.names = names,
                  .kind = kind,
                  .help = help,
                  .form = FieldForm::words,
                  .least = least,
                  .read = std::move(take)});
}

Field Fields::text(const std::string& names, const std::string& kind, const std::string& help,
                   std::vector<std::string>& target) const {
  return declare({.names = names,
                  .kind = kind,
                  .help = help,
                  .form = FieldForm::repeated,
                  .read = [&target](const auto& texts) { target = texts; }});
}

Field Fields::file(const std::string& names, const std::string& kind, const std::string& help,
                   std::filesystem::path& target) const {
  return declare({.names = names,
                  .kind = kind,
                  .help = help,
                  .form = FieldForm::text,
                  .read = [&target, is_required = is_required_](const auto& texts) {
                    if (is_required && texts.back().empty())
                      throw UsageError("invalid value; expected a file name, found ''");
                    target = texts.back();
                  }});
}

Field Fields::flag(const std::string& names, const std::string& help, bool& target) const {
  return flag(names, help, [&target] { target = true; });
}

Field Fields::flag(const std::string& names, const std::string& help, std::function<void()> take) const {
  return declare(
      {.names = names, .help = help, .form = FieldForm::flag, .read = [take = std::move(take)](const auto&) {
         take();
       }});
}

}  // namespace alidade::jobs
