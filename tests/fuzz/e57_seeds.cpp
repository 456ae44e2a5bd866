// SPDX-License-Identifier: MIT
// e57_seeds FOLDER: small E57 files with every kind of field, section and image as a start for fuzz_e57.
#include <vector>

#include "tests/cloud/e57/e57_builder.h"
#include "tests/fuzz/write_seeds.h"

namespace {

using namespace alidade::test;

std::string cartesian() {
  E57Builder builder;
  builder.root = "<coordinateMetadata type=\"String\">PROJCS[\"a\"]</coordinateMetadata>";
  builder.add_scan(
      "<name type=\"String\">s</name>" + pose_element("0.8 0 0 0.6", "10 20 30") +
          "<intensityLimits type=\"Structure\"><intensityMinimum type=\"Float\"/><intensityMaximum "
          "type=\"Float\">2</intensityMaximum></intensityLimits>",
      {float64_column("cartesianX", {1, 2, 3}), float32_column("cartesianY", {1, 2, 3}),
       integer_column("cartesianZ", -1000, 1000, {-5, 0, 5}, " scale=\"0.001\" offset=\"2\""),
       integer_column("cartesianInvalidState", 0, 2, {0, 1, 0}), float32_column("intensity", {0, 1, 2}),
       integer_column("colorRed", 0, 255, {1, 2, 3}), integer_column("colorGreen", 0, 255, {1, 2, 3}),
       integer_column("colorBlue", 7, 7, {7, 7, 7}), float64_column("timeStamp", {0, 1, 2}),
       integer_column("rowIndex", 0, 9, {1, 2, 3}), integer_column("returnIndex", 0, 1, {0, 1, 0}),
       float32_column("nor:normalX", {1, 0, 0}), float32_column("nor:normalY", {0, 1, 0}),
       float32_column("nor:normalZ", {0, 0, 1})},
      7);
  return builder.file();
}

std::string spherical() {
  E57Builder builder;
  builder.add_scan("", {float64_column("sphericalRange", {1, 2}), float64_column("sphericalAzimuth", {0, 3}),
                        integer_column("sphericalElevation", 0, 1 << 20, {1, 1 << 19}, " scale=\"1e-6\""),
                        integer_column("sphericalInvalidState", 0, 2, {0, 0})});
  builder.add_scan(pose_element("", "1 1 1"),
                   {integer_column("cartesianX", 1, 1, {1, 1}), integer_column("cartesianY", 1, 2, {1, 2}),
                    integer_column("cartesianZ", 1, 1, {1, 1})});
  return builder.file();
}

std::string images() {
  E57Builder builder;
  const std::string png = "<pngImage" + builder.add_blob("\x89PNG\r\n\x1a\n....") + "/>";
  builder.add_image("<name type=\"String\">i</name>" + pose_element("1 0 0 0", "1 2 3") +
                    "<pinholeRepresentation type=\"Structure\">" + png +
                    "<imageWidth type=\"Integer\">4</imageWidth><focalLength type=\"Float\">0.1</focalLength>"
                    "</pinholeRepresentation><sphericalRepresentation type=\"Structure\">" +
                    png + "</sphericalRepresentation>");
  return builder.file();
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const std::vector<std::string> seeds = {cartesian(), spherical(), images()};
  return write_seeds(arguments[1], seeds);
}
