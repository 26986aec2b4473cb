// Models of COLMAP and nerfstudio, and the faces of panoramas that COLMAP sees.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/files/atomic_output.h"
#include "core/files/test_support.h"
#include "core/reconstruction/colmap_model.h"
#include "core/reconstruction/colmap_pose.h"
#include "core/reconstruction/nerfstudio_file.h"
#include "core/reconstruction/panorama_faces.h"
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

class ColmapTest : public ::testing::Test {
 protected:
  void write(const ColmapModel& model = small_model()) const {
    write_colmap_model(directory_.path(), model);
  }
  std::string reading_error() const {
    return error_of([&] { read_colmap_model(directory_.path()); });
  }

  TestDirectory directory_;
};

// Of the small model.
void expect_poses_of_two(const std::vector<ColmapImage>& images) {
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[0].name, "front/a b.png");
  EXPECT_EQ(images[0].pose.rotation.coeffs(), Eigen::Vector4d(-0.5, 0.5, 0.5, 0.5));
  EXPECT_EQ(images[0].pose.translation, Eigen::Vector3d(0.1, -2, 3));
  EXPECT_EQ(images[1].pose.translation.z(), 1.0 / 3.0);
}

TEST_F(ColmapTest, ReadsWhatItWrote) {
  write();
  const ColmapModel model = read_colmap_model(directory_.path());
  expect_poses_of_two(model.images);
  EXPECT_EQ(model.images[0].id, 3U);
  EXPECT_EQ(model.images[0].camera, 1U);
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
TEST_F(ColmapTest, WritesTheDocumentedLayout) {
  write();
  std::string bytes = read_file(directory_ / "images.bin");
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
  bytes = read_file(directory_ / "cameras.bin");
  EXPECT_EQ(bytes[12], 1);  // PINHOLE
  EXPECT_EQ(bytes.substr(16, 2), std::string("\0\2", 2)) << "512 pixels wide";
  EXPECT_EQ(number(32), 256.0) << "focal length";
  EXPECT_EQ(number(48), 256.0) << "principal point";
}

TEST_F(ColmapTest, RefusesTruncatedFiles) {
  write();
  for (const std::string name : {"images.bin", "points3D.bin"}) {
    const std::string whole = read_file(directory_ / name);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      write_bytes(directory_ / name, whole.substr(0, size));
      EXPECT_THAT(reading_error(), HasSubstr(name)) << size;
    }
    write_bytes(directory_ / name, whole + "x");
    EXPECT_THAT(reading_error(), HasSubstr("left over"));
    write_bytes(directory_ / name, whole);
  }
  EXPECT_NO_THROW(read_colmap_model(directory_.path()));
}

// With any changed byte, reading gives a model or an Error, never a crash or an unbounded
// allocation.
TEST_F(ColmapTest, SurvivesAnyDamagedByte) {
  write();
  for (const std::string name : {"images.bin", "points3D.bin"}) {
    const std::string whole = read_file(directory_ / name);
    int refused = 0;
    for (std::size_t at = 0; at < whole.size(); ++at) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ 0xFF);
      write_bytes(directory_ / name, damaged);
      const std::string error = reading_error();
      if (error == "no error") continue;
      EXPECT_THAT(error, HasSubstr(directory_.path().string())) << at;
      ++refused;
    }
    EXPECT_GT(refused, 0) << name;  // the number of records at least
    write_bytes(directory_ / name, whole);
  }
}

TEST_F(ColmapTest, RefusesTracksOfFeaturesThatDoNotExist) {
  ColmapModel model = small_model();
  for (const ColmapTrackElement& wrong : {ColmapTrackElement{4, 1}, {99, 0}}) {
    model.points[0].track[1] = wrong;
    write(model);
    EXPECT_THAT(reading_error(), HasSubstr("a feature that does not exist"));
  }
}

TEST_F(ColmapTest, ImagesAreReadExactlyFromBinaryAndText) {
  write_file_atomically(directory_ / "images.txt",
                        "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n"
                        "3 0.5 -0.5 0.5 0.5 0.1 -2 3 1 front/a b.png\n10.25 20.5 9 300 400 -1\n"
                        "4 1 0 0 0 0 0 0.33333333333333331 1 front/c.png\n11 21 9\n");
  expect_poses_of_two(read_colmap_images(directory_.path()));
  write();
  expect_poses_of_two(read_colmap_images(directory_.path()));
}

