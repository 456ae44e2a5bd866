// SPDX-License-Identifier: MIT
#include "extensions/radiation/job.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "jobs/visibility/sun.h"
#include "tests/jobs/garden_job.h"

namespace alidade::test {
namespace {

class RadiationJobTest : public GardenJobTest {
 protected:
  jobs::SunRequest noon(const jobs::RadiationRequest& radiation) const {
    auto made = request<jobs::SunRequest>();
    made.from = {parse_date_time("2026-06-21T10:00Z")};
    made.to = {parse_date_time("2026-06-21T12:00Z")};
    made.step_minutes = 60.0;
    made.location = {48.0, 11.0};
    const auto added = std::make_shared<jobs::AddedRadiation>();
    added->request = radiation;
    made.measures = {added};
    return made;
  }
};

TEST_F(RadiationJobTest, observers_have_energies_beside_hours) {
  jobs::SunRequest sun = noon({});
  sun.observers.positions = {k_before};
  const jobs::SunResult result = run(jobs::plan(sun), heard);
  ASSERT_EQ(result.numbers.size(), 4u);
  EXPECT_FLOAT_EQ(result.numbers[0], 2.0f);
  EXPECT_GT(result.numbers[1], 1000.0f);
  const visibility::PositionTable table = table_of(sun, result);
  EXPECT_EQ(table.rows[0].size(), 4u + 5u);
  EXPECT_GT(table.rows[0]["GlobalEnergy"], table.rows[0]["BeamEnergy"]);
}

TEST_F(RadiationJobTest, maps_have_bands_of_energy) {
  jobs::SunRequest sun = noon({.beam_only = true});
  sun.map.resolution = 4.0;
  const jobs::SunResult result = run(jobs::plan(sun), heard);
  const std::vector<jobs::SunBand> bands = bands_of(sun, result);
  ASSERT_EQ(bands.size(), 2u);
  EXPECT_EQ(bands[1].name, "BeamEnergy");
}

TEST_F(RadiationJobTest, a_bounce_needs_the_light_of_the_sky) {
  EXPECT_THROW(jobs::plan(noon({.beam_only = true, .bounces = 1})), Error);
}

}  // namespace
}  // namespace alidade::test
