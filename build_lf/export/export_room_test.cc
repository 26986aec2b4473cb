#include "build_lf/export/export_room.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>

#include "build_lf/export/point_cloud.h"
#include "calibrate/import/import_poses.h"
#include "core/base/child_process.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/files/test_support.h"
#include "core/reconstruction/colmap_model.h"
#include "core/room/room.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

SyntheticRoomSpec small_room() {
  SyntheticRoomSpec spec{.spacing_m = 0.5, .overhang_m = 0.5, .height_m = 0.2};
  spec.scene.obstacle = SceneBox{{-0.2, -1.2, -0.1}, {0.2, 0.4, 0.2}};
  return spec;
}

// Something below the cameras, masked.
const CameraCompanion kBelow{
    .hides = [](const std::string&, int, const Eigen::Vector3d& d) { return d.y() < -0.8; }};

// Twenty stations. Files are flushed to disk one by one, so tests export few of them.
class ExportRoomTest : public ::testing::Test {
 protected:
  void make_room(const SyntheticRoomSpec& spec) { write_synthetic_room(spec, room()); }

  fs::path room() const { return directory_ / "hall.lf"; }
  fs::path out() const { return directory_ / "out"; }
  ExportOptions options(ExportFormat format) const {
    return {.room = room(), .out = out(), .format = format, .points = 4000};
  }
  // Nothing but the room is there.
  void expect_nothing_left() const {
    for (const fs::directory_entry& entry : fs::directory_iterator(directory_.path())) {
      EXPECT_EQ(entry.path(), room());
    }
  }

  // The poses that an import of `source` gives, as it stands, compared with the room's.
  void expect_poses_of_room(const fs::path& source,
                            const std::optional<fs::path>& panoramas) const {
    const fs::path imported = directory_ / "imported";
    fs::remove_all(imported);
    calibrate::ImportOptions options;
    options.source = source;
    options.panoramas = panoramas;
    options.axes.fit = false;
    options.axes.scale.metres_per_unit = 1.0;
    options.out = imported;
    calibrate::import_poses(options);
    std::map<std::string, Frame> frames;
    for (const Frame& frame : read_frame_list(imported / "poses.csv")) {
      frames[frame.path.stem().string()] = frame;
    }
    const Room exported = Room::open(room());
    const std::vector<StationIndex> stations = all_stations(exported.grid());
    EXPECT_EQ(frames.size(), stations.size());
    for (const StationIndex index : stations) {
      const Station& station = exported.grid().station(index);
      const Frame frame = frames.at(fs::path(station.file).stem().string());
      EXPECT_LT((frame.position_m - station.position_m).norm(), 1e-9);
      const Attitude turned = frame.attitude.value_or(Attitude{});
      EXPECT_LT(std::abs(turned.yaw_rad) + std::abs(turned.pitch_rad) + std::abs(turned.roll_rad),
                1e-9);
    }
  }

  TestDirectory directory_;
};

// COLMAP's own projection of a point, by its documentation.
FacePixel projected_by_colmap(const ColmapImage& image, const ColmapPoint& point) {
  constexpr double kFocal_px = 20.0;  // of faces of 40 x 40 pixels
  const Eigen::Vector3d at = image.pose.rotation * point.position + image.pose.translation;
  EXPECT_GT(at.z(), 0.0);
  return {kFocal_px * (at.x() / at.z() + 1.0), kFocal_px * (at.y() / at.z() + 1.0)};
}

void expect_points_where_observed(const ColmapModel& model) {
  EXPECT_GT(model.points.size(), 500U);
  double worst_px = 0.0;
  for (const ColmapPoint& point : model.points) {
    std::set<std::uint32_t> stations;
    double sum_px = 0.0;
    for (const ColmapTrackElement& seen : point.track) {
      const ColmapImage& image = model.images[seen.image - 1];
      const ColmapFeature& feature = image.features[seen.feature];
      EXPECT_EQ(feature.point, point.id);
      const FacePixel truth = projected_by_colmap(image, point);
      const double error_px = std::hypot(truth.x - feature.pixel.x, truth.y - feature.pixel.y);
      worst_px = std::max(worst_px, error_px);
      sum_px += error_px;
      stations.insert((seen.image - 1) / 6);
    }
    EXPECT_GE(stations.size(), 2U);
    EXPECT_NEAR(point.error_px, sum_px / static_cast<double>(point.track.size()), 1e-9);
  }
  EXPECT_LT(worst_px, 0.5);
  EXPECT_GT(worst_px, 0.0);  // other stations' maps are pixels of their own
}

