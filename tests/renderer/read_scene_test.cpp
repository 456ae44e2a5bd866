// SPDX-License-Identifier: MIT
#include "renderer/read_scene.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "camera/camera_json.h"
#include "tests/renderer/describe_scene.h"

namespace alidade::test {

using namespace geo;
using namespace image;
using namespace camera;
using namespace renderer;

namespace {

Error::Parts scene_error(const std::string& text) {
  try {
    parse_scene(text, "scenes/yard.json");
  } catch (const Error& error) {
    return error.parts();
  }
  ADD_FAILURE() << "no error in " << text;
  return {};
}

std::string with(const std::string& rest) {
  return "{ \"version\": 1,\n  " + rest + " }";
}

TEST(ReadSceneTest, a_scene_has_the_values_of_its_file) {
  const Scene scene = parse_scene(R"({
    "version": 1, "description": "all of it",
    "cloud": { "files": ["a.las", "../b.ply"], "partial": true, "radius": 0.05, "hits": "t", "color": "intensity", "color_depth": 8, "normals": "smooth", "surface": "blend", "max_level": 4,
               "material": { "type": "metal", "roughness": 0.25 } },
    "objects": [ { "type": "sphere", "center": [2, 1.5, -1], "radius": 0.5,
                   "material": { "type": "metal", "albedo": [0.9, 0.8, 0.7], "roughness": 0.1 } },
                 { "type": "sphere", "center": [0, 0, 0], "radius": 1,
                   "material": { "type": "dielectric", "refractive_index": 1.33 } },
                 { "type": "sphere", "center": [0, 0, 0], "radius": 2,
                   "material": { "type": "emissive", "radiance": [5, 6, 7] } },
                 { "type": "ground_plane", "height": 3, "material": { "type": "lambertian", "albedo": [0, 0.5, 1] } },
                 { "type": "ground_plane" },
                 { "type": "mesh", "file": "../house.ply", "scale": 0.5, "rotate_z": -30, "translate": [690000, 5325000, 500],
                   "material": { "type": "metal", "roughness": 0.5 } },
                 { "type": "mesh", "file": "a.obj" } ],
    "sky": { "type": "constant", "radiance": [0.25, 0.5, 0.75] },
    "sun": { "azimuth": 90, "elevation": 45, "irradiance": [1, 2, 3], "angular_diameter": 0 },
    "render": { "samples": 7, "max_bounces": 0, "seed": 18446744073709551615 },
    "output": { "file": "out/yard.exr", "layers": ["id", "variance"], "exposure": -1.5, "precision": "float" } })",
                                  "scenes/yard.json");
  EXPECT_EQ(describe(scene),
            "cloud scenes/a.las b.ply depth 1 hits 1 color intensity normals 1 shape 2 partial levels 4 "
            "0.050000000000000003 "
            "metal own 0.25 \n"
            "sphere 2 1.5 -1 0.5 metal 0.89999997615814209 0.80000001192092896 0.69999998807907104 "
            "0.10000000000000001 \n"
            "sphere 0 0 0 1 dielectric 1.3300000000000001 \n"
            "sphere 0 0 0 2 emissive 5 6 7 \n"
            "plane 3 lambertian 0 0.5 1 \n"
            "plane 0 lambertian 0.5 0.5 0.5 \n"
            "mesh house.ply 0.5 -30 690000 5325000 500 metal own 0.5 \n"
            "mesh scenes/a.obj 1 0 0 0 0 lambertian own \n"
            "sky constant 0.25 0.5 0.75 \n"
            "sun 90 45 1 2 3 0 \n"
            "camera chosen\n"
            "render 7 0 18446744073709551615\n"
            "output 'scenes/out/yard.exr' half false -1.5 6 7 ");
}

TEST(ReadSceneTest, what_a_scene_leaves_out_is_as_in_the_structs) {
  EXPECT_EQ(describe(parse_scene(R"({"version": 1})", "x.json")), describe(Scene{}));
  Scene scene;
  scene.cloud.emplace().files = {"a.las"};
  scene.cloud->shape = PointShape::blend;  // as 'alidade render' without a scene
  scene.sun = Sun{};
  EXPECT_EQ(describe(parse_scene(R"({"version": 1, "cloud": {"file": "a.las"}, "sun": {}})", "x.json")),
            describe(scene));
}

