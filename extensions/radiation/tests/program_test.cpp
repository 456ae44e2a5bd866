// SPDX-License-Identifier: MIT
#include <cstring>
#include <nlohmann/json.hpp>

#include "cloud/read_cloud.h"
#include "tests/tools/wall_site.h"

namespace alidade::test {
namespace {

class RadiationTest : public WallSiteTest {
 protected:
  /// `alidade visibility COMMAND site.csv WORDS...`, quietly.
  ProgramResult visibility(const std::string& command, const Words& words) {
    Words all{"visibility", command, "site.csv", "-q"};
    all.insert(all.end(), words.begin(), words.end());
    return run(all);
  }

  /// The float values of an extra dimension of a cloud.
  std::vector<float> column(const std::string& file, const std::string& name) {
    const std::filesystem::path path = folder / file;
    const PointCloud cloud = read_cloud(std::span(&path, 1));
    std::vector<float> numbers(cloud.size());
    for (const ExtraDimension& dimension : cloud.extra_dimensions) {
      if (dimension.name != name) continue;
      EXPECT_EQ(dimension.type, ScalarType::float32);
      std::memcpy(numbers.data(), dimension.values.data(), dimension.values.size());
      return numbers;
    }
    ADD_FAILURE() << "no " << name;
    return numbers;
  }

  /// Row of the floor's point (0.2 i, 0.2 j).
  static std::size_t floor(int i, int j) { return static_cast<std::size_t>((i + 25) * 51 + (j + 25)); }
};

TEST_F(RadiationTest, of_every_point_is_counted) {
  const ProgramResult result = visibility("sun", {"--place", "48,11", "--step", "30", "--receiver",
                                                  "horizontal", "-o", "day.las", "--from", "2026-06-21"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::vector<float> energy = column("day.las", "BeamEnergy");
  EXPECT_GT(energy[floor(-25, -25)], 6500.0);
  EXPECT_LT(energy[floor(-25, -25)], 8000.0);
  const std::vector<float> diffuse = column("day.las", "DiffuseEnergy"),
                           all = column("day.las", "GlobalEnergy");
  EXPECT_GT(diffuse[floor(-25, -25)], 1100.0);
  EXPECT_LT(diffuse[floor(-1, 0)], 0.8 * diffuse[floor(-25, -25)]);
  EXPECT_NEAR(all[floor(-25, -25)], energy[floor(-25, -25)] + diffuse[floor(-25, -25)], 1.0);
  EXPECT_LT(energy[floor(-1, 0)], 0.8 * energy[floor(-25, -25)]);
}

TEST_F(RadiationTest, sun_with_a_bounce_lights_points_and_observers_before_the_wall) {
  const auto sun = [&](const std::string& bounces, Words more) {
    const Words words{"--place", "48,11", "--step", "240", "--from", "2026-06-21", "--bounces", bounces};
    more.insert(more.begin(), words.begin(), words.end());
    return visibility("sun", more);
  };
  for (const std::string bounces : {"0", "1"}) {
    const ProgramResult result = sun(bounces, {"-o", bounces + ".las"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    ASSERT_EQ(sun(bounces, {"--observer", "-0.5,0,0.1", "-o", bounces + ".json"}).exit_code, 0);
  }
  EXPECT_EQ(nlohmann::json::parse(read("1.json"))["alidade_sun_bounces"], "1");
  const std::vector<float> without = column("0.las", "ReflectedEnergy"),
                           with = column("1.las", "ReflectedEnergy");
  EXPECT_LT(without[floor(-3, 0)], 1.0f);
  EXPECT_GT(with[floor(-3, 0)], 50.0f) << "beside the wall";
  EXPECT_GT(with[floor(-3, 0)], 2.0f * with[floor(-25, -25)]);
  EXPECT_EQ(column("0.las", "BeamEnergy"), column("1.las", "BeamEnergy"));
  EXPECT_EQ(column("0.las", "DiffuseEnergy"), column("1.las", "DiffuseEnergy"));
  const auto of_observer = [&](const std::string& file) {
    return nlohmann::json::parse(read(file))["observers"][0]["ReflectedEnergy"].get<double>();
  };
  EXPECT_EQ(of_observer("0.json"), 0.0);
  EXPECT_GT(of_observer("1.json"), 50.0);

  const ProgramResult beam = sun("1", {"--beam-only", "-o", "c.las"});
  EXPECT_NE(beam.exit_code, 0);
  EXPECT_TRUE(contains(beam.err, "--bounces 1 does not apply with --beam-only")) << beam.err;
  const ProgramResult two = sun("2", {"-o", "c.las"});
  EXPECT_NE(two.exit_code, 0);
  EXPECT_TRUE(contains(two.err, "--bounces")) << two.err;
  EXPECT_TRUE(read("c.las").empty());
}

TEST_F(RadiationTest, of_observers_is_in_columns_behind_hours) {
  const Words words{"--place", "48,11", "--step", "60", "--from", "2026-06-21", "--observer", "-3,0.03,1"};
  ASSERT_EQ(visibility("sun", with(words, {"-o", "sun.csv"})).exit_code, 0);
  EXPECT_TRUE(read("sun.csv").starts_with(
      "observer,x,y,z,SunHours,BeamEnergy,DiffuseEnergy,ReflectedEnergy,GlobalEnergy\n"))
      << read("sun.csv");
  ASSERT_EQ(visibility("sun", with(words, {"-o", "sun.json", "--tilt", "40"})).exit_code, 0);
  const auto object = nlohmann::json::parse(read("sun.json"));
  EXPECT_GT(object["observers"][0]["ReflectedEnergy"], 0.0);
  EXPECT_TRUE(contains(object["alidade_sky"], "Linke turbidity 3"));
  ASSERT_EQ(visibility("sun", with(words, {"-o", "beam.csv", "--beam-only"})).exit_code, 0);
  EXPECT_TRUE(read("beam.csv").starts_with("observer,x,y,z,SunHours,BeamEnergy\n"));
}

TEST_F(RadiationTest, mistakes_are_errors) {
  const auto err = [&](const Words& more) {
    const Words words{"--place", "48,11", "--from", "2026-06-21", "--observer", "-3,0.03,1", "-o", "b.csv"};
    const ProgramResult wrong = visibility("sun", with(words, more));
    EXPECT_EQ(wrong.exit_code, 2) << more.front();
    return wrong.err;
  };
  EXPECT_TRUE(contains(err({"--turbidity", "3,4"}), "one number, or twelve"));
  write("bad.epw", "LOCATION,a,b,c,d,e,148,11,1,500\n");
  EXPECT_TRUE(contains(err({"--weather", "bad.epw"}), "bad.epw:line 1: invalid latitude"));
  EXPECT_TRUE(contains(err({"--weather", "none.epw"}), "none.epw"));
  EXPECT_FALSE(std::filesystem::exists(folder / "b.csv"));
}

}  // namespace
}  // namespace alidade::test
