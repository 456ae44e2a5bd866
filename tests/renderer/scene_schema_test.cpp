// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <set>

#include "base/error.h"
#include "base/input_file.h"
#include "camera/camera_json.h"
#include "renderer/read_scene.h"
#include "renderer/scene_forms.h"
#include "tests/renderer/describe_scene.h"
#include "tests/renderer/schema_validator.h"

// The JSON Schemas are the reference for scene and camera files; that of scenes is written from
// renderer/scene_forms.h. Reader and schemas are compared by documents that use every key, and by small
// changes to them: whatever the change, both must accept or both must reject.

namespace alidade::test {

using namespace geo;
using namespace image;
using namespace camera;
using namespace renderer;

namespace {

const std::filesystem::path k_scenes = std::filesystem::path(ALIDADE_SOURCE_FOLDER) / "scenes";

struct Sample {
  std::string schema;
  Json document;
};

Json camera(const char* intrinsics, const char* pose) {
  return Json{{"version", 1},
              {"description", "a camera"},
              {"model", "pinhole"},
              {"width", 6},
              {"height", 4},
              {"intrinsics", Json::parse(intrinsics)},
              {"pose", Json::parse(pose)}};
}

Json camera_with_lens(const char* model, const char* intrinsics, const char* distortion = nullptr) {
  Json result = camera(intrinsics, R"({"look_at": {"eye": [1, 2, 3], "target": [4, 4, 4]}})");
  result["model"] = model;
  if (distortion != nullptr) result["distortion"] = Json::parse(distortion);
  return result;
}

constexpr const char* k_long_lens = R"({"fx": 90, "fy": 80, "cx": 3, "cy": 2})";

std::vector<Json> cameras() {
  return {
      camera_with_lens("brown", R"({"vertical_fov": 30})",
                       R"({"k1": 1e-3, "k2": 1e-3, "k3": 1e-3, "k4": 1e-3, "k5": 1e-3, "k6": 1e-3, "r8": 1e-3,
                           "p1": 1e-3, "p2": 1e-3, "s1": 1e-3, "s2": 1e-3, "s3": 1e-3, "s4": 1e-3})"),
      camera_with_lens("fisheye", k_long_lens,
                       R"({"k1": 1e-3, "k2": 1e-3, "k3": 1e-3, "k4": 1e-3, "k5": 1e-3, "k6": 1e-3, "p1": 1e-3,
                           "p2": 1e-3, "s1": 1e-3, "s2": 1e-3, "s3": 1e-3, "s4": 1e-3, "order": "radial_first"})"),
      camera_with_lens("fov", k_long_lens, R"({"omega": 0.9})"),
      camera_with_lens("division", k_long_lens, R"({"k": -0.1})"),
      camera_with_lens("unified", k_long_lens, R"({"alpha": 0.5, "beta": 1.1})"),
      camera_with_lens("dual", k_long_lens, R"({"transition": 0.5, "k1": 1e-3, "k2": 1e-3})"),
      camera_with_lens("orthographic", R"({"resolution": 0.1})"),
      camera_with_lens("equirectangular", R"({"horizontal_fov": 180, "vertical_fov": 90})"),
      camera(R"({"vertical_fov": 50})",
             R"({"look_at": {"eye": [1, 2, 3], "target": [4, 4, 4], "up": [0, 1, 1]}})"),
      camera(R"({"horizontal_fov": 60})",
             R"({"matrix": [[1, 0, 0, 5], [0, 0, 1, 6], [0, -1, 0, 7], [0, 0, 0, 1]],
                                              "convention": "opencv", "direction": "camera_to_world"})"),
      camera(R"({"fx": 9, "fy": 8, "cx": 3, "cy": 2})",
             R"({"quaternion": [0.6, 0, 0.8, 0], "translation": [1, 2, 3], "convention": "opengl",
                 "direction": "world_to_camera"})"),
  };
}

