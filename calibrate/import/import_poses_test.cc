#include "calibrate/import/import_poses.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "calibrate/import/face_poses.h"
#include "calibrate/import/grid_axes.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/files/test_support.h"
#include "core/reconstruction/colmap_model.h"
#include "core/reconstruction/nerfstudio_file.h"
#include "core/reconstruction/test_colmap.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// --- Poses of a square of four lines, as another program would give them ------------------------

// Seven stations a quarter of the side apart on each of four lines around a cell of 1 m x 1 m,
// upright but for small angles that differ from frame to frame.
std::vector<ImportedFrame> square_frames() {
  std::vector<ImportedFrame> frames;
  for (int i = 0; i < 28; ++i) {
    const double along_m = -0.75 + 0.25 * (i % 7);
    const double across_m = i / 7 == 0 || i / 7 == 2 ? 0.5 : -0.5;
    const bool along_x = i / 7 < 2;
    const Attitude attitude{0.02 * (i % 5 - 2), 0.01 * (i % 3 - 1), 0.008 * (i % 4 - 1.5)};
    frames.push_back({.file = fmt::format("{:02d}.png", i),
                      .pose = {{along_x ? along_m : across_m, 0.0, along_x ? across_m : along_m},
                               world_from_camera(attitude)},
                      .where = fmt::format("test: {}", i)});
  }
  return frames;
}

// The frames in another frame of reference: x_source = (R x_world + t) / scale.
std::vector<ImportedFrame> in_other_axes(std::vector<ImportedFrame> frames,
                                         const Eigen::Matrix3d& rotation,
                                         const Eigen::Vector3d& translation, double scale) {
  for (ImportedFrame& frame : frames) {
    frame.pose.position_m = (rotation * frame.pose.position_m + translation) / scale;
    frame.pose.world_from_camera = rotation * frame.pose.world_from_camera;
  }
  return frames;
}

ImportedPoses turned_square(const Attitude& turn, double scale) {
  return {.kind = "a test",
          .frames = in_other_axes(square_frames(), world_from_camera(turn), {3, -2, 5}, scale)};
}

void expect_frames(const std::vector<ImportedFrame>& truth, const ImportedPoses& poses,
                   const GridAxes& axes, double tolerance) {
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const CameraPose pose = moved(axes, poses.frames[i].pose);
    EXPECT_LT((pose.position_m - truth[i].pose.position_m).norm(), tolerance) << i;
    EXPECT_LT((pose.world_from_camera - truth[i].pose.world_from_camera).norm(), tolerance) << i;
  }
}

TEST(GridAxes, UndoAnyRotationAndScale) {
  for (const Attitude turn :
       {Attitude{0.3, 0, 0}, {2.5, 1.2, -0.7}, {-1.7, -0.4, 3.0}, {0.78, 0, 0}}) {
    for (const double scale : {0.13, 4.0}) {
      const ImportedPoses poses = turned_square(turn, scale);
      for (const AxesOptions& known :
           {AxesOptions{.scale = {.cell_m = 1.0}}, AxesOptions{.scale = {.spacing_m = 0.25}},
            AxesOptions{.scale = {.metres_per_unit = scale}},
            AxesOptions{.scale = {.distance = KnownDistance{"00", "04.jpg", 1.0}}}}) {
        expect_frames(square_frames(), poses, fit_grid_axes(poses, known), 1e-9);
      }
    }
  }
}

