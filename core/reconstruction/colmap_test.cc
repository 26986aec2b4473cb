#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/reconstruction/colmap_model.h"
#include "core/reconstruction/test_colmap.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;

ColmapModel small_model() {
  ColmapModel model;
  model.cameras = {{1, 512, 256.0}, {7, 384, 192.0}};
  model.images = {
      {3, 1, "front/a b.png", {Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {0.1, -2, 3}}, {}},
      {4, 7, "front/c.png", {Eigen::Quaterniond::Identity(), {0, 0, 1.0 / 3.0}}, {}}};
  model.images[0].features = {{{10.25, 20.5}, 9}, {{300.0, 400.0}, kNoPoint}};
  model.images[1].features = {{{11.0, 21.0}, 9}};
  model.points = {{.id = 9, .position = {0.5, -1.5, 2.5}, .track = {{3, 0}, {4, 0}}}};
  return model;
}

// Without the flush to disk of write_file_atomically, as hundreds of files are written.
void write_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

TEST(ColmapModel, ReadsWhatItWrote) {
  const TestDirectory directory;
  write_colmap_model(directory.path(), small_model());
  const ColmapModel model = read_colmap_model(directory.path());
  ASSERT_EQ(model.images.size(), 2U);
  EXPECT_EQ(model.images[0].id, 3U);
  EXPECT_EQ(model.images[0].camera, 1U);
  EXPECT_EQ(model.images[0].name, "front/a b.png");
  EXPECT_EQ(model.images[0].pose.rotation.coeffs(), Eigen::Vector4d(-0.5, 0.5, 0.5, 0.5));
  EXPECT_EQ(model.images[0].pose.translation, Eigen::Vector3d(0.1, -2, 3));
  ASSERT_EQ(model.images[0].features.size(), 2U);
  EXPECT_EQ(model.images[0].features[0].pixel.y, 20.5);
  EXPECT_EQ(model.images[0].features[1].point, kNoPoint);
  ASSERT_EQ(model.points.size(), 1U);
  EXPECT_EQ(model.points[0].id, 9U);
  EXPECT_EQ(model.points[0].position, Eigen::Vector3d(0.5, -1.5, 2.5));
  ASSERT_EQ(model.points[0].track.size(), 2U);
  EXPECT_EQ(model.points[0].track[1].image, 4U);
}

// The documented layout, byte by byte, for one image: id, qw qx qy qz, tx ty tz, camera, name.
TEST(ColmapModel, WritesTheDocumentedLayout) {
  const TestDirectory directory;
  write_colmap_model(directory.path(), small_model());
  std::string bytes = read_file(directory / "images.bin");
  const auto number = [&](std::size_t at) {
    double value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof(value));
    return value;
  };
  EXPECT_EQ(bytes[0], 2);       // images
  EXPECT_EQ(bytes[8], 3);       // id
  EXPECT_EQ(number(12), 0.5);   // qw comes first
  EXPECT_EQ(number(20), -0.5);  // qx
  EXPECT_EQ(number(44), 0.1);   // tx
  EXPECT_EQ(bytes[68], 1);      // camera
  EXPECT_EQ(bytes.substr(72, 14), std::string("front/a b.png\0", 14));
  bytes = read_file(directory / "cameras.bin");
  EXPECT_EQ(bytes[12], 1);  // PINHOLE
  EXPECT_EQ(bytes.substr(16, 2), std::string("\0\2", 2)) << "512 pixels wide";
  EXPECT_EQ(number(32), 256.0) << "focal length";
  EXPECT_EQ(number(48), 256.0) << "principal point";
}

TEST(ColmapModel, RefusesTruncatedFiles) {
  const TestDirectory directory;
  write_colmap_model(directory.path(), small_model());
  for (const std::string name : {"images.bin", "points3D.bin"}) {
    const std::string whole = read_file(directory / name);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      write_bytes(directory / name, whole.substr(0, size));
      EXPECT_THAT(error_of([&] { read_colmap_model(directory.path()); }), HasSubstr(name)) << size;
    }
    write_bytes(directory / name, whole + "x");
    EXPECT_THAT(error_of([&] { read_colmap_model(directory.path()); }), HasSubstr("left over"));
    write_bytes(directory / name, whole);
  }
  EXPECT_NO_THROW(read_colmap_model(directory.path()));
}

// With any changed byte, reading gives a model or an Error, never a crash or an unbounded
// allocation.
TEST(ColmapModel, SurvivesAnyDamagedByte) {
  const TestDirectory directory;
  write_colmap_model(directory.path(), small_model());
  for (const std::string name : {"images.bin", "points3D.bin"}) {
    const std::string whole = read_file(directory / name);
    int refused = 0;
    for (std::size_t at = 0; at < whole.size(); ++at) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ 0xFF);
      write_bytes(directory / name, damaged);
      const std::string error = error_of([&] { read_colmap_model(directory.path()); });
      if (error == "no error") continue;
      EXPECT_THAT(error, HasSubstr(directory.path().string())) << at;
      ++refused;
    }
    EXPECT_GT(refused, 0) << name;  // the number of records at least
    write_bytes(directory / name, whole);
  }
}

TEST(ColmapModel, RefusesTracksOfFeaturesThatDoNotExist) {
  const TestDirectory directory;
  ColmapModel model = small_model();
  model.points[0].track[1].feature = 1;
  write_colmap_model(directory.path(), model);
  EXPECT_THAT(error_of([&] { read_colmap_model(directory.path()); }),
              HasSubstr("a feature that does not exist"));
  model.points[0].track[1] = {99, 0};
  write_colmap_model(directory.path(), model);
  EXPECT_THAT(error_of([&] { read_colmap_model(directory.path()); }),
              HasSubstr("a feature that does not exist"));
}

void expect_poses_of_two(const std::vector<ColmapImage>& images) {
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
  write_colmap_model(directory.path(), small_model());
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
  write_colmap_model(directory.path(), small_model());  // cameras.bin, of pinholes
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
  write_colmap_model(directory.path(), small_model());
  const std::string whole = read_file(directory / "images.bin");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_THAT(error_of([&] { colmap_images_of_bytes(whole.substr(0, size), "images.bin"); }),
                HasSubstr("cut short"));
  }
}

}  // namespace
}  // namespace raywalk