TEST_F(ColmapTest, ImagesArePanoramasOfAnEquirectangularCamera) {
  EXPECT_FALSE(images_are_panoramas(directory_.path()));
  const std::string comment = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  write_file_atomically(directory_ / "cameras.txt", comment + "1 EQUIRECTANGULAR 64 32 64 32\n");
  EXPECT_TRUE(images_are_panoramas(directory_.path()));
  write_file_atomically(directory_ / "cameras.txt", comment + "1 SIMPLE_PINHOLE 8 8 4 4 4\n");
  EXPECT_FALSE(images_are_panoramas(directory_.path()));
  const std::string bytes = equirectangular_camera_bytes();
  write_file_atomically(directory_ / "cameras.bin", bytes);
  EXPECT_TRUE(images_are_panoramas(directory_.path()));
  write_file_atomically(directory_ / "cameras.bin", bytes.substr(0, 15));
  EXPECT_THAT(error_of([&] { images_are_panoramas(directory_.path()); }), HasSubstr("cut short"));
  write();  // cameras.bin, of pinholes
  EXPECT_FALSE(images_are_panoramas(directory_.path()));
}

TEST_F(ColmapTest, ImagesOfAnotherFolderOrDamagedAreRefused) {
  EXPECT_THAT(error_of([&] { read_colmap_images(directory_.path()); }), HasSubstr("images.bin"));
  const std::string image = "1 1 0 0 0 0 0 0 1 a.png\n\n";
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"# nothing\n", "holds no image"},
           {"1 1 0 0 0 0 zero 0 1 a.png\n\n", "images.txt:1: 'zero' is not a number"},
           {"1 0 0 0 0 0 0 0 1 a.png\n", "not a quaternion"},
           {image + image, "'a.png' is there twice"}}) {
    EXPECT_THAT(error_of([&text = text] { colmap_images_of_text(text, "images.txt"); }),
                HasSubstr(message));
  }
  write();
  const std::string whole = read_file(directory_ / "images.bin");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_THAT(error_of([&] { colmap_images_of_bytes(whole.substr(0, size), "images.bin"); }),
                HasSubstr("cut short"));
  }
}

constexpr PanoramaSize kSize{256, 128};

std::vector<NerfstudioFrame> two_frames() {
  return {{.file = "images/a.png", .pose = {{1, 2, 3}, Eigen::Matrix3d::Identity()}},
          {.file = "images/b.png",
           .mask = "masks/b.png",
           .pose = {{-0.1, 0.2, 1.0 / 3.0}, world_from_camera({0.3, -0.2, 0.1})}}};
}

// The direction of a pixel in nerfstudio's world, by the formulas of its generate_rays.
Eigen::Vector3d nerfstudio_ray(const nlohmann::json& document, int frame, double x, double y) {
  const double across = (x - document["cx"].get<double>()) / document["fl_x"].get<double>();
  const double up = -(y - document["cy"].get<double>()) / document["fl_y"].get<double>();
  const double theta = -kPi * across;
  const double phi = kPi * (0.5 - up);
  const Eigen::Vector3d ray(-std::sin(theta) * std::sin(phi), std::cos(phi),
                            -std::cos(theta) * std::sin(phi));
  Eigen::Matrix3d rotation;
  const nlohmann::json& matrix = document["frames"][frame]["transform_matrix"];
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rotation(row, column) = matrix[row][column];
  }
  EXPECT_NEAR(rotation.determinant(), 1.0, 1e-12);
  return rotation * ray;
}

TEST(NerfstudioFile, ShowsEveryPixelInOurDirection) {
  const auto document = nlohmann::json::parse(nerfstudio_text(two_frames(), kSize, ""));
  for (int frame = 0; frame < 2; ++frame) {
    for (const PixelPosition pixel : {PixelPosition{0, 0}, {200, 40}, {127, 63}, {3, 120}}) {
      const Eigen::Vector3d ours =
          two_frames()[static_cast<std::size_t>(frame)].pose.world_from_camera *
          direction_from_angles(angles_from_pixel(pixel, kSize));
      const Eigen::Vector3d theirs = nerfstudio_ray(document, frame, pixel.u + 0.5, pixel.v + 0.5);
      // x right, y forward, z up.
      EXPECT_NEAR(theirs.x(), ours.x(), 1e-12);
      EXPECT_NEAR(theirs.y(), ours.z(), 1e-12);
      EXPECT_NEAR(theirs.z(), ours.y(), 1e-12);
    }
  }
  EXPECT_EQ(document["frames"][0]["transform_matrix"][2][3], 2.0);  // up
}