// What a command of COLMAP prints.
std::string colmap_output(std::vector<std::string> arguments, const fs::path& log) {
  arguments.insert(arguments.begin(), {"QT_QPA_PLATFORM=offscreen", "/usr/bin/colmap"});
  ChildProcess colmap("/usr/bin/env", arguments, log);
  EXPECT_TRUE(succeeded(colmap.wait())) << read_file(log);
  return read_file(log);
}

// COLMAP's own text of the model, which it writes into `converted`, has our poses.
void expect_colmap_reads(const fs::path& exported, std::size_t points, const fs::path& converted,
                         const TestDirectory& logs) {
  const std::string model = (exported / "sparse" / "0").string();
  const std::string told = colmap_output({"model_analyzer", "--path", model}, logs / "log-model");
  EXPECT_THAT(told, HasSubstr("Registered images: 120"));
  EXPECT_THAT(told, HasSubstr(fmt::format("Points: {}", points)));
  const std::size_t at = told.find("Mean reprojection error: ");
  ASSERT_NE(at, std::string::npos);
  EXPECT_LT(std::stod(told.substr(at + 25)), 0.5);
  fs::create_directory(converted);
  colmap_output({"model_converter", "--input_path", model, "--output_path", converted.string(),
                 "--output_type", "TXT"},
                logs / "log-converter");
  std::map<std::string, ColmapPose> poses;
  for (const ColmapImage& image : read_colmap_images(converted)) {
    poses[image.name] = image.pose;
  }
  for (const ColmapImage& image : read_colmap_images(exported / "sparse" / "0")) {
    EXPECT_LT((poses.at(image.name).translation - image.pose.translation).norm(), 1e-14);
    EXPECT_LT(poses.at(image.name).rotation.angularDistance(image.pose.rotation), 1e-7);
  }
}

// The pictures, the model's cameras and the points fit together: in the middle of a picture's
// pixels is the scene's colour in the direction that COLMAP gives that pixel.
void expect_pictures_of_scene(const fs::path& exported, const ColmapModel& model,
                              const SyntheticScene& scene) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < model.images.size(); i += 5) {
    const ColmapImage& image = model.images[i];
    const cv::Mat picture = read_picture(exported / "images" / image.name);
    const Eigen::Matrix3d world_from_image = image.pose.rotation.toRotationMatrix().transpose();
    const Eigen::Vector3d centre = flipped(-world_from_image * image.pose.translation);
    for (int y = 4; y < picture.rows; y += 8) {
      for (int x = 4; x < picture.cols; x += 8) {
        const Eigen::Vector3d in_image((x + 0.5 - 20) / 20, (y + 0.5 - 20) / 20, 1.0);
        const Eigen::Vector3d direction = flipped(world_from_image * in_image).normalized();
        const Eigen::Vector3d truth = color_at(scene, centre, direction);
        sum += std::abs(picture.at<cv::Vec3b>(y, x)[2] - truth[0]);
        ++count;
      }
    }
  }
  EXPECT_LT(sum / count, 3.0);  // of 180 levels; what is left is interpolation at edges
}

TEST_F(ExportRoomTest, ColmapModelPicturesAndPosesAgree) {
  const SyntheticRoomSpec spec = small_room();
  make_room(spec);
  EXPECT_THAT(export_room(options(ExportFormat::kColmap)),
              HasSubstr("120 images of 40 x 40 pixels"));
  const ColmapModel model = read_colmap_model(out() / "sparse" / "0");
  expect_points_where_observed(model);
  expect_pictures_of_scene(out(), model, spec.scene);
  const fs::path in_text = directory_ / "converted";
  expect_colmap_reads(out(), model.points.size(), in_text, directory_);
  // Any picture of panoramas will do where only poses are asked for.
  const fs::path panoramas = directory_ / "panoramas";
  fs::create_directory(panoramas);
  const Grid grid = Room::open(room()).grid();
  for (const StationIndex station : all_stations(grid)) {
    cv::imwrite((panoramas / fs::path(grid.station(station).file).stem()).string() + ".png",
                cv::Mat(16, 32, CV_8UC3, cv::Scalar::all(0)));
  }
  expect_poses_of_room(out(), panoramas);
  expect_poses_of_room(in_text, panoramas);
}