TEST(GridAxes, AreKeptIfAskedFor) {
  ImportedPoses poses = turned_square({0, 0, 0}, 2.0);
  const GridAxes axes = fit_grid_axes(poses, {.fit = false, .scale = {.metres_per_unit = 2.0}});
  EXPECT_EQ(axes.rotation, Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  EXPECT_EQ(moved(axes, poses.frames[0].pose).position_m, Eigen::Vector3d(2.25, -2, 5.5));
}

TEST(GridAxes, OfAnUprightSourceTurnAboutTheVerticalOnly) {
  ImportedPoses poses = turned_square({0.4, 0, 0}, 1.0);
  // A street that falls: level lines would lean the cameras.
  for (ImportedFrame& frame : poses.frames)
    frame.pose.position_m.y() -= 0.05 * frame.pose.position_m.x();
  poses.in_world = true;
  const GridAxes axes = fit_grid_axes(poses, {});
  EXPECT_LT((axes.rotation.col(1) - Eigen::Vector3d::UnitY()).norm(), 1e-15);
  EXPECT_EQ(axes.scale, 1.0);
}

// A single line has no plane: its cameras tell what is up, and it becomes level.
TEST(GridAxes, OfOneLineStandOnTheCameras) {
  std::vector<ImportedFrame> line;
  for (int i = 0; i < 7; ++i) {
    line.push_back(
        {.file = std::to_string(i), .pose = {{0.1 * i - 0.3, 0, 0}, world_from_camera({0, 0, 0})}});
  }
  const ImportedPoses poses{
      .kind = "a test",
      .frames = in_other_axes(line, world_from_camera({2.0, 0.5, 0.9}), {1, 1, 1}, 1.0)};
  expect_frames(line, poses, fit_grid_axes(poses, {.scale = {.metres_per_unit = 1.0}}), 1e-12);
}

TEST(GridAxes, StayRightWithStationsBesideTheirLines) {
  ImportedPoses poses = turned_square({1.1, 0.3, 0.2}, 0.5);
  for (std::size_t i = 0; i < poses.frames.size(); ++i) {
    const double off = 0.02 * std::sin(7.0 * static_cast<double>(i));
    poses.frames[i].pose.position_m += Eigen::Vector3d(off, 0.5 * off, -off);
  }
  expect_frames(square_frames(), poses, fit_grid_axes(poses, {.scale = {.cell_m = 1.0}}), 0.03);
}

TEST(GridAxes, ThatCannotBeFoundAreSaid) {
  const auto error_for = [](const ImportedPoses& poses, const AxesOptions& options) {
    return error_of([&] { fit_grid_axes(poses, options); });
  };
  ImportedPoses poses = turned_square({0.1, 0.2, 0.3}, 1.0);
  EXPECT_THAT(error_for(poses, {.scale = {.distance = KnownDistance{"00", "nowhere", 1.0}}}),
              HasSubstr("'nowhere' is none of the 28 panoramas"));
  ImportedPoses line = poses;
  line.frames.resize(7);
  EXPECT_THAT(error_for(line, {.scale = {.cell_m = 1.0}}), HasSubstr("close no cell"));
  for (std::size_t i = 0; i < poses.frames.size(); ++i) {
    if (i % 2 == 0) poses.frames[i].pose.world_from_camera *= world_from_camera({0, 0, kPi});
  }
  EXPECT_THAT(error_for(poses, {.scale = {.cell_m = 1.0}}), HasSubstr("no common up"));
}

TEST(KnownPositions, GiveScaleAndAxes) {
  const ImportedPoses poses = turned_square({1.5, 0.4, -0.2}, 3.0);
  const std::vector<ImportedFrame> truth = square_frames();
  const auto axes_of = [&](const std::vector<std::size_t>& frames) {
    std::vector<KnownPosition> known;
    for (const std::size_t i : frames) known.push_back({i, truth[i].pose.position_m});
    return fit_known_positions(poses, known);
  };
  expect_frames(truth, poses, axes_of({0, 3, 9, 20}), 1e-12);
  EXPECT_THAT(error_of([&] { axes_of({0, 3}); }), HasSubstr("at least three"));
  EXPECT_THAT(error_of([&] { axes_of({0, 1, 2}); }), HasSubstr("on one line"));
}

// A folder with panoramas and a nerfstudio file of them, in other axes.
class ImportPosesTest : public ::testing::Test {
 protected:
  ImportPosesTest() {
    fs::create_directories(directory_ / "pictures");
    std::vector<NerfstudioFrame> frames;
    for (const ImportedFrame& frame : given_) {
      frames.push_back({.file = "pictures/" + frame.file, .pose = frame.pose});
      write_image(directory_ / frames.back().file, cv::Mat(16, 32, CV_8UC3, cv::Scalar::all(90)));
    }
    write_file_atomically(transforms(), nerfstudio_text(frames, {32, 16}, ""));
  }

  fs::path transforms() const { return directory_ / "transforms.json"; }
  fs::path out() const { return directory_ / "hall"; }
  ImportOptions options() const {
    return {.source = transforms(), .axes = {.scale = {.cell_m = 1.0}}, .out = out()};
  }
  // The list has the true frames and poses.
  void expect_true_list() const {
    const std::vector<Frame> listed = read_frame_list(out() / "poses.csv");
    const std::vector<ImportedFrame> truth = square_frames();
    ASSERT_EQ(listed.size(), truth.size());
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_TRUE(fs::exists(listed[i].path)) << listed[i].path;
      EXPECT_EQ(listed[i].path.filename(), truth[i].file);
      EXPECT_LT((listed[i].position_m - truth[i].pose.position_m).norm(), 2e-9);
      const Eigen::Matrix3d attitude = world_from_camera(listed[i].attitude.value_or(Attitude{}));
      EXPECT_LT((attitude - truth[i].pose.world_from_camera).norm(), 1e-9);
    }
  }
  static std::string error_for(const ImportOptions& options) {
    return error_of([&] { import_poses(options); });
  }

  TestDirectory directory_;
  std::vector<ImportedFrame> given_ =
      in_other_axes(square_frames(), world_from_camera({0.6, 0.4, 0.1}), {1, 2, 3}, 2.0);
};

