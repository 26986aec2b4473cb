#include "core/reconstruction/colmap_images.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/reconstruction/colmap_model.h"
#include "core/reconstruction/test_colmap.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;

ColmapModel model_of_two() {
  ColmapModel model;
  model.cameras = {{1, 512, 256.0}};
  model.images = {
      {3, 1, "front/a b.png", {Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {0.1, -2, 3}}, {}},
      {4, 1, "front/c.png", {Eigen::Quaterniond::Identity(), {0, 0, 1.0 / 3.0}}, {}}};
  model.images[0].features = {{{10.25, 20.5}, 9}, {{300.0, 400.0}, kNoPoint}};
  model.images[1].features = {{{11.0, 21.0}, 9}};
  model.points = {{.id = 9, .position = {0.5, -1.5, 2.5}, .track = {{3, 0}, {4, 0}}}};
  return model;
}

void expect_poses_of_two(const std::vector<ColmapImagePose>& images) {
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[0].name, "front/a b.png");
  EXPECT_EQ(images[0].pose.rotation.coeffs(), Eigen::Vector4d(-0.5, 0.5, 0.5, 0.5));
  EXPECT_EQ(images[0].pose.translation, Eigen::Vector3d(0.1, -2, 3));
  EXPECT_EQ(images[1].pose.translation.z(), 1.0 / 3.0);
}

TEST(ColmapImages, AreReadExactlyFromBinaryAndText) {
  const TestDirectory directory;
  write_file_atomically(directory / "images.txt",
                        "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n"
                        "3 0.5 -0.5 0.5 0.5 0.1 -2 3 1 front/a b.png\n10.25 20.5 9 300 400 -1\n"
                        "4 1 0 0 0 0 0 0.33333333333333331 1 front/c.png\n11 21 9\n");
  expect_poses_of_two(read_colmap_images(directory.path()));
  write_colmap_model(directory.path(), model_of_two());
  expect_poses_of_two(read_colmap_images(directory.path()));
}

TEST(ColmapImages, ArePanoramasOfAnEquirectangularCamera) {
  const TestDirectory directory;
  EXPECT_FALSE(images_are_panoramas(directory.path()));
  const std::string comment = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  write_file_atomically(directory / "cameras.txt", comment + "1 EQUIRECTANGULAR 64 32 64 32\n");
  EXPECT_TRUE(images_are_panoramas(directory.path()));
  write_file_atomically(directory / "cameras.txt", comment + "1 SIMPLE_PINHOLE 8 8 4 4 4\n");
  EXPECT_FALSE(images_are_panoramas(directory.path()));
  const std::string bytes = equirectangular_camera_bytes();
  write_file_atomically(directory / "cameras.bin", bytes);
  EXPECT_TRUE(images_are_panoramas(directory.path()));
  write_file_atomically(directory / "cameras.bin", bytes.substr(0, 15));
  EXPECT_THAT(error_of([&] { images_are_panoramas(directory.path()); }), HasSubstr("cut short"));
  write_colmap_model(directory.path(), model_of_two());  // cameras.bin, of pinholes
  EXPECT_FALSE(images_are_panoramas(directory.path()));
}

TEST(ColmapImages, OfAnotherFolderOrDamagedAreRefused) {
  const TestDirectory directory;
  EXPECT_THAT(error_of([&] { read_colmap_images(directory.path()); }), HasSubstr("images.bin"));
  EXPECT_THAT(error_of([] { colmap_images_of_text("# nothing\n", "images.txt"); }),
              HasSubstr("holds no image"));
  EXPECT_THAT(
      error_of([] { colmap_images_of_text("1 1 0 0 0 0 zero 0 1 a.png\n\n", "images.txt"); }),
      HasSubstr("images.txt:1: 'zero' is not a number"));
  EXPECT_THAT(error_of([] { colmap_images_of_text("1 0 0 0 0 0 0 0 1 a.png\n", "images.txt"); }),
              HasSubstr("not a quaternion"));
  const std::string image = "1 1 0 0 0 0 0 0 1 a.png\n\n";
  EXPECT_THAT(error_of([&] { colmap_images_of_text(image + image, "images.txt"); }),
              HasSubstr("'a.png' is there twice"));
  write_colmap_model(directory.path(), model_of_two());
  const std::string whole = read_file(directory / "images.bin");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_THAT(error_of([&] { colmap_images_of_bytes(whole.substr(0, size), "images.bin"); }),
                HasSubstr("cut short"));
  }
}

}  // namespace
}  // namespace raywalk
