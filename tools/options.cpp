// SPDX-License-Identifier: MIT
#include "tools/options.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "base/output_file.h"
#include "renderer/scene.h"
#include "tools/cloud/load_cloud.h"

namespace alidade::tools {
namespace {

constexpr std::uint64_t k_largest_side = 65536;
constexpr std::uint64_t k_most_threads = 1024;

/// Any double, as it is written; NaN for what is no number.
double parse_double(const std::string& text) {
  double number = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && stop == end ? number : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

double parse_number(const std::string& text, double least, double most) {
  const double number = parse_double(text);
  if (!std::isfinite(number)) throw CLI::ValidationError("expected a number, found '" + text + "'");
  if (number < least || number > most) {
    throw CLI::ValidationError(fmt::format("expected a number from {} to {}, found '{}'", least, most, text));
  }
  return number;
}

double parse_limit(const std::string& text) {
  const double limit = parse_double(text);
  if (std::isnan(limit)) {
    throw CLI::ValidationError("expected a number, inf or -inf, found '" + text + "'");
  }
  return limit;
}

std::optional<double> parse_length_limit(const std::string& text) {
  const double length = parse_double(text);
  if (!(length >= 0.0)) {
    throw CLI::ValidationError("expected a number, at least 0, or inf, found '" + text + "'");
  }
  return std::isinf(length) ? std::nullopt : std::optional(length);
}

std::uint64_t parse_count(const std::string& text, std::uint64_t least, std::uint64_t most) {
  const auto refuse = [&]() -> CLI::ValidationError {
    return CLI::ValidationError(
        fmt::format("expected a whole number from {} to {}, found '{}'", least, most, text));
  };
  std::uint64_t count = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, count);
  if (error != std::errc() || stop != end) {
    // Written with an exponent: exact as long as it is below 2^53.
    const double number = parse_number(text);
    if (!(number >= 0.0 && number <= 9007199254740992.0) || number != std::floor(number)) throw refuse();
    count = static_cast<std::uint64_t>(number);
  }
  if (count < least || count > most) throw refuse();
  return count;
}

ImageSize parse_image_size(const std::string& text) {
  const std::size_t cross = text.find('x');
  if (cross == std::string::npos) {
    throw CLI::ValidationError("expected WIDTHxHEIGHT in pixels, as 600x400, found '" + text + "'");
  }
  const std::uint64_t width = parse_count(text.substr(0, cross), 1, k_largest_side);
  const std::uint64_t height = parse_count(text.substr(cross + 1), 1, k_largest_side);
  if (width * height > camera::k_max_pixels) {
    throw CLI::ValidationError(
        fmt::format("expected at most {} pixels in all, found {}", camera::k_max_pixels, width * height));
  }
  return {static_cast<int>(width), static_cast<int>(height)};
}

CLI::Option* add_value(CLI::App& command, const std::string& names, const std::string& kind,
                       const std::string& help, std::function<void(const std::string&)> take) {
  const auto take_or_name_option = [names, take](const std::string& text) {
    try {
      take(text);
    } catch (const CLI::ValidationError& error) {
      throw CLI::ValidationError(names, error.what());
    }
  };
  return command.add_option_function<std::string>(names, take_or_name_option, help)
      ->option_text(kind)
      ->take_last();
}

void add_verbosity(CLI::App& command, VerbosityOptions& options) {
  CLI::Option* quiet =
      command.add_flag("-q,--quiet", options.quiet, "say nothing but errors")->option_text(" ");
  command.add_flag("-v,--verbose", options.verbose, "say more about what is done")
      ->option_text(" ")
      ->excludes(quiet);
}

void add_threads(CLI::App& command, std::optional<int>& threads) {
  add_value(command, "--threads", "N",
            "number of threads (default: all of the machine); results do not depend on it",
            [&threads](const std::string& text) {
              threads = static_cast<int>(parse_count(text, 1, k_most_threads));
            });
}

void with_threads(std::optional<int> threads, const std::function<void()>& work) {
  if (!threads) return work();
  // The limit allows more threads than the machine has; the arena then asks for them.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(*threads));
  tbb::task_arena arena(*threads);
  arena.execute(work);
}

void check_writable(const std::filesystem::path& output, bool overwrite,
                    std::span<const std::filesystem::path> inputs) {
  std::error_code error;
  for (const std::filesystem::path& input : inputs) {
    // Files that are not there are no equals; that they are missing is said by whoever reads them.
    if (std::filesystem::equivalent(output, input == "-" ? "/dev/stdin" : input, error)) {
      throw Error({.file = output.string(),
                   .problem = "is read from as well, and would be lost",
                   .expected = "another name for the output"});
    }
  }
  if (!overwrite && std::filesystem::is_regular_file(output, error)) {
    throw Error(
        {.file = output.string(), .problem = "exists already", .expected = "another name, or --overwrite"});
  }
  // Opened and given up at once: this finds a missing or read-only folder as the later writing would.
  const OutputFile attempt(output, overwrite);
}

void check_outputs(std::span<const std::filesystem::path> outputs, bool overwrite,
                   std::span<const std::filesystem::path> inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (outputs[i].empty()) continue;
    check_writable(outputs[i], overwrite, inputs);
    for (const std::filesystem::path& earlier : outputs.first(i)) {
      if (earlier.empty() || !same_file(earlier, outputs[i])) continue;
      throw Error({.file = outputs[i].string(),
                   .problem = "is the name of two outputs",
                   .expected = "another name for one of them"});
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

CLI::Option* add_cloud_files(CLI::App& command, const std::string& name, CloudInputs& clouds,
                             const std::string& help) {
  return command.add_option_function<std::vector<std::string>>(
      name,
      [&clouds](const std::vector<std::string>& words) {
        clouds =
            resolve_clouds(std::vector<std::filesystem::path>(words.begin(), words.end()), cloud_formats());
      },
      help);
}

CLI::Option* add_partial(CLI::App& command, bool& partial) {
  return command
      .add_flag("--partial", partial,
                "read what is whole of damaged files, and say what is lost; without it they are errors")
      ->option_text(" ");
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

}  // namespace alidade::tools