TEST_F(ImportPosesTest, ListsThePanoramasInTheAxesOfTheirGrid) {
  EXPECT_THAT(import_poses(options()),
              HasSubstr("4 lines, stations 250.0 to 250.0 mm apart, 1 cell ("));
  expect_true_list();
  EXPECT_THAT(read_file(out() / "import.json"), HasSubstr("\"raywalk-import\""));
}

TEST_F(ImportPosesTest, MillimetresInPlaceOfMetresAreWarnedOf) {
  ImportOptions given = options();
  given.axes.scale = {.metres_per_unit = 500.0};  // of a unit of half a metre
  const CapturedLog log;
  import_poses(given);
  EXPECT_THAT(log.text(), HasSubstr("divide millimetres by 1000"));
}

// As COLMAP 4.1 writes it, with rigs and frames beside.
TEST_F(ImportPosesTest, TakesPanoramasOfAColmapModel) {
  ColmapModel model{.cameras = {{1, 32, 16.0}}, .rigs = {{.id = 1, .reference_camera = 1}}};
  for (const ImportedFrame& frame : given_) {
    const auto id = static_cast<std::uint32_t>(model.images.size() + 1);
    model.images.push_back({id, 1, frame.file, colmap_pose(frame.pose, {}), {}});
    model.frames.push_back({id, 1, model.images.back().pose, {id}});
  }
  fs::create_directories(directory_ / "sparse/0");
  write_colmap_model(directory_ / "sparse/0", model);
  write_file_atomically(directory_ / "sparse/0/cameras.bin", equirectangular_camera_bytes());
  ImportOptions of_model = options();
  of_model.source = directory_ / "sparse/0";
  of_model.panoramas = directory_ / "pictures";
  EXPECT_THAT(import_poses(of_model), HasSubstr("28 panoramas of a COLMAP model: 4 lines"));
  expect_true_list();
}

TEST_F(ImportPosesTest, ReplacesOnlyAnEarlierImport) {
  import_poses(options());
  EXPECT_THAT(error_for(options()), HasSubstr("exists already"));
  ImportOptions again = options();
  again.replace = true;
  EXPECT_EQ(error_for(again), "no error");
  fs::remove(out() / "import.json");
  EXPECT_THAT(error_for(again), HasSubstr("--force does not replace"));
}