TEST(NerfstudioFile, RoundTripsExactly) {
  const auto frames =
      nerfstudio_of_text(nerfstudio_text(two_frames(), kSize, "points.ply"), "t.json");
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[1].file, "images/b.png");
  EXPECT_EQ(frames[1].mask, "masks/b.png");
  EXPECT_EQ(frames[1].pose.position_m, two_frames()[1].pose.position_m);
  EXPECT_LT((frames[1].pose.world_from_camera - two_frames()[1].pose.world_from_camera).norm(),
            1e-15);
}

std::string error_for(const std::string& model, const std::string& matrix) {
  return error_of([&] {
    nerfstudio_of_text(R"({"camera_model": ")" + model +
                           R"(", "frames": [{"file_path": "a.png", "transform_matrix": )" + matrix +
                           "}]}",
                       "transforms.json");
  });
}

TEST(NerfstudioFile, OfAnotherConventionIsRefused) {
  const std::string unit = "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]";
  EXPECT_EQ(error_for("EQUIRECTANGULAR", unit), "no error");
  EXPECT_THAT(error_for("OPENCV", unit),
              HasSubstr("transforms.json: frames[0]: its camera_model is 'OPENCV'"));
  EXPECT_THAT(error_for("EQUIRECTANGULAR", "[[2,0,0,0],[0,2,0,0],[0,0,2,0]]"), HasSubstr("scales"));
  EXPECT_THAT(error_for("EQUIRECTANGULAR", "[[1,0,0,0],[0,1,0,0],[0,0,-1,0]]"),
              HasSubstr("mirrors"));
  EXPECT_THAT(error_for("EQUIRECTANGULAR", "[[1,0,0],[0,1,0],[0,0,1]]"),
              HasSubstr("transform_matrix"));
  EXPECT_THAT(error_of([] {
                nerfstudio_of_text(R"({"camera_angle_x": 1, "frames": [{"file_path": "a"}]})", "t");
              }),
              HasSubstr("give poses of panoramas"));
  EXPECT_THAT(error_of([] { nerfstudio_of_text(R"({"frames": []})", "t"); }),
              HasSubstr("lists no frames"));
}

constexpr int kFace_px = 64;

Eigen::Vector3d random_point(std::mt19937* random, double most) {
  std::uniform_real_distribution<double> value(-most, most);
  const double x = value(*random), y = value(*random);
  return {x, y, value(*random)};
}

CameraPose some_pose(unsigned seed) {
  std::mt19937 random(seed);
  const Eigen::Vector3d angles = random_point(&random, 3.0);
  return {random_point(&random, 3.0),
          world_from_camera({angles.x(), 0.5 * angles.y(), angles.z()})};
}

// A face that looks up, aslant and rolled, beside the camera's centre.
PanoramaFace some_face() { return {world_from_camera({0.8, 0.4, -0.3}), {0.001, 0.002, 0.006}}; }

// COLMAP's own way, by its documentation: rotate by the quaternion, add t, divide, scale.
FacePixel colmap_projection(const ColmapPose& pose, const Eigen::Vector3d& colmap_world) {
  const Eigen::Vector3d in_image = pose.rotation * colmap_world + pose.translation;
  const double focal = 0.5 * kFace_px;
  return {focal * in_image.x() / in_image.z() + 0.5 * kFace_px,
          focal * in_image.y() / in_image.z() + 0.5 * kFace_px};
}

TEST(PanoramaFaces, ProjectAsColmapDoes) {
  std::vector<PanoramaFace> faces = cube_faces();
  faces.push_back(some_face());
  for (unsigned seed = 0; seed < 50; ++seed) {
    const CameraPose camera = some_pose(seed);
    std::mt19937 random(1000 + seed);
    const Eigen::Vector3d world = camera.position_m + random_point(&random, 4.0);
    for (const PanoramaFace& face : faces) {
      const Eigen::Vector3d from_lens =
          camera.world_from_camera.transpose() * (world - camera.position_m) - face.centre_m;
      const auto ours = face_pixel_of(face, kFace_px, from_lens);
      const ColmapPose pose = colmap_pose(camera, face);
      const double depth = (pose.rotation * flipped(world) + pose.translation).z();
      EXPECT_EQ(ours.has_value(), depth > 0.0);
      if (!ours) continue;
      const FacePixel theirs = colmap_projection(pose, flipped(world));
      EXPECT_NEAR(ours->x, theirs.x, 1e-6 * std::max(1.0, std::abs(theirs.x)));
      EXPECT_NEAR(ours->y, theirs.y, 1e-6 * std::max(1.0, std::abs(theirs.y)));
      EXPECT_LT((direction_of(face, kFace_px, *ours) - from_lens.normalized()).norm(), 1e-9);
    }
  }
}