TEST_F(ExportRoomTest, PosesOfPanoramasComeBack) {
  make_room(small_room());
  export_room(options(ExportFormat::kFrames));
  expect_poses_of_room(out() / "poses.csv", std::nullopt);
  ExportOptions next = options(ExportFormat::kNerfstudio);
  next.replace = true;
  export_room(next);
  EXPECT_FALSE(fs::exists(out() / "poses.csv"));
  expect_poses_of_room(out() / "transforms.json", std::nullopt);
}

TEST_F(ExportRoomTest, FramesHaveTheRoomsPicturesAndDistances) {
  make_room(small_room());
  EXPECT_THAT(export_room(options(ExportFormat::kFrames)),
              HasSubstr("20 panoramas, 20 distance maps"));
  const Room opened = Room::open(room());
  const std::string name =
      fs::path(opened.grid().lines[0].stations[2].file).stem().string() + ".png";
  const cv::Mat picture = read_panorama(out() / "images" / name);
  const auto column = opened.volume(0).column(2, 17);
  EXPECT_EQ(picture.at<cv::Vec3b>(5, 17), cv::Vec3b(column[17], column[16], column[15]));
  const cv::Mat map = read_distance_map(out() / "distances" / name);
  EXPECT_EQ(map.at<ushort>(5, 17),
            std::lround(1000.0 * opened.distances(0).distance_column(2, 17)[5]));
}

struct PlyPoint {
  Eigen::Vector3f position{0, 0, 0};
  std::array<std::uint8_t, 4> colour_and_confidence{};
};

std::vector<PlyPoint> read_points(const fs::path& file) {
  const std::string bytes = read_file(file);
  const std::size_t body = bytes.find("end_header\n") + 11;
  const std::size_t count = std::stoul(bytes.substr(bytes.find("element vertex ") + 15));
  EXPECT_EQ(bytes.size(), body + 16 * count);
  std::vector<PlyPoint> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(points[i].position.data(), bytes.data() + body + 16 * i, 12);
    std::memcpy(points[i].colour_and_confidence.data(), bytes.data() + body + 16 * i + 12, 4);
  }
  return points;
}

TEST_F(ExportRoomTest, PlyHasTheSurfacesOfTheScene) {
  SyntheticRoomSpec spec = small_room();
  spec.scene.obstacle.reset();
  spec.companion = kBelow;
  // Pixels of low confidence to the left.
  spec.stored_confidence = [](int u, int) { return u < 8 ? std::uint8_t{20} : std::uint8_t{200}; };
  make_room(spec);
  ExportOptions ply = options(ExportFormat::kPly);
  ply.voxel_mm = 50.0;
  export_room(ply);
  const std::vector<PlyPoint> points = read_points(out());
  ASSERT_GT(points.size(), 2000U);
  std::set<std::array<int, 3>> cubes;
  for (const PlyPoint& point : points) {
    // x right, y forward, z up.
    const Eigen::Vector3d world(point.position.x(), point.position.z(), point.position.y());
    const SceneBox& walls = spec.scene.walls;
    const double off = std::min((world - walls.min_m).cwiseAbs().minCoeff(),
                                (world - walls.max_m).cwiseAbs().minCoeff());
    // A mean over a cube at an edge of the room lies inside it.
    EXPECT_LT(off, 0.05);
    EXPECT_EQ(point.colour_and_confidence[3], 200);
    const Eigen::Vector3i cube = (world / 0.05).array().floor().cast<int>();
    cubes.insert({cube.x(), cube.y(), cube.z()});
  }
  EXPECT_GT(cubes.size(), points.size() - 20);  // but for rounding to float on a border
  EXPECT_THAT(error_of([&] { export_room(ply); }), HasSubstr("exists already"));
  ply.replace = true;
  ply.max_distance_m = 0.1;
  EXPECT_THAT(error_of([&] { export_room(ply); }), HasSubstr("none of its distances"));
  EXPECT_EQ(read_points(out()).size(), points.size());
}