TEST(ReadSceneTest, points_are_blended_discs_unless_something_applies_to_spheres_only) {
  const auto shape = [](const std::string& keys) {
    return parse_scene(R"({"version": 1, "cloud": {"file": "a.las")" + keys + "}}", "x.json").cloud->shape;
  };
  for (const char* const keys :
       {"", R"(, "radius": "auto")", R"(, "radius": {"factor": 1})", R"(, "radius": {"neighbours": 8})",
        R"(, "material": {"type": "metal"})", R"(, "color": "height", "partial": true)",
        R"(, "surface": "blend", "normals": "smooth")"})
    EXPECT_EQ(shape(keys), PointShape::blend) << keys;
  for (const char* const keys : {R"(, "radius": 0.1)", R"(, "radius": {"neighbours": 4})",
                                 R"(, "hits": "entry")", R"(, "normals": "sphere")", R"(, "max_level": 3)",
                                 R"(, "material": {"type": "dielectric"})", R"(, "surface": "sphere")"})
    EXPECT_EQ(shape(keys), PointShape::sphere) << keys;
  EXPECT_EQ(shape(R"(, "surface": "disc")"), PointShape::disc);
}

TEST(ReadSceneTest, colours_are_a_word_or_an_object_with_map_range_and_classes) {
  const auto color = [](const std::string& text) {
    return parse_scene(R"({"version": 1, "cloud": {"file": "a.las", "color": )" + text + "}}", "x.json")
        .cloud->color;
  };
  EXPECT_EQ(color("\"return_number\"").by, PointColor::return_number);
  EXPECT_EQ(color("\"Reflectance\"").attribute, "Reflectance");
  const PointColoring height =
      color(R"({"by": "height", "map": "turbo", "range": [-1.5, 20], "percentiles": [2, 98.5]})");
  EXPECT_EQ(height.by, PointColor::height);
  EXPECT_EQ(height.map, ColorMap::turbo);
  EXPECT_EQ(height.range, (ValueRange{-1.5, 20.0}));
  EXPECT_EQ(height.percentiles, (ValueRange{2.0, 98.5}));
  const PointColoring usual = color(R"({"by": "gps_time", "map": "auto", "range": "auto"})");
  EXPECT_FALSE(usual.map);
  EXPECT_FALSE(usual.range);
  const PointColoring classes = color(
      R"({"by": "classification", "classes": [{"class": 6, "color": "#ff0080"}, {"class": 70, "color": "#000001", "name": "Mast"}]})");
  ASSERT_EQ(classes.classes.size(), 2u);
  EXPECT_EQ(classes.classes[0].number, 6);
  EXPECT_EQ(classes.classes[0].color, Color16(65535, 0, 128 * 257));
  EXPECT_EQ(classes.classes[1].name, "Mast");
  EXPECT_EQ(color("{}").by, PointColor::automatic);
}

TEST(ReadSceneTest, light_has_the_values_of_its_file) {
  const Scene scene = parse_scene(R"({ "version": 1,
    "sky": { "type": "image", "file": "../skies/noon.exr", "scale": 2.5, "rotation": -90 },
    "sun": { "date_time": "2003-10-17T12:30:30-07:00", "latitude": 39.5, "longitude": -105.25, "height": 1830.5,
             "pressure": 820, "temperature": 11, "irradiance": [1, 2, 3], "angular_diameter": 0 },
    "render": { "mode": "ambient_occlusion", "ao_distance": 2.5 } })",
                                  "scenes/yard.json");
  const std::string said = describe(scene);
  EXPECT_NE(said.find("\nsky image skies/noon.exr 2.5 -90 \n"), std::string::npos) << said;
  EXPECT_NE(said.find("\nsun on 2003-10-17T19:30:30Z at 39.5 -105.25 1830.5 820 11 1 2 3 0 \n"),
            std::string::npos)
      << said;
  EXPECT_NE(said.find(" mode 1 near 2.5 \n"), std::string::npos) << said;
  EXPECT_FALSE(scene.sun);
  const Scene sparse = parse_scene(R"({ "version": 1, "sky": { "type": "image", "file": "a.hdr" },
    "sun": { "date_time": "2003-10-17T12:30Z" }, "render": { "mode": "flat", "ao_distance": "auto" } })",
                                   "yard.json");
  Scene same;
  same.sky = ImageSky{.file = "a.hdr", .image = {}};
  same.sun_by_time = SunByTime{.moment = parse_date_time("2003-10-17T12:30:00Z")};
  same.render.mode = RenderMode::flat;
  EXPECT_EQ(describe(sparse), describe(same));
}

