// SPDX-License-Identifier: MIT
#include "cloud/same_definition.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>
#include <vector>

#include "cloud/crs_name.h"
#include "cloud/wkt_node.h"

namespace alidade {
namespace {

/// Numbers by the word that they stand in, and for parameters its name: those of all such words in a row.
using Definition = std::map<std::string, std::vector<double>>;

/// The numbers behind the name that `text` begins with: "Bessel",6377397.155,299.15],...
std::vector<double> numbers_of(std::string_view text) {
  std::vector<double> numbers;
  std::size_t place = text.find('"', 1);
  while (place < text.size() && ++place < text.size() && text[place] == ',') {
    place = std::min(text.find_first_not_of(" \t\r\n", place + 1), text.size());
    double number = 0;
    const char* const begin = text.data() + place;
    const auto [end, error] = std::from_chars(begin, text.data() + text.size(), number);
    if (error != std::errc()) break;
    numbers.push_back(number);
    // The loop goes on at the comma behind the number.
    place += static_cast<std::size_t>(end - begin) - 1;
  }
  return numbers;
}

Definition definition_of(std::string_view wkt) {
  Definition definition;
  const std::string_view node = wkt_node(wkt, {"PROJCS["});
  for (const std::string_view word : {"SPHEROID[\"", "PRIMEM[\"", "UNIT[\"", "PARAMETER[\""}) {
    for (std::size_t place = node.find(word); place != std::string_view::npos;
         place = node.find(word, place + 1)) {
      const std::string_view text = node.substr(place + word.size() - 1);
      const std::string_view name = text.substr(1, std::min(text.find('"', 1), text.size()) - 1);
      const std::string key =
          std::string(word) + (word.starts_with("PARAMETER") ? letters_and_digits(name) : "");
      std::ranges::copy(numbers_of(text), std::back_inserter(definition[key]));
    }
  }
  return definition;
}

bool nearly_equal(double a, double b) {
  constexpr double k_last_digits = 1e-9;
  return std::fabs(a - b) <= k_last_digits * std::max(std::fabs(a), std::fabs(b));
}

}  // namespace

bool same_definition(const std::string& wkt_a, const std::string& wkt_b) {
  const Definition a = definition_of(wkt_a), b = definition_of(wkt_b);
  const auto parameter = a.lower_bound("PARAMETER");
  const bool has_parameters = parameter != a.end() && parameter->first.starts_with("PARAMETER");
  return has_parameters && std::ranges::equal(a, b, [](const auto& one, const auto& other) {
           return one.first == other.first && std::ranges::equal(one.second, other.second, nearly_equal);
         });
}

}  // namespace alidade