std::vector<Sample> samples() {
  std::vector<Sample> all;
  for (const Json& each : cameras()) {
    all.push_back({"camera.schema.json", each});
    all.push_back(all.back());
    all.back().document["near"] = 0.5;
  }
  Json scene = Json::parse(R"({
    "version": 1, "description": "a scene",
    "cloud": { "files": ["a.las", "b.las"], "partial": true, "radius": 0.5, "hits": "t", "color": "height", "color_depth": 16, "normals": "smooth", "surface": "blend", "max_level": 3,
               "material": { "type": "lambertian", "albedo": [0.1, 0.2, 0.3] } },
    "objects": [
      { "type": "sphere", "center": [1, 2, 3], "radius": 2,
        "material": { "type": "metal", "albedo": [0.1, 0.2, 0.3], "roughness": 0.3 } },
      { "type": "sphere", "center": [1, 2, 3], "radius": 2, "material": { "type": "dielectric", "refractive_index": 1.3 } },
      { "type": "sphere", "center": [1, 2, 3], "radius": 2, "material": { "type": "emissive", "radiance": [1, 2, 3] } },
      { "type": "ground_plane", "height": 3, "material": { "type": "lambertian", "albedo": [0.1, 0.2, 0.3] } },
      { "type": "mesh", "file": "a.ply", "scale": 2, "rotate_z": 30, "translate": [1, 2, 3],
        "material": { "type": "metal", "albedo": [0.1, 0.2, 0.3], "roughness": 0.3 } },
      { "type": "mesh", "file": "a.obj", "material": { "type": "lambertian", "albedo": [0.1, 0.2, 0.3] } } ],
    "sky": { "type": "gradient", "horizon": [0.1, 0.2, 0.3], "zenith": [0.1, 0.2, 0.3] },
    "sun": { "azimuth": 1, "elevation": 2, "irradiance": [1, 2, 3], "angular_diameter": 1 },
    "render": { "samples": 3, "max_bounces": 4, "seed": 5 },
    "output": { "file": "a.exr", "layers": ["depth", "id"], "exposure": 1, "precision": "float",
                "transparent": true } })");
  scene["camera"] = cameras()[8];  // a pinhole
  scene["camera"].erase("version");
  all.push_back({"scene.schema.json", scene});
  scene["cloud"] = Json::parse(R"({"file": "a.las", "radius": "auto",
    "color": {"by": "gps_time", "map": "turbo", "range": [1, 2.5], "percentiles": [3, 95],
              "classes": [{"class": 6, "color": "#a0B1c2", "name": "House"}]}, "material": {"type": "metal",
    "albedo": [0.1, 0.2, 0.3], "roughness": 0.5}})");
  scene["cloud"]["radius"] = Json::parse(R"({"neighbours": 12, "factor": 1.5, "max": 0.5})");
  scene["sky"] = Json::parse(R"({"type": "constant", "radiance": [1, 2, 3]})");
  scene["camera"] = cameras().back();
  all.push_back({"scene.schema.json", scene});
  scene["sky"] = Json::parse(R"({"type": "image", "file": "sky.exr", "scale": 2, "rotation": 90})");
  scene["sun"] =
      Json::parse(R"({"date_time": "2003-10-17T12:30:30.5-07:00", "latitude": 39.7, "longitude": -105.2,
    "height": 1830, "pressure": 820, "temperature": 11, "irradiance": [1, 2, 3], "angular_diameter": 1})");
  scene["render"] = Json::parse(R"({"mode": "ambient_occlusion", "ao_distance": 2.5})");
  all.push_back({"scene.schema.json", scene});
  // Kinds of materials that nothing above has.
  for (const char* material : {R"({"type": "dielectric", "refractive_index": 1.3})",
                               R"({"type": "emissive", "radiance": [1, 2, 3]})"})
    all.push_back({"scene.schema.json",
                   {{"version", 1}, {"cloud", {{"file", "a.las"}, {"material", Json::parse(material)}}}}});
  return all;
}

/// What the reader makes of a document, or the error. Scenes and cameras give comparable texts.
struct Reading {
  std::optional<std::string> description;
  Error::Parts error;
};

Reading read(const Sample& sample) {
  try {
    const std::string text = sample.document.dump();
    return {sample.schema == "scene.schema.json" ? describe(parse_scene(text, "none/scene.json"))
                                                 : describe(parse_camera(text, "none/camera.json")),
            {}};
  } catch (const Error& error) {
    return {{}, error.parts()};
  }
}

/// Rules about several values at once, which JSON Schema has no words for.
bool is_beyond_schema(const Error::Parts& error) {
  constexpr const char* beginnings[] = {"the rotation is",
                                        "the transform is not rigid",
                                        "the quaternion is not normalized",
                                        "look_at: ",
                                        "no such file",
                                        "the distortion folds over",
                                        "empty range",
                                        "duplicate class"};
  return std::ranges::any_of(beginnings, [&](const char* text) { return error.problem.starts_with(text); });
}

void expect_agreement(const SchemaValidator& validator, const Sample& sample) {
  const bool valid = validator.validate(sample.schema, sample.document).has_value();
  const Reading reading = read(sample);
  if (valid && !reading.description && is_beyond_schema(reading.error)) return;
  EXPECT_EQ(valid, reading.description.has_value())
      << (valid ? "schema accepts, reader does not: " : "reader accepts, schema does not: ")
      << Error(reading.error).what() << "\n"
      << sample.document.dump();
}

