// SPDX-License-Identifier: MIT
#include "camera/formats/e57.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "base/error.h"
#include "camera/projection.h"
#include "tests/cloud/e57/e57_builder.h"

namespace alidade {

using namespace camera;

namespace {

E57Image posed() {
  E57Image image;
  // A turn that takes x to y, y to z and z to x.
  image.pose =
      E57Pose{.rotation = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, .translation = {10, 20, 30}, .is_rotated = true};
  return image;
}

E57Representation pinhole() {
  E57Representation representation;
  representation.projection = E57Projection::pinhole;
  representation.width = 400;
  representation.height = 300;
  representation.focal_length = 0.02;
  representation.pixel_width = 1e-4;
  representation.pixel_height = 2e-4;
  representation.principal_x = 210.5;
  representation.principal_y = 140.25;
  return representation;
}

TEST(E57Camera, pinhole_looks_along_minus_z_with_y_up) {
  const E57Image image = posed();
  const std::optional<Camera> camera = camera_of(image, pinhole());
  ASSERT_TRUE(camera);
  check_camera(*camera);
  const Projection projection(*camera);
  for (const glm::dvec3 position :
       {glm::dvec3(0.3, 0.2, -2), glm::dvec3(-1, 0.5, -4), glm::dvec3(0, 0, -1)}) {
    const glm::dvec3 world = image.pose->rotation * position + image.pose->translation;
    const auto film = projection.project(world);
    ASSERT_TRUE(film);
    // u = cx - (x / z) f / w, v = cy + (y / z) f / h.
    EXPECT_NEAR(film->x, 210.5 - position.x / position.z * 0.02 / 1e-4, 1e-9);
    EXPECT_NEAR(film->y, 140.25 + position.y / position.z * 0.02 / 2e-4, 1e-9);
  }
}

TEST(E57Camera, spherical_looks_along_x_with_azimuth_growing_to_the_left) {
  const E57Image image = posed();
  E57Representation representation;
  representation.projection = E57Projection::spherical;
  representation.width = 360;
  representation.height = 180;
  representation.pixel_width = representation.pixel_height = std::numbers::pi / 180;
  const std::optional<Camera> camera = camera_of(image, representation);
  ASSERT_TRUE(camera);
  check_camera(*camera);
  const Projection projection(*camera);
  const auto film_of = [&](double azimuth, double elevation) {
    const double a = azimuth * std::numbers::pi / 180, e = elevation * std::numbers::pi / 180;
    const glm::dvec3 position(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
    return *projection.project(image.pose->rotation * (5.0 * position) + image.pose->translation);
  };
  EXPECT_NEAR(film_of(0, 0).x, 180, 1e-9);
  EXPECT_NEAR(film_of(0, 0).y, 90, 1e-9);
  EXPECT_NEAR(film_of(30, 0).x, 150, 1e-9);
  EXPECT_NEAR(film_of(-30, 40).x, 210, 1e-9);
  EXPECT_NEAR(film_of(-30, 40).y, 50, 1e-9);
}

TEST(E57Camera, of_other_images_and_impossible_numbers_is_empty) {
  E57Representation representation = pinhole();
  representation.pixel_width = 0;
  EXPECT_FALSE(camera_of({}, representation));
  representation = pinhole();
  representation.focal_length = -1;
  EXPECT_FALSE(camera_of({}, representation));
  representation = pinhole();
  representation.width = 0;
  EXPECT_FALSE(camera_of({}, representation));
  representation.width = std::uint64_t{1} << 40;
  EXPECT_FALSE(camera_of({}, representation));
  for (const E57Projection projection : {E57Projection::visual, E57Projection::cylindrical}) {
    representation = pinhole();
    representation.projection = projection;
    EXPECT_FALSE(camera_of({}, representation));
  }
}

TEST(E57Camera, without_a_pose_is_in_the_axes_of_the_file) {
  const std::optional<Camera> camera = camera_of({}, pinhole());
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->pose.position, glm::dvec3(0));
  EXPECT_EQ(camera->pose.forward, glm::dvec3(0, 0, -1));
}

E57Image image_of(const std::string& name, const std::vector<E57Representation>& representations) {
  E57Image image = posed();
  image.name = name;
  image.representations = representations;
  return image;
}

TEST(E57Camera, photos_have_the_names_of_their_images_made_unique) {
  E57Document document;
  document.images = {image_of("north", {pinhole(), E57Representation{}}), image_of("north_2", {pinhole()}),
                     image_of("north", {pinhole()}), image_of("", {pinhole()}), image_of("", {pinhole()})};
  document.images[3].guid = "{7}";
  document.images[4].pose.reset();
  std::vector<std::string> warnings;
  const std::vector<E57Photo> photos = e57_photos(document, warnings);
  std::vector<std::string> names;
  for (const E57Photo& photo : photos) names.push_back(photo.camera.name);
  EXPECT_EQ(names, (std::vector<std::string>{"north", "north_2", "north_3", "{7}", "image 5"}));
  EXPECT_EQ(photos[0].camera.camera.pose.position, glm::dvec3(10, 20, 30));
  EXPECT_EQ(warnings, (std::vector<std::string>{"skipped 1 of 6 images without a camera: visual references, "
                                                "cylindrical images, invalid sizes",
                                                "1 of 5 photos have no pose: using the axes of the file"}));
}

TEST(E57Camera, an_e57_file_is_a_camera_file_if_it_has_photos) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("alidade_e57_cameras_" + std::to_string(::getpid()) + ".e57");
  const auto read = [&](const test::E57Builder& builder) {
    std::ofstream(file, std::ios::binary) << builder.file();
    return read_cameras(file);
  };
  test::E57Builder builder;
  EXPECT_THROW(read(builder), Error);
  for (const char* const name : {"west", "east"}) {
    builder.add_image(
        "<name type=\"String\">" + std::string(name) + "</name>" + test::pose_element("1 0 0 0", "1 2 3") +
        "<sphericalRepresentation type=\"Structure\"><jpegImage" + builder.add_blob("\xFF\xD8\xFF") +
        "/><imageWidth type=\"Integer\">360</imageWidth><imageHeight "
        "type=\"Integer\">180</imageHeight><pixelWidth type=\"Float\">0.0174532925</pixelWidth>"
        "<pixelHeight type=\"Float\">0.0174532925</pixelHeight></sphericalRepresentation>");
  }
  const CameraSet set = read(builder);
  std::filesystem::remove(file);
  ASSERT_EQ(set.cameras.size(), 2u);
  EXPECT_EQ(set.cameras[0].name, "east");
  EXPECT_EQ(set.cameras[0].camera.width, 360);
  EXPECT_EQ(set.cameras[0].camera.pose.position, glm::dvec3(1, 2, 3));
  EXPECT_TRUE(set.warnings.empty());
}

}  // namespace
}  // namespace alidade
