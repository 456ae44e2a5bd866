// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "extensions/radio/fresnel.h"
#include "visibility/lines/line_measure.h"

namespace alidade::visibility {

/// The first Fresnel zone of every line, as fresnel_clearance(); occluders may have a transparency, which is
/// ignored.
class FresnelMeasure : public LineMeasure {
 public:
  /// Metres.
  explicit FresnelMeasure(double wavelength) : wavelength_(wavelength) {}

  Measure begin(const Occluders& occluders, const LineOptions& options, std::size_t lines) override;
  void take(std::size_t line, PartReader& reader) override;
  void add_columns(std::size_t line, std::span<const std::uint8_t> classes, Row& row) const override;
  /// Adds `obstructions`: points by their share of the zone, and classes.
  void add_members(std::size_t line, std::span<const std::uint8_t> classes, Row& row) const override;
  /// How many zones are clear.
  std::string remark() const override;

  const std::vector<FresnelClearance>& zones() const { return zones_; }

 private:
  double wavelength_;
  std::uint64_t point_count_ = 0;
  std::vector<FresnelClearance> zones_;
};

/// Writes a zone to a part.
void put_zone(const FresnelClearance& zone, PartWriter& writer);
/// Reads a zone from a part. Errors: those of PartReader; point ids not below point_count.
FresnelClearance take_zone(PartReader& reader, std::uint64_t point_count);

}  // namespace alidade::visibility