/// Pointers of all values of a document.
std::vector<Json::json_pointer> pointers(const Json& document) {
  std::vector<Json::json_pointer> all;
  const std::function<void(const Json&, const Json::json_pointer&)> visit =
      [&](const Json& value, const Json::json_pointer& pointer) {
        all.push_back(pointer);
        if (value.is_object()) {
          for (const auto& [key, member] : value.items()) visit(member, pointer / key);
        }
        for (std::size_t i = 0; value.is_array() && i < value.size(); ++i) visit(value[i], pointer / i);
      };
  visit(document, Json::json_pointer());
  return all;
}

class SceneSchemaTest : public ::testing::Test {
 protected:
  SchemaValidator validator_{k_scenes / "schema"};
};

/// On one line, as people write JSON.
std::string line_of(const alidade::Json& value) {
  if (!value.is_structured() || value.empty()) return value.dump();
  std::string line;
  for (const auto& [key, member] : value.items()) {
    if (!line.empty()) line += ", ";
    if (value.is_object()) line += alidade::Json(key).dump() + ": ";
    line += line_of(member);
  }
  return value.is_array() ? "[" + line + "]" : "{ " + line + " }";
}

/// On one line where that is short, else with a line for each member.
std::string lines_of(const alidade::Json& value, const std::string& indent = "") {
  constexpr std::size_t k_longest_line = 110;
  const std::string line = line_of(value);
  if (!value.is_structured() || indent.size() + line.size() <= k_longest_line) return line;
  std::string lines;
  for (const auto& [key, member] : value.items()) {
    lines += (lines.empty() ? "\n  " : ",\n  ") + indent;
    if (value.is_object()) lines += alidade::Json(key).dump() + ": ";
    lines += lines_of(member, indent + "  ");
  }
  return (value.is_array() ? "[" : "{") + lines + "\n" + indent + (value.is_array() ? "]" : "}");
}

TEST_F(SceneSchemaTest, the_schema_of_scenes_is_that_of_the_forms) {
  const std::filesystem::path file = k_scenes / "schema/scene.schema.json";
  const std::string expected = lines_of(scene_form().schema) + "\n";
  if (std::getenv("ALIDADE_WRITE_SCHEMA") != nullptr) std::ofstream(file) << expected;
  EXPECT_EQ(read_text_file(file), expected) << "run this test with ALIDADE_WRITE_SCHEMA=1, then "
                                               "tests/support/scene_tables.py --write";
}

TEST_F(SceneSchemaTest, a_scene_is_written_as_it_is_read) {
  for (const Sample& sample : samples()) {
    if (sample.schema != "scene.schema.json") continue;
    const Scene scene = parse_scene(sample.document.dump(), "none/scene.json");
    const std::string text = scene_form().write(scene).dump();
    EXPECT_TRUE(validator_.validate(sample.schema, Json::parse(text))) << text;
    EXPECT_EQ(describe(parse_scene(text, "scene.json")), describe(scene)) << text;
  }
}

TEST_F(SceneSchemaTest, reader_and_schema_accept_documents_that_use_every_key) {
  std::set<const Json*> used;
  for (const Sample& sample : samples()) {
    const auto applied = validator_.validate(sample.schema, sample.document);
    ASSERT_TRUE(applied) << sample.document.dump(1);
    for (const auto& each : *applied) used.insert(each.schema);
    EXPECT_TRUE(read(sample).description) << Error(read(sample).error).what();
  }
  for (const auto& [id, document] : validator_.documents()) {
    for (const auto& pointer : pointers(document)) {
      if (pointer.empty() || pointer.back() != "properties") continue;
      for (const auto& [key, property] : document.at(pointer).items()) {
        EXPECT_TRUE(used.contains(&document.at(pointer / key))) << id << pointer.to_string() << "/" << key;
      }
    }
  }
}

void add_keys(const Json& schema, std::set<std::string>& keys) {
  if (!schema.contains("properties")) return;
  for (const auto& [key, property] : schema.at("properties").items()) keys.insert(key);
}

std::set<std::string> quoted_words(const std::string& text) {
  std::set<std::string> words;
  for (std::size_t open = text.find('"'); open != std::string::npos;) {
    const std::size_t close = text.find('"', open + 1);
    words.insert(text.substr(open + 1, close - open - 1));
    open = text.find('"', close + 1);
  }
  return words;
}

