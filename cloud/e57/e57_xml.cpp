// SPDX-License-Identifier: MIT
#include "cloud/e57/e57_xml.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string_view>

#include "base/text_scanner.h"

namespace alidade {
namespace {

template <class Integer>
std::optional<Integer> parse_integer(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  Integer value{};
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string_view without_blanks(std::string_view text) {
  constexpr const char* k_blanks = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(k_blanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(k_blanks) - begin + 1);
}

}  // namespace

std::string E57Node::text() const {
  std::string text;
  for (const pugi::xml_node& part : element_.children()) {
    if (part.type() == pugi::node_pcdata || part.type() == pugi::node_cdata) text += part.value();
  }
  return std::string(without_blanks(text));
}

std::optional<double> E57Node::number() const {
  const std::string word = text();
  if (word.empty()) return std::nullopt;
  auto value = parse_number(word);
  if (value && std::string_view(element_.attribute("type").value()) == "ScaledInteger")
    value = *value * number_attribute("scale").value_or(1.0) + number_attribute("offset").value_or(0.0);
  if (!value || !std::isfinite(*value)) fail("has no finite number", "a number", quote(word));
  return value;
}

std::uint64_t E57Node::count() const {
  const std::string word = text();
  if (word.empty()) return 0;
  const auto value = parse_integer<std::uint64_t>(word);
  if (!value) fail("has no whole number", "a whole number from 0 on", quote(word));
  return *value;
}

std::optional<std::int64_t> E57Node::integer_attribute(const char* name) const {
  const pugi::xml_attribute attribute = element_.attribute(name);
  if (!attribute) return std::nullopt;
  const auto value = parse_integer<std::int64_t>(without_blanks(attribute.value()));
  if (!value)
    fail(fmt::format("has no whole number as {}", name), "a whole number", quote(attribute.value()));
  return value;
}

std::optional<double> E57Node::number_attribute(const char* name) const {
  const pugi::xml_attribute attribute = element_.attribute(name);
  if (!attribute) return std::nullopt;
  const auto value = parse_number(without_blanks(attribute.value()));
  if (!value || !std::isfinite(*value))
    fail(fmt::format("has no finite number as {}", name), "a number", quote(attribute.value()));
  return value;
}

std::uint64_t E57Node::require_count_attribute(const char* name) const {
  const pugi::xml_attribute attribute = element_.attribute(name);
  const auto value = parse_integer<std::uint64_t>(without_blanks(attribute.value()));
  if (!value) {
    fail(fmt::format("has no whole number as {}", name), "a whole number from 0 on",
         attribute ? quote(attribute.value()) : "none");
  }
  return *value;
}

void E57Node::fail(std::string problem, std::string expected, std::string found) const {
  pages_->fail(where_, (element_ ? quote(element_.name()) + " " : "") + std::move(problem),
               std::move(expected), std::move(found));
}

}  // namespace alidade