TEST_F(ExportRoomTest, MasksAreExportedWhereThereAreAny) {
  SyntheticRoomSpec spec = small_room();
  spec.companion = kBelow;
  make_room(spec);
  ExportOptions colmap = options(ExportFormat::kColmap);
  colmap.every = 5;
  export_room(colmap);
  const ColmapModel model = read_colmap_model(out() / "sparse" / "0");
  EXPECT_EQ(model.images.size(), 6U * 4U);
  const cv::Mat down = read_mask(out() / "masks" / (model.images[5].name + ".png"), {40, 40});
  EXPECT_EQ(down.at<uchar>(20, 20), 0);
  EXPECT_EQ(down.at<uchar>(1, 1), 255);
}

TEST_F(ExportRoomTest, WhatFailsLeavesNothing) {
  SyntheticRoomSpec spec = small_room();
  spec.distances = false;
  make_room(spec);
  EXPECT_THAT(error_of([&] { export_room(options(ExportFormat::kPly)); }),
              HasSubstr("has no distances"));
  for (const ExportFormat format : {ExportFormat::kColmap, ExportFormat::kFrames}) {
    ExportOptions full = options(format);
    full.free_bytes = [](const fs::path&) { return 1000; };
    EXPECT_THAT(error_of([&] { export_room(full); }), HasSubstr("the export needs"));
  }
  EXPECT_THAT(error_of([] { export_format_from_name("e57"); }),
              HasSubstr("colmap, nerfstudio, frames or ply"));
  expect_nothing_left();
  fs::create_directory(out());
  std::ofstream(out() / "mine.txt") << "mine";
  ExportOptions forced = options(ExportFormat::kFrames);
  EXPECT_THAT(error_of([&] { export_room(forced); }), HasSubstr("exists already"));
  forced.replace = true;
  EXPECT_THAT(error_of([&] { export_room(forced); }), HasSubstr("--force does not replace"));
  EXPECT_EQ(read_file(out() / "mine.txt"), "mine");
}

TEST(VoxelPoints, AreTheWeightedMeansOfTheirCubes) {
  VoxelPoints voxels(0.1);
  voxels.add({{0.01, 0.02, -0.03}, {100, 0, 10}, 100});
  voxels.add({{0.05, 0.02, -0.03}, {200, 0, 10}, 200});
  voxels.add({{0.15, 0.02, -0.03}, {1, 2, 3}, 64});
  const std::vector<CloudPoint> points = voxels.points();
  ASSERT_EQ(points.size(), 2U);
  EXPECT_NEAR(points[0].position_m.x(), (0.01 + 2 * 0.05) / 3, 2e-6);
  EXPECT_NEAR(points[0].position_m.z(), -0.03, 2e-6);
  EXPECT_EQ(points[0].colour[0], 167);
  EXPECT_EQ(points[0].confidence, 200);
  EXPECT_NEAR(points[1].position_m.x(), 0.15, 2e-6);
}

TEST(VoxelPoints, JoiningIsAsAdding) {
  std::vector<CloudPoint> cloud;
  for (int i = 0; i < 500; ++i) {
    cloud.push_back({{0.013 * i, std::sin(i), 0.5 * std::cos(3.0 * i)}, {9, 8, 7}, 100});
  }
  VoxelPoints whole(0.05);
  VoxelPoints joined(0.05);
  VoxelPoints other(0.05);
  for (const CloudPoint& point : cloud) whole.add(point);
  for (std::size_t i = 0; i < cloud.size(); ++i) (i % 3 == 0 ? joined : other).add(cloud[i]);
  joined.take(&other);
  EXPECT_EQ(other.size(), 0U);
  ASSERT_EQ(joined.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(joined.points()[i].position_m, whole.points()[i].position_m);
  }
}

TEST(VoxelPoints, TooFarToCountAreAnError) {
  VoxelPoints voxels(0.001);
  EXPECT_THAT(error_of([&] {
                voxels.add({{0, 0, 5000}, {}, 255});
              }),
              HasSubstr("--max-distance-m"));
}

}  // namespace
}  // namespace raywalk::build_lf