// The message about an unknown key lists the keys that the reader accepts in this object.
TEST_F(SceneSchemaTest, reader_accepts_exactly_the_keys_of_the_schema) {
  for (const Sample& sample : samples()) {
    const auto applied = validator_.validate(sample.schema, sample.document).value();
    for (const auto& pointer : pointers(sample.document)) {
      if (!sample.document.at(pointer).is_object()) continue;
      std::set<std::string> here, all;  // of the alternative that holds, of all alternatives
      for (const auto& each : applied) {
        if (each.pointer != pointer) continue;
        add_keys(*each.schema, here);
        add_keys(*each.schema, all);
        if (!each.schema->contains("oneOf")) continue;
        for (const Json& alternative : each.schema->at("oneOf"))
          add_keys(validator_.resolved(alternative), all);
      }
      Sample changed = sample;
      changed.document[pointer]["qqqqqqqqqqqq"] = 1;
      const Error::Parts error = read(changed).error;
      ASSERT_TRUE(error.problem.starts_with("unknown key (at ")) << error.problem;
      const std::set<std::string> known = quoted_words(error.expected);
      for (const std::string& key : known)
        EXPECT_TRUE(all.contains(key)) << pointer.to_string() << ": " << key;
      for (const std::string& key : here)
        EXPECT_TRUE(known.contains(key)) << pointer.to_string() << ": " << key;
    }
  }
}

TEST_F(SceneSchemaTest, leaving_a_key_out_means_the_default_in_the_schema) {
  // What has no default: texts for people, what a scene may do without, and what follows from other keys.
  const std::set<std::string> without_default{"version", "description", "cloud", "sun",    "camera", "file",
                                              "files",   "albedo",      "name",  "factor", "surface"};
  int count = 0;
  for (const Sample& sample : samples()) {
    const auto applied = validator_.validate(sample.schema, sample.document).value();
    for (const auto& each : applied) {
      if (each.pointer.empty() || !each.schema->contains("default")) continue;
      ++count;
      Sample left_out = sample, written_out = sample;
      left_out.document.at(each.pointer.parent_pointer()).erase(each.pointer.back());
      written_out.document[each.pointer] = each.schema->at("default");
      EXPECT_TRUE(validator_.validate(sample.schema, written_out.document)) << each.pointer.to_string();
      ASSERT_TRUE(read(left_out).description) << Error(read(left_out).error).what();
      EXPECT_EQ(read(left_out).description, read(written_out).description) << each.pointer.to_string();
    }
    for (const auto& pointer : pointers(sample.document)) {
      if (pointer.empty() || !sample.document.at(pointer.parent_pointer()).is_object()) continue;
      Sample left_out = sample;
      left_out.document.at(pointer.parent_pointer()).erase(pointer.back());
      if (!read(left_out).description || without_default.contains(pointer.back())) continue;
      const bool has_default = std::ranges::any_of(applied, [&](const auto& each) {
        return each.pointer == pointer && each.schema->contains("default");
      });
      EXPECT_TRUE(has_default) << pointer.to_string() << " is optional but the schema has no default";
    }
  }
  EXPECT_GT(count, 30);
}

TEST_F(SceneSchemaTest, reader_and_schema_agree_at_the_limits_of_every_number) {
  int count = 0;
  for (const Sample& sample : samples()) {
    const auto applied = validator_.validate(sample.schema, sample.document).value();
    for (const auto& each : applied) {
      for (const std::string limit : {"minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"}) {
        if (!each.schema->contains(limit)) continue;
        ++count;
        const Json at = each.schema->at(limit);
        std::vector<Json> probes{at};
        if (at.is_number_unsigned() && at.get<std::uint64_t>() < UINT64_MAX)
          probes.push_back(at.get<std::uint64_t>() + 1);
        if (at.is_number_unsigned() && at.get<std::uint64_t>() > 0)
          probes.push_back(at.get<std::uint64_t>() - 1);
        probes.push_back(std::nextafter(at.get<double>(), -INFINITY));
        probes.push_back(std::nextafter(at.get<double>(), INFINITY));
        for (const Json& probe : probes) {
          Sample changed = sample;
          changed.document[each.pointer] = probe;
          expect_agreement(validator_, changed);
        }
      }
    }
  }
  EXPECT_GT(count, 100);
}