TEST_F(ImportPosesTest, WithoutScaleOrPicturesLeavesNothing) {
  ImportOptions unknown = options();
  unknown.axes.scale = {};
  EXPECT_THAT(error_for(unknown), HasSubstr("does not say how long its unit is; give --cell-m"));
  fs::remove(directory_ / "pictures" / "05.png");
  EXPECT_THAT(error_for(options()), HasSubstr("frames[5]: there is no panorama 'pictures/05.png'"));
  write_image(directory_ / "pictures" / "05.png", cv::Mat(16, 16, CV_8UC3, cv::Scalar::all(90)));
  EXPECT_THAT(error_for(options()), HasSubstr("05.png"));
  ImportOptions elsewhere = options();
  elsewhere.panoramas = directory_ / "nowhere";
  EXPECT_THAT(error_for(elsewhere), HasSubstr("no such folder of panoramas"));
  elsewhere.source = directory_ / "pictures";
  EXPECT_THAT(error_for(elsewhere), HasSubstr("holds neither images.bin nor images.txt"));
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(ImportPosesTest, TakesAReferenceAndAFrameList) {
  std::string list = "file,x,y,z\n";
  for (const int i : {0, 3, 9, 20}) {
    const ImportedFrame frame = square_frames()[i];
    list += fmt::format("{},{},{},{}\n", frame.file, frame.pose.position_m.x(),
                        frame.pose.position_m.y(), frame.pose.position_m.z());
  }
  write_file_atomically(directory_ / "known.csv", list);
  ImportOptions known = options();
  known.axes.scale = {};
  known.reference = directory_ / "known.csv";
  import_poses(known);
  ImportOptions second;
  second.source = out() / "poses.csv";
  second.axes.fit = false;
  second.out = directory_ / "b";
  import_poses(second);
  const std::vector<Frame> listed = read_frame_list(directory_ / "b" / "poses.csv");
  EXPECT_LT((listed[5].position_m - square_frames()[5].pose.position_m).norm(), 2e-9);
}

std::vector<ColmapImage> images_of(const std::vector<ImportedFrame>& frames,
                                   const std::vector<NamedFace>& faces) {
  std::vector<ColmapImage> images;
  for (const ImportedFrame& frame : frames) {
    for (const NamedFace& face : faces) {
      images.push_back({.name = face.folder + "/" + frame.file,
                        .pose = colmap_pose(frame.pose, {face.camera_from_face})});
    }
  }
  return images;
}

TEST(FacePoses, GiveThePosesOfTheirPanoramas) {
  const std::vector<ImportedFrame> frames = square_frames();
  std::vector<ColmapImage> images = images_of(frames, exported_faces());
  images.erase(images.begin() + 2, images.begin() + 6);  // two faces of the first are enough
  const auto found = panoramas_of_faces(images, exported_faces(), "model");
  ASSERT_EQ(found.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(found[i].file + ".png", frames[i].file);
    EXPECT_LT((found[i].pose.position_m - frames[i].pose.position_m).norm(), 1e-13);
    EXPECT_LT((found[i].pose.world_from_camera - frames[i].pose.world_from_camera).norm(), 1e-13);
  }
}

TEST(FacePoses, FollowATable) {
  const TestDirectory directory;
  write_file_atomically(directory / "faces.csv",
                        "folder,yaw,pitch\npano_camera0,0,-35\npano_camera1,45,35\n");
  const std::vector<NamedFace> faces = read_face_table(directory / "faces.csv");
  ASSERT_EQ(faces.size(), 2U);
  EXPECT_LT(faces[0].camera_from_face.col(2).y(), -0.5);  // looks down
  EXPECT_GT(faces[1].camera_from_face.col(2).x(), 0.5);   // and to the right
  const std::vector<ImportedFrame> frames = square_frames();
  const auto found = panoramas_of_faces(images_of(frames, faces), faces, "model");
  EXPECT_LT((found[3].pose.world_from_camera - frames[3].pose.world_from_camera).norm(), 1e-13);
}

TEST(FacePoses, OfOtherFacesAreRefused) {
  const std::vector<ImportedFrame> frames = square_frames();
  const auto error_for = [](const std::vector<ColmapImage>& images) {
    return error_of([&] { panoramas_of_faces(images, exported_faces(), "sparse/0"); });
  };
  EXPECT_THAT(
      error_for({{.name = "IMG_1.jpg"}}),
      HasSubstr("sparse/0: image 'IMG_1.jpg' is in none of the folders of faces (front, right"));
  // Left and right exchanged.
  std::vector<NamedFace> swapped = exported_faces();
  std::swap(swapped[1].folder, swapped[3].folder);
  EXPECT_THAT(error_for(images_of(frames, swapped)), HasSubstr("disagree by"));
  std::vector<ColmapImage> images = images_of(frames, exported_faces());
  images[1].pose.translation.x() += 0.9;
  EXPECT_THAT(error_for(images), HasSubstr("apart, while panoramas are"));
}

}  // namespace
}  // namespace raywalk::calibrate