TEST(ReadSceneTest, absolute_paths_stay) {
  const Scene scene = parse_scene(R"({"version": 1, "cloud": {"file": "/data/a.las"}})", "scenes/yard.json");
  EXPECT_EQ(scene.cloud->files.at(0), "/data/a.las");
}

TEST(ReadSceneTest, an_unknown_key_names_location_pointer_and_the_nearest_known_key) {
  const Error::Parts parts =
      scene_error(with(R"("objects": [ { "type": "sphere", "centre": [0, 0, 0], "radius": 1 } ])"));
  EXPECT_EQ(parts.file, "scenes/yard.json");
  EXPECT_EQ(parts.location, "2:36");
  EXPECT_EQ(parts.problem, "unknown key, did you mean \"center\"? (at /objects/0/centre)");
  EXPECT_EQ(parts.expected, "one of \"type\", \"center\", \"radius\", \"material\"");
  EXPECT_EQ(parts.found, "\"centre\"");
}

TEST(ReadSceneTest, pointers_escape_slash_and_tilde) {
  EXPECT_EQ(scene_error(with(R"("a/b~c": 1)")).problem, "unknown key (at /a~1b~0c)");
}

TEST(ReadSceneTest, every_mistake_is_named_at_its_location) {
  struct Case {
    std::string text, location, message;
  };
  const std::vector<Case> cases{
      {"[]", "1:1", "wrong type (at the top); expected an object, found an array of 0 values"},
      {"{}", "1:1", "missing key \"version\" (at the top)"},
      {R"({"version": 2})", "1:13", "unsupported version (at /version); expected 1, found 2"},
      {with(R"("sun": { "elevation": -90 })"), "2:25",
       "number out of range (at /sun/elevation); expected a number greater than -90 and at most 90, found "
       "-90"},
      {with(R"("sun": { "irradiance": [1, 2] })"), "2:26",
       "wrong number of values (at /sun/irradiance); expected an array of 3 values, found an array of 2 "
       "values"},
      {with(R"("sky": { "type": "constnat" })"), "2:20",
       "unknown value, did you mean \"constant\"? (at /sky/type); expected one of \"constant\", "
       "\"gradient\", "
       "\"image\", found \"constnat\""},
      {with(R"("sky": { "type": "image" })"), "2:10", "missing key \"file\" (at /sky)"},
      {with(R"("sky": { "type": "image", "file": "a.exr", "scale": -1 })"), "2:55",
       "number out of range (at /sky/scale)"},
      {with(R"("sun": { "date_time": "2026-06-21T12:00:00" })"), "2:25",
       "missing time zone (at /sun/date_time); expected Z for UTC or an offset"},
      {with(R"("sun": { "date_time": "2026-02-30T12:00Z" })"), "2:25",
       "invalid date (at /sun/date_time); expected a calendar date, found \"2026-02-30T12:00Z\""},
      {with(R"("sun": { "date_time": "noon" })"), "2:25", "invalid date and time (at /sun/date_time)"},
      {with(R"("sun": { "date_time": 12 })"), "2:25",
       "wrong type (at /sun/date_time); expected a string, found 12"},
      {with(R"("sun": { "date_time": "2026-06-21T12:00Z", "elevation": 3 })"), "2:59",
       "the sun has both angles and a time (at /sun/elevation)"},
      {with(R"("sun": { "date_time": "2026-06-21T12:00Z", "latitude": 48 })"), "2:58",
       "incomplete location (at /sun/latitude)"},
      {with(R"("sun": { "latitude": 48, "longitude": 11 })"), "2:24",
       "the location of the sun requires a time (at /sun/latitude); expected \"date_time\", found none"},
      {with(R"("sun": { "date_time": "2026-06-21T12:00Z", "irradiance": "much" })"), "2:60",
       "unknown value (at /sun/irradiance)"},
      {with(R"("render": { "mode": "ao" })"), "2:23", "unknown value (at /render/mode)"},
      {with(R"("render": { "ao_distance": 0 })"), "2:30", "number out of range (at /render/ao_distance)"},
      {with(R"("sky": {})"), "2:10", "missing key \"type\" (at /sky)"},
      {with(R"("cloud": {})"), "2:12", "missing key \"files\" (at /cloud); expected \"files\" or \"file\""},
      {with(R"("cloud": { "file": "a", "files": ["a"] })"), "2:22",
       "\"file\" and \"files\" exclude each other"},
      {with(R"("cloud": { "file": "" })"), "2:22", "empty string (at /cloud/file)"},
      {with(R"("cloud": { "file": "a\u0000b" })"), "2:22", "string contains a NUL character"},
      {with(R"("cloud": { "file": "a", "radius": "Auto" })"), "2:37",
       "unknown value, did you mean \"auto\"?"},
      {with(R"("cloud": { "file": "a", "radius": 0 })"), "2:37", "number out of range (at /cloud/radius)"},
      {with(R"("cloud": { "file": "a", "radius": { "neighbors": 8 } })"), "2:39",
       "unknown key, did you mean \"neighbours\"? (at /cloud/radius/neighbors)"},
      {with(R"("cloud": { "file": "a", "radius": { "neighbours": 65 } })"), "2:53", "number out of range"},
      {with(R"("cloud": { "file": "a", "radius": { "factor": 0 } })"), "2:49", "number out of range"},
      {with(R"("cloud": { "file": "a", "radius": { "max": -1 } })"), "2:46", "number out of range"},
      {with(R"("cloud": { "file": "a", "radius": [1] })"), "2:37",
       "wrong type (at /cloud/radius); expected a number"},
      {with(R"("cloud": { "file": "a", "color_depth": 12 })"), "2:42", "invalid colour depth"},
      {with(R"("cloud": { "file": "a", "color": { "map": "virids" } })"), "2:45",
       "unknown value, did you mean \"viridis\"? (at /cloud/color/map)"},
      {with(R"("cloud": { "file": "a", "color": { "range": [2, 2] } })"), "2:47",
       "empty range (at /cloud/color/range); expected the smaller number first"},
      {with(R"("cloud": { "file": "a", "color": { "percentiles": [1, 100.5] } })"), "2:57",
       "number out of range (at /cloud/color/percentiles/1); expected a number from 0 to 100"},
      {with(R"("cloud": { "file": "a", "color": { "classes": [{ "class": 256, "color": "#000000" }] } })"),
       "2:61", "expected an integer from 0 to 255"},
      {with(R"("cloud": { "file": "a", "color": { "classes": [{ "class": 2, "color": "#00000" }] } })"),
       "2:73", "invalid colour (at /cloud/color/classes/0/color); expected \"#rrggbb\" in hexadecimal"},
      {with(
           R"("cloud": { "file": "a", "color": { "classes": [{ "class": 2, "color": "#000000" }, { "class": 2, "color": "#000000" }] } })"),
       "2:86", "duplicate class (at /cloud/color/classes/1)"},
      {with(R"("cloud": { "file": "a", "color": 5 })"), "2:36", "wrong type (at /cloud/color)"},
      {with(
           R"("objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1, "material": { "type": "metal" } } ])"),
       "2:82", "missing key \"albedo\" (at /objects/0/material)"},
      {with(
           R"("objects": [ { "type": "ground_plane", "material": { "type": "lambertian", "roughness": 0 } } ])"),
       "2:78", "unknown key (at /objects/0/material/roughness); expected one of \"type\", \"albedo\""},
      {with(R"("render": { "samples": 0 })"), "2:26", "expected an integer from 1 to 16777216, found 0"},
      {with(R"("render": { "samples": 1.5 })"), "2:26", "not an integer (at /render/samples)"},
      {with(R"("render": { "seed": -1 })"), "2:23", "number out of range (at /render/seed)"},
      {with(R"("render": { "seed": 18446744073709551616 })"), "2:23",
       "number out of range (at /render/seed)"},
      {with(R"("output": { "file": "a.bmp" })"), "2:23", "unknown output format"},
      {with(R"("output": { "layers": ["id", "id"] })"), "2:32", "duplicate layer (at /output/layers/1)"},
      {with(R"("output": { "layers": [] })"), "2:25", "wrong number of values"},
      {with(R"("camera": 5)"), "2:13", "wrong type (at /camera)"},
      {with(R"("description": 5)"), "2:18", "wrong type (at /description); expected a string, found 5"},
  };
  for (const Case& each : cases) {
    const Error::Parts parts = scene_error(each.text);
    EXPECT_EQ(parts.location, each.location) << each.text;
    EXPECT_NE(std::string(Error(parts).what()).find(each.message), std::string::npos) << Error(parts).what();
  }
}

TEST(ReadSceneTest, a_long_unknown_key_gives_a_short_message) {
  const Error::Parts parts = scene_error(with("\"" + std::string(1'000'000, 'k') + "\": 1"));
  EXPECT_LT(std::string(Error(parts).what()).size(), 400u);
}

class SceneFileTest : public ::testing::Test {
 protected:
  SceneFileTest()
      : folder_(std::filesystem::temp_directory_path() / ("read_scene_test_" + std::to_string(::getpid()))) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_ / "cameras");
  }
  ~SceneFileTest() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  static std::string message(const std::filesystem::path& file) {
    try {
      read_scene(file);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }
  std::filesystem::path folder_;
};