TEST_F(SceneSchemaTest, reader_and_schema_agree_on_small_changes_everywhere) {
  const Json replacements = Json::parse(
      R"([null, true, false, -1, 0, 0.5, 1, 1.0, 2, 16.0, 1e300, -1e300, "", "x", "x.png", "x.PNG", "x.Jpeg", "x.jpegg", "x.tif", "x.TIFF", "x.tifff", ".exr",
    "auto", "entry", "sphere", "metal", "constant", "flat", "2024-02-29T12:00Z", "2024-02-28T12:00:00+01:00",
    "2024-02-28T12:00", "2024-02-28T12:00:00.Z", "1599-12-31T12:00Z", "2024-02-28T24:00Z",
    {"date_time": "2024-02-28T12:00Z"}, {"date_time": "2024-02-28T12:00Z", "azimuth": 1}, {"latitude": 1},
    {"date_time": "2024-02-28T12:00Z", "latitude": 1}, {"type": "image"}, {"type": "image", "file": "a.exr"}, [], {}, [1], ["id"], ["id", "id"], [1, 1, 1], [0.5, 0.5, 0.5],
    [0.5, 0.5, 0.5, 0.5], [1, 1, "1"], [[1, 1, 1]], {"type": "emissive"}, {"type": "sphere"}, {"type": "metal"},
    {"file": "a"}, {"file": "a", "files": ["a"]}, {"vertical_fov": 1}, {"vertical_fov": 1, "fx": 1}])");
  int count = 0;
  for (const Sample& sample : samples()) {
    for (const auto& pointer : pointers(sample.document)) {
      std::vector<Sample> changes;
      for (const Json& replacement : replacements) {
        changes.push_back(sample);
        changes.back().document[pointer] = replacement;
      }
      if (!pointer.empty()) {
        Json& parent = changes.emplace_back(sample).document.at(pointer.parent_pointer());
        if (parent.is_object())
          parent.erase(pointer.back());
        else
          parent.erase(parent.size() - 1);
      }
      if (sample.document.at(pointer).is_array()) {
        Json& array = changes.emplace_back(sample).document.at(pointer);
        array.push_back(array.front());
      }
      count += static_cast<int>(changes.size());
      for (const Sample& changed : changes) expect_agreement(validator_, changed);
    }
  }
  EXPECT_GT(count, 5000);
}

TEST_F(SceneSchemaTest, all_scenes_here_are_valid_and_read) {
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(k_scenes)) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(".json") || name.ends_with(".schema.json")) continue;
    ++count;
    const bool is_camera = name.ends_with(".camera.json");
    std::ifstream stream(entry.path());
    EXPECT_TRUE(
        validator_.validate(is_camera ? "camera.schema.json" : "scene.schema.json", Json::parse(stream)))
        << name;
    if (is_camera)
      EXPECT_NO_THROW(read_camera(entry.path()));
    else
      EXPECT_NO_THROW(read_scene(entry.path()));
  }
  EXPECT_GE(count, 8);
}

std::string manual_text(const char* page) {
  std::ifstream stream(std::filesystem::path(ALIDADE_SOURCE_FOLDER) / "docs" / page);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void expect_examples(const SchemaValidator& validator, const char* page, const std::string& schema) {
  const std::string manual = manual_text(page);
  int count = 0;
  for (std::size_t begin = manual.find("```json\n"); begin != std::string::npos;
       begin = manual.find("```json\n", begin + 8), ++count) {
    const Sample example{schema,
                         Json::parse(manual.substr(begin + 8, manual.find("```", begin + 8) - begin - 8))};
    EXPECT_TRUE(validator.validate(example.schema, example.document));
    EXPECT_TRUE(read(example).description);
  }
  EXPECT_GE(count, 1) << page;
}

TEST_F(SceneSchemaTest, the_manuals_examples_are_valid_and_read) {
  expect_examples(validator_, "scene_format.md", "scene.schema.json");
  expect_examples(validator_, "cameras.md", "camera.schema.json");
}

TEST_F(SceneSchemaTest, the_manual_explains_every_key_and_word_of_the_schemas) {
  const std::string manual = manual_text("scene_format.md") + manual_text("cameras.md");
  for (const auto& [id, document] : validator_.documents()) {
    for (const auto& pointer : pointers(document)) {
      if (pointer.empty()) continue;
      std::vector<std::string> words;
      if (pointer.back() == "properties") {
        for (const auto& [key, property] : document.at(pointer).items()) words.push_back(key);
      }
      if (pointer.back() == "enum") {
        for (const Json& word : document.at(pointer))
          words.push_back(word.is_string() ? word.get<std::string>() : word.dump());
      }
      if (pointer.back() == "const" && document.at(pointer).is_string())
        words.push_back(document.at(pointer));
      for (const std::string& word : words) {
        const bool explained = manual.find("`" + word + "`") != std::string::npos ||
                               manual.find("`\"" + word + "\"`") != std::string::npos;
        EXPECT_TRUE(explained) << word;
      }
    }
  }
}

}  // namespace
}  // namespace alidade::test
