// SPDX-License-Identifier: MIT
#include "extensions/radio/fresnel_measure.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "tests/support/random.h"
#include "tests/visibility/wall_cloud.h"
#include "visibility/lines/line_files.h"

namespace alidade::test {

using namespace visibility;

namespace {

/// A wall across the x axis at 30 m, 4 m wide, from z = 0 to 2.
WallCloud wall() {
  return WallCloud().add({30, -2, 0}, {0, 4, 0}, {0, 0, 2}, 0.1);
}

/// The zones of lines, and the lines themselves.
LineTable table_of(const Occluders& occluders, std::vector<LinePair> pairs, double wavelength = 0.125) {
  LineTable table;
  table.pairs = std::move(pairs);
  table.measures = {std::make_shared<FresnelMeasure>(wavelength)};
  table.reports = report_lines(occluders, table.pairs, {.measures = table.measures});
  return table;
}

const std::vector<FresnelClearance>& zones_of(const LineTable& table) {
  return static_cast<const FresnelMeasure&>(*table.measures.front()).zones();
}

TEST(FresnelMeasure, columns_and_members_are_those_of_the_zone) {
  const Occluders occluders = wall().occluders();
  LineTable table = table_of(occluders, {{"a", {{0, 0.03, 1.02}}, "b", {{100, 0.03, 1.02}}},
                                         {"a", {{0, 0, 9}}, "b", {{100, 0, 9}}}});
  const std::vector<std::uint8_t> classes(occluders.octree().size(), 6);
  table.classifications = classes;
  const FresnelClearance& zone = zones_of(table)[0];
  Row hidden = line_row(table, 0);
  EXPECT_EQ(hidden["visible"], false);
  EXPECT_EQ(hidden["fresnel_clear"], false);
  EXPECT_EQ(hidden["fresnel_class"], 6);
  EXPECT_EQ(hidden["fresnel_obstructed"], zone.obstructed);
  table.measures.front()->add_members(0, classes, hidden);
  EXPECT_EQ(hidden["obstructions"]["points"].size(), zone.obstructions.size());
  EXPECT_EQ(hidden["obstructions"]["classes"].size(), 1u);
  EXPECT_NEAR(hidden["obstructions"]["classes"][0]["share"], hidden["fresnel_obstructed"].get<double>(),
              1e-9);
  EXPECT_EQ(line_row(table, 1)["fresnel_clear"], true);
  EXPECT_EQ(table.measures.front()->remark(), "; 1 have the inner 60 % of their first Fresnel zone free");
}

TEST(FresnelMeasure, a_mesh_obstructs_without_id_and_class) {
  FresnelClearance zone;
  zone.obstructions = {{k_mesh_blocker, 0.5}, {1, 0.25}};
  PartWriter writer;
  put_zone(zone, writer);
  PartReader reader(writer.bytes(), "file", 0);
  FresnelMeasure measure(0.1);
  measure.begin(wall().occluders(), {}, 1);
  measure.take(0, reader);
  const std::vector<std::uint8_t> classes = {2, 6};
  Row row;
  measure.add_columns(0, classes, row);
  measure.add_members(0, classes, row);
  EXPECT_EQ(row["fresnel_class"], 6);
  EXPECT_EQ(row["fresnel_class_share"], 0.25);
  EXPECT_TRUE(row["obstructions"]["points"][0]["point"].is_null());
  EXPECT_TRUE(row["obstructions"]["points"][0]["class"].is_null());
  EXPECT_EQ(row["obstructions"]["points"][1]["point"], 1);
}

TEST(FresnelMeasure, along_the_edge_of_a_mesh_half_of_the_zone_is_obstructed) {
  TriangleMesh mesh;
  mesh.vertices = {{5, -2, 0}, {5, 2, 0}, {5, 2, 2}, {5, -2, 2}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Occluders occluders = WallCloud()
                                  .add({-50, -50, 0})
                                  .occluders({.mesh = std::make_shared<const TriangleTree>(std::move(mesh))});
  const LineTable table = table_of(occluders, {{"a", {{0, 0, 2}}, "b", {{10, 0, 2}}}}, 0.05);
  const FresnelClearance& zone = zones_of(table)[0];
  EXPECT_NEAR(zone.obstructed, 0.5, 0.02);
  EXPECT_FALSE(zone.is_clear);
  ASSERT_EQ(zone.obstructions.size(), 1u);
  EXPECT_EQ(zone.obstructions[0].point_id, k_mesh_blocker);
}

TEST(FresnelMeasure, is_the_same_on_one_thread) {
  Random random;
  const Occluders occluders = wall().occluders();
  std::vector<LinePair> pairs;
  for (int i = 0; i < 20; ++i)
    pairs.push_back({"", {{0, random.between(-2, 2), random.between(0, 3)}}, "", {{90, 0, 1.5}}});
  const LineTable many = table_of(occluders, pairs);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const LineTable single = table_of(occluders, pairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_EQ(zones_of(many)[i].obstructed, zones_of(single)[i].obstructed);
    EXPECT_EQ(zones_of(many)[i].cut_off, zones_of(single)[i].cut_off);
  }
}

TEST(FresnelMeasure, transparency_is_ignored_and_a_wrong_wavelength_is_an_error) {
  const std::vector<LinePair> pairs = {{"", {{0, 0, 1}}, "", {{60, 0, 1}}}};
  EXPECT_FALSE(zones_of(table_of(wall().occluders({.transparency = 2}), pairs))[0].is_clear);
  EXPECT_THROW(table_of(wall().occluders(), pairs, 0.0), Error);
}

TEST(FresnelMeasure, zones_come_back_from_their_bytes) {
  FresnelClearance zone;
  zone.radius = 0.5;
  zone.worst_t = 2.5;
  zone.is_clear = false;
  zone.nearest = LinePoint{2, {1, 1, 1}, 1.0, 0.25};
  zone.points = 17;
  zone.obstructions = {{1, 0.5}, {2, 0.25}};
  PartWriter writer;
  put_zone(zone, writer);
  PartReader reader(writer.bytes(), "file", 0);
  const FresnelClearance back = take_zone(reader, 3);
  reader.finish();
  PartWriter again;
  put_zone(back, again);
  EXPECT_EQ(again.bytes(), writer.bytes());
  EXPECT_EQ(back.obstructions[1].share, 0.25);
  // A cloud of two points has no point 2.
  PartReader small(writer.bytes(), "file", 0);
  EXPECT_THROW(take_zone(small, 2), Error);
}

}  // namespace
}  // namespace alidade::test
