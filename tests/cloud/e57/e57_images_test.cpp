// SPDX-License-Identifier: MIT
#include "cloud/e57/e57_file.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/e57/e57_builder.h"

namespace alidade {
namespace {

using test::E57Builder;
using test::error_of;

const std::string k_jpeg = "\xFF\xD8\xFF" + std::string(3000, 'j');
const std::string k_png = std::string("\x89PNG\r\n\x1a\n", 8) + std::string(10, 'p');

std::string representation(const std::string& name, const std::string& blobs, const std::string& numbers) {
  return "<" + name + " type=\"Structure\">" + blobs +
         "<imageWidth type=\"Integer\">40</imageWidth><imageHeight type=\"Integer\">20</imageHeight>" +
         numbers + "</" + name + ">";
}

E57File open(const std::string& file) {
  return E57File(InputFile(std::as_bytes(std::span(file)), "memory"));
}

std::string bytes_of(E57File& file, const E57Blob& blob) {
  std::string text;
  file.read_blob(blob, [&](std::span<const std::byte> bytes) {
    text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  });
  return text;
}

TEST(E57Images, of_every_projection_with_pose_and_bytes) {
  E57Builder builder;
  const std::string jpeg = "<jpegImage" + builder.add_blob(k_jpeg) + "/>",
                    png = "<pngImage" + builder.add_blob(k_png) + "/>";
  const std::string mask = "<imageMask" + builder.add_blob(k_png) + "/>";
  builder.add_image(
      "<name type=\"String\">north</name><guid type=\"String\">{1}</guid>"
      "<associatedData3DGuid type=\"String\">{scan}</associatedData3DGuid>" +
      test::pose_element("1 0 0 0", "5 6 7") + representation("visualReferenceRepresentation", png, "") +
      representation(
          "pinholeRepresentation", jpeg + mask,
          "<focalLength type=\"Float\">0.02</focalLength><pixelWidth type=\"Float\">1e-5</pixelWidth>"
          "<pixelHeight type=\"Float\">2e-5</pixelHeight><principalPointX type=\"Float\">19.5"
          "</principalPointX><principalPointY type=\"Float\">10</principalPointY>"));
  builder.add_image(
      representation("sphericalRepresentation", "<pngImage" + builder.add_blob(k_jpeg) + "/>", "") +
      representation("cylindricalRepresentation", "<pngImage" + builder.add_blob("?") + "/>",
                     "<readius type=\"Float\">3</readius>"));
  const std::string text = builder.file();
  E57File file = open(text);
  const std::vector<E57Image>& images = file.document().images;
  ASSERT_EQ(images.size(), 2u);
  EXPECT_EQ(images[0].name, "north");
  EXPECT_EQ(images[0].guid, "{1}");
  EXPECT_EQ(images[0].scan_guid, "{scan}");
  EXPECT_EQ(images[0].pose->translation, glm::dvec3(5, 6, 7));
  ASSERT_EQ(images[0].representations.size(), 2u);
  const E57Representation& pinhole = images[0].representations[1];
  EXPECT_EQ(pinhole.projection, E57Projection::pinhole);
  EXPECT_EQ(pinhole.width, 40u);
  EXPECT_EQ(pinhole.height, 20u);
  EXPECT_EQ(pinhole.focal_length, 0.02);
  EXPECT_EQ(pinhole.pixel_height, 2e-5);
  EXPECT_EQ(pinhole.principal_x, 19.5);
  EXPECT_EQ(pinhole.extension, "jpg");
  EXPECT_EQ(bytes_of(file, pinhole.blob), k_jpeg) << "across pages";
  EXPECT_EQ(bytes_of(file, *pinhole.mask), k_png);
  EXPECT_EQ(images[0].representations[0].extension, "png");
  ASSERT_EQ(images[1].representations.size(), 2u);
  EXPECT_EQ(images[1].representations[0].extension, "jpg") << "by its bytes, not by its element";
  EXPECT_NEAR(images[1].representations[0].pixel_width, 2 * 3.14159265358979 / 40, 1e-12)
      << "the whole sphere";
  EXPECT_EQ(images[1].representations[1].extension, "bin");
  EXPECT_EQ(images[1].representations[1].radius, 3.0) << "misspelt by a writer";
  EXPECT_FALSE(images[1].pose.has_value());
}

TEST(E57Images, that_leave_the_file_are_errors) {
  const auto error = [](const std::string& attributes) {
    E57Builder builder;
    builder.add_blob(k_jpeg);
    builder.add_image(representation("pinholeRepresentation", "<jpegImage " + attributes + "/>", ""));
    const std::string file = builder.file();
    return error_of([&] { open(file); });
  };
  EXPECT_NE(error("fileOffset=\"48\" length=\"999999\"")
                .find("image 1: invalid length of \"jpegImage\"; expected at most"),
            std::string::npos);
  EXPECT_NE(error("fileOffset=\"48\" length=\"3100\"").find("invalid length of"), std::string::npos);
  EXPECT_NE(error("fileOffset=\"999999\" length=\"1\"")
                .find("image 1: invalid offset of the jpegImage; expected less than"),
            std::string::npos);
  EXPECT_NE(error("length=\"1\"").find("invalid fileOffset of"), std::string::npos);
  EXPECT_NE(error("fileOffset=\"64\" length=\"1\"").find("wrong section id of"), std::string::npos);
}

TEST(E57Images, that_are_together_larger_than_the_file_are_an_error) {
  E57Builder builder;
  const std::string picture = "<jpegImage" + builder.add_blob(k_jpeg) + "/>";
  for (int i = 0; i < 1000; ++i) builder.add_image(representation("pinholeRepresentation", picture, ""));
  const std::string file = builder.file();
  EXPECT_NE(error_of([&] { open(file); }).find("the images exceed the file"), std::string::npos);
}

}  // namespace
}  // namespace alidade
