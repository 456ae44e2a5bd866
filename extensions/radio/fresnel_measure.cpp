// SPDX-License-Identifier: MIT
#include "extensions/radio/fresnel_measure.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>

namespace alidade::visibility {
namespace {

constexpr std::size_t k_obstruction_bytes = 16;

/// The numbers of a zone in the order in which they are written.
constexpr std::array k_numbers = {&FresnelClearance::radius,       &FresnelClearance::obstructed,
                                  &FresnelClearance::worst,        &FresnelClearance::worst_t,
                                  &FresnelClearance::cut_off,      &FresnelClearance::inner,
                                  &FresnelClearance::nearest_share};

/// A class and its share of a zone.
struct ClassShare {
  int number;
  double share;
};

/// The largest first, then by number; without meshes; empty for a cloud without classes.
std::vector<ClassShare> class_shares(const FresnelClearance& zone, std::span<const std::uint8_t> classes) {
  std::array<double, 256> shares{};
  for (const Obstruction& one : zone.obstructions) {
    const Row number = class_value(classes, one.point_id);
    if (!number.is_null()) shares[number.get<std::size_t>()] += one.share;
  }
  std::vector<ClassShare> all;
  for (int number = 0; number < 256; ++number) {
    const double share = shares[static_cast<std::size_t>(number)];
    if (share > 0.0) all.push_back({number, share});
  }
  std::ranges::stable_sort(all, std::greater(), &ClassShare::share);
  return all;
}

}  // namespace

LineMeasure::Measure FresnelMeasure::begin(const Occluders& occluders, const LineOptions& options,
                                           std::size_t lines) {
  point_count_ = occluders.octree().size();
  zones_.resize(lines);
  const auto opaque = std::make_shared<Occluders>(occluders.solid());
  return [opaque, options, wavelength = wavelength_](const SightEnd& from, const SightEnd& to,
                                                     PartWriter& writer) {
    put_zone(fresnel_clearance(*opaque, from, to, options, wavelength), writer);
  };
}

void FresnelMeasure::take(std::size_t line, PartReader& reader) {
  zones_[line] = take_zone(reader, point_count_);
}

void FresnelMeasure::add_columns(std::size_t line, std::span<const std::uint8_t> classes, Row& row) const {
  const FresnelClearance& zone = zones_[line];
  row["fresnel_radius"] = zone.radius;
  row["fresnel_clear"] = zone.is_clear;
  row["fresnel_obstructed"] = zone.obstructed;
  row["fresnel_inner"] = zone.inner;
  row["fresnel_worst"] = zone.worst;
  row["fresnel_worst_at"] = zone.obstructions.empty() ? Row() : Row(zone.worst_t);
  row["fresnel_cut_off"] = zone.cut_off;
  const std::vector<ClassShare> shares = class_shares(zone, classes);
  row["fresnel_class"] = shares.empty() ? Row() : Row(shares.front().number);
  row["fresnel_class_share"] = shares.empty() ? Row() : Row(shares.front().share);
  row["fresnel_points"] = zone.points;
  row["fresnel_nearest"] = zone.nearest ? Row(zone.nearest_share) : Row();
  add_point(row, "fresnel_nearest", zone.nearest, classes);
}

void FresnelMeasure::add_members(std::size_t line, std::span<const std::uint8_t> classes, Row& row) const {
  Row points = Row::array(), shares = Row::array();
  for (const Obstruction& one : zones_[line].obstructions)
    points.push_back({{"point", id_value(one.point_id)},
                      {"class", class_value(classes, one.point_id)},
                      {"share", one.share}});
  for (const ClassShare& one : class_shares(zones_[line], classes))
    shares.push_back({{"class", one.number}, {"share", one.share}});
  row["obstructions"] = {{"points", points}, {"classes", shares}};
}

std::string FresnelMeasure::remark() const {
  return fmt::format("; {} have the inner 60 % of their first Fresnel zone free",
                     std::ranges::count_if(zones_, &FresnelClearance::is_clear));
}

void put_zone(const FresnelClearance& zone, PartWriter& writer) {
  for (const auto number : k_numbers) writer.put(zone.*number);
  writer.put(std::uint8_t{zone.is_clear});
  put_point(zone.nearest, writer);
  writer.put(zone.points);
  writer.put(std::uint64_t{zone.obstructions.size()});
  for (const Obstruction& one : zone.obstructions) {
    writer.put(one.point_id);
    writer.put(one.share);
  }
}

FresnelClearance take_zone(PartReader& reader, std::uint64_t point_count) {
  FresnelClearance zone;
  for (const auto number : k_numbers) zone.*number = reader.take<double>();
  zone.is_clear = reader.take<std::uint8_t>() != 0;
  zone.nearest = take_point(reader, point_count);
  zone.points = reader.take<std::uint64_t>();
  zone.obstructions.resize(reader.take_count(k_obstruction_bytes));
  for (Obstruction& one : zone.obstructions) {
    one.point_id = take_blocker_id(reader, point_count);
    one.share = reader.take<double>();
  }
  return zone;
}

}  // namespace alidade::visibility