constexpr const char* k_camera = R"({"version": 1, "model": "pinhole", "width": 6, "height": 4,
  "intrinsics": {"vertical_fov": 50}, "pose": {"look_at": {"eye": [1, 2, 3], "target": [0, 0, 0]}}})";

TEST_F(SceneFileTest, a_camera_file_is_found_beside_the_scene) {
  write("cameras/front.json", k_camera);
  const auto file = write("scene.json", R"({"version": 1, "camera": "cameras/front.json"})");
  const auto inline_file = write("inline.json", R"({"version": 1, "camera": )" + std::string(k_camera) + "}");
  EXPECT_EQ(describe(*read_scene(file).camera), describe(*read_scene(inline_file).camera));
  EXPECT_EQ(describe(read_camera(folder_ / "cameras/front.json")), describe(*read_scene(file).camera));
}

TEST_F(SceneFileTest, mistakes_in_a_camera_file_name_that_file) {
  const auto camera = write("cameras/front.json", "{\n \"version\": 1, \"modl\": \"pinhole\" }");
  const auto file = write("scene.json", R"({"version": 1, "camera": "cameras/front.json"})");
  EXPECT_TRUE(message(file).starts_with(camera.string() + ":2:16: unknown key, did you mean \"model\"?"))
      << message(file);
}

TEST_F(SceneFileTest, files_that_cannot_be_read_are_errors) {
  EXPECT_EQ(message(folder_ / "none.json"), (folder_ / "none.json").string() + ": no such file");
  EXPECT_EQ(message(folder_), folder_.string() + ": not a regular file");
  EXPECT_EQ(message("/dev/zero"), "/dev/zero: not a regular file");
  const auto large = write("large.json", "");
  std::filesystem::resize_file(large, (4u << 20) + 1);
  EXPECT_NE(message(large).find("too large"), std::string::npos);
  EXPECT_NE(message(write("empty.json", "")).find(":1:1: invalid JSON"), std::string::npos);
}

}  // namespace
}  // namespace alidade::test