TEST(PanoramaFaces, GiveTheirPanoramasPoseBack) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const CameraPose camera = some_pose(seed);
    for (const PanoramaFace& face : cube_faces()) {
      const CameraPose back = camera_pose_of(colmap_pose(camera, face), face);
      EXPECT_LT((back.position_m - camera.position_m).norm(), 1e-14);
      EXPECT_LT((back.world_from_camera - camera.world_from_camera).norm(), 1e-14);
    }
  }
}

// Of every direction exactly one side of the cube sees it (but for edges), by its name.
TEST(PanoramaFaces, OfACubeSeeEveryDirectionOnce) {
  std::mt19937 random(7);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d direction = random_point(&random, 1.0);
    int seen = 0;
    for (const PanoramaFace& face : cube_faces()) {
      const auto pixel = face_pixel_of(face, kFace_px, direction);
      if (pixel && pixel->x > 0 && pixel->x < kFace_px && pixel->y > 0 && pixel->y < kFace_px) {
        ++seen;
      }
    }
    EXPECT_EQ(seen, 1);
  }
  const std::vector<PanoramaFace> faces = cube_faces();
  EXPECT_GT(faces[1].camera_from_face.col(2).x(), 0.99);   // right
  EXPECT_LT(faces[3].camera_from_face.col(2).x(), -0.99);  // left
  EXPECT_GT(faces[4].camera_from_face.col(2).y(), 0.99);   // up
}

double level_in(const Eigen::Vector3d& direction) {
  return 128.0 + 60.0 * direction.x() + 40.0 * direction.y() + 20.0 * direction.z();
}

cv::Mat direction_panorama(int width) {
  cv::Mat panorama(width / 2, width, CV_8UC3);
  for (int v = 0; v < panorama.rows; ++v) {
    for (int u = 0; u < width; ++u) {
      const Eigen::Vector3d direction = direction_from_angles(
          angles_from_pixel({static_cast<double>(u), static_cast<double>(v)}, {width, width / 2}));
      panorama.at<cv::Vec3b>(v, u) = cv::Vec3b::all(cv::saturate_cast<uchar>(level_in(direction)));
    }
  }
  return panorama;
}

TEST(FaceCutter, SamplesThePanoramaInEachDirection) {
  const std::vector<PanoramaFace> faces = cube_faces();
  for (const int width : {256, 2048}) {  // sampled as it is, and reduced before
    const FaceCutter cutter(faces, {width, width / 2}, kFace_px);
    const auto cut = cutter.cut(direction_panorama(width));
    for (std::size_t i = 0; i < faces.size(); ++i) {
      ASSERT_EQ(cut[i].size(), cv::Size(kFace_px, kFace_px));
      ASSERT_EQ(cut[i].type(), CV_8UC3);
      for (int y = 0; y < kFace_px; y += 7) {
        for (int x = 0; x < kFace_px; x += 7) {
          const Eigen::Vector3d direction = direction_of(faces[i], kFace_px, {x + 0.5, y + 0.5});
          EXPECT_NEAR(cut[i].at<cv::Vec3b>(y, x)[1], level_in(direction), 1.6);
        }
      }
    }
  }
}

TEST(FaceCutter, CutsMasksAndMasksSeams) {
  const std::vector<PanoramaFace> faces = cube_faces();
  const FaceCutter cutter(faces, {256, 128}, kFace_px);
  cv::Mat mask(128, 256, CV_8UC1, cv::Scalar(255));
  mask.rowRange(90, 128).setTo(0);  // below -36 degrees
  const auto plain = cutter.cut_mask(mask, 0.0);
  const auto clear = cutter.cut_mask(mask, 5.0);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (int y = 0; y < kFace_px; ++y) {
      for (int x = 0; x < kFace_px; ++x) {
        const Eigen::Vector3d direction = direction_of(faces[i], kFace_px, {x + 0.5, y + 0.5});
        const double below_deg = -degrees_from_radians(std::asin(direction.y()));
        if (std::abs(below_deg - 36.6) < 1.0) continue;  // the mask's own edge
        EXPECT_EQ(plain[i].at<uchar>(y, x) != 0, below_deg < 36.6);
        const double from_seam_deg = degrees_from_radians(std::asin(std::abs(direction.z())));
        EXPECT_EQ(clear[i].at<uchar>(y, x) != 0, below_deg < 36.6 && from_seam_deg > 5.0);
      }
    }
  }
}

}  // namespace
}  // namespace raywalk
