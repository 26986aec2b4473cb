#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "calibrate/lens/board_fit.h"
#include "calibrate/lens/calibrate_lens.h"
#include "calibrate/lens/charuco_markers.h"
#include "calibrate/lens/lens_test_camera.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr PanoramaSize kBoardPicture{940, 470};
const CharucoBoard kBoard{"DICT_4X4_50", 9, 7, 52.0, 32.0};
constexpr int kDictionary = 0;        // DICT_4X4_50 in OpenCV's enumeration
constexpr double kPixels_m = 2000.0;  // of the drawn board per metre

// The pose of a board: p_camera = turn p_board + shift, the board's x to the right, y up, its top
// left at the origin.
struct BoardPose {
  Matrix3d turn = Matrix3d::Identity();
  Vector3d shift_m{0, 0, 0};
};

// A board that faces the camera from a direction and distance, rotated a little.
BoardPose facing(double yaw_rad, double pitch_rad, double distance_m, double roll_rad,
                 double slant_rad) {
  const Matrix3d towards = world_from_camera({yaw_rad, pitch_rad, roll_rad});
  const Matrix3d turn = towards * world_from_camera({slant_rad, 0.5 * slant_rad, 0});
  const Vector3d middle_m(0.0005 * kBoard.squares_x * kBoard.square_mm,
                          -0.0005 * kBoard.squares_y * kBoard.square_mm, 0.0);
  return {turn, towards * Vector3d(0, 0, distance_m) - turn * middle_m};
}

cv::Mat drawn_board() {
  const CharucoMarkers markers({kBoard.squares_x, kBoard.squares_y},
                               static_cast<float>(0.001 * kBoard.square_mm),
                               static_cast<float>(0.001 * kBoard.marker_mm), kDictionary);
  return markers.draw({static_cast<int>(kBoard.squares_x * 0.001 * kBoard.square_mm * kPixels_m),
                       static_cast<int>(kBoard.squares_y * 0.001 * kBoard.square_mm * kPixels_m)});
}

// The level of the point that a ray hits: on the board, or the grey of the room.
double level_on_ray(const cv::Mat& board, const BoardPose& pose, const Vector3d& lens_m,
                    const Vector3d& direction) {
  constexpr double kRoom = 120.0;
  const Vector3d from = pose.turn.transpose() * (lens_m - pose.shift_m);
  const Vector3d along = pose.turn.transpose() * direction;
  const double distance = -from.z() / along.z();
  if (!(distance > 0.0)) return kRoom;
  const Vector3d hit = from + distance * along;
  const int u = static_cast<int>(std::floor(hit.x() * kPixels_m));
  const int v = static_cast<int>(std::floor(-hit.y() * kPixels_m));
  if (u < 0 || v < 0 || u >= board.cols || v >= board.rows) return kRoom;
  return board.at<uchar>(v, u);
}

// Rays cast through the true lenses, several per pixel.
cv::Mat picture_of(const cv::Mat& board, const BoardPose& pose, const DualFisheyeLayout& lenses) {
  constexpr int kParts = 2;
  const Matrix3d camera_from_back = world_from_camera(lenses.back_attitude);
  cv::Mat picture(kBoardPicture.height, kBoardPicture.width, CV_8UC3, cv::Scalar::all(0));
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      const bool back = 2 * u >= picture.cols;
      double sum = 0.0;
      for (int part = 0; part < kParts * kParts; ++part) {
        const PixelPosition at{u + (part % kParts + 0.5) / kParts - 0.5,
                               v + (part / kParts + 0.5) / kParts - 0.5};
        const auto direction = unproject(back ? lenses.back : lenses.front, at);
        if (!direction) continue;
        sum += level_on_ray(board, pose, back ? lenses.back_position_m : lenses.front_position_m,
                            back ? Vector3d(camera_from_back * *direction) : *direction);
      }
      picture.at<cv::Vec3b>(v, u) =
          cv::Vec3b::all(cv::saturate_cast<uchar>(sum / (kParts * kParts)));
    }
  }
  return picture;
}

// Boards all over both image circles, and eight around the overlap of the lenses.
std::vector<BoardPose> all_around() {
  std::vector<BoardPose> poses;
  for (const double yaw_rad : {0.0, kPi}) {
    poses.push_back(facing(yaw_rad, 0.1, 0.35, 0.0, 0.2));
    poses.push_back(facing(yaw_rad + 0.8, 0.0, 0.35, 0.3, -0.3));
    poses.push_back(facing(yaw_rad - 0.8, 0.3, 0.4, -0.2, 0.3));
    poses.push_back(facing(yaw_rad, 0.8, 0.35, 0.1, 0.2));
    poses.push_back(facing(yaw_rad, -0.8, 0.35, 0.1, 0.2));
  }
  for (int i = 0; i < 8; ++i) {
    const Vector3d side(std::cos(kTwoPi * i / 8), std::sin(kTwoPi * i / 8), 0.0);
    const SphereAngles at = angles_from_direction(side);
    const double slant_rad = i % 2 == 0 ? 0.2 : -0.2;
    poses.push_back(facing(at.theta_rad, at.phi_rad, 0.35, 0.1 * i, slant_rad));
  }
  return poses;
}

// A capture of board pictures through the true lenses.
struct BoardPictures {
  TestDirectory directory{};
  LensOptions options{};

  explicit BoardPictures(const std::vector<BoardPose>& poses) {
    options.board = kBoard;
    options.out = directory / "out";
    options.start = directory / "start.yaml";
    write_lens_file(options.start, plain_camera(kBoardPicture));
    const cv::Mat board = drawn_board();
    for (const BoardPose& pose : poses) {
      options.board_pictures.push_back(
          directory / ("board" + std::to_string(options.board_pictures.size()) + ".png"));
      write_image(options.board_pictures.back(),
                  picture_of(board, pose, true_camera(kBoardPicture).layout));
    }
  }
};

TEST(CharucoTest, RecoversLensesFromPicturesOfABoard) {
  const BoardPictures pictures(all_around());
  const DualFisheyeCamera truth = true_camera(kBoardPicture);
  const LensFit fit = calibrate_lens({}, pictures.options);
  EXPECT_LT(imaging_difference_px(fit.camera.layout, truth.layout), 0.3);
  EXPECT_TRUE(fit.trustworthy());
  EXPECT_TRUE(fit.back_pose_fitted);
  EXPECT_GT(fit.overlap_points, 50);
  const DualFisheyeCamera written = read_lens_file(pictures.options.out / "lens.yaml");
  EXPECT_LT(imaging_difference_px(written.layout, fit.camera.layout), 1e-9);
  EXPECT_EQ(nlohmann::json::parse(read_file(pictures.options.out / "lens.json"))["method"],
            "charuco");
}

TEST(CharucoTest, TooFewPicturesOfABoardAreRefusedWithAdvice) {
  BoardPictures pictures({facing(0.0, 0.1, 0.35, 0.0, 0.2)});
  const auto complaint = [&] {
    try {
      calibrate_lens({}, pictures.options);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(complaint(),
              AllOf(HasSubstr("corners of the board in all"), HasSubstr("add pictures")));
  pictures.options.board->dictionary = "DICT_6X6_250";
  EXPECT_THAT(complaint(), AllOf(HasSubstr("front lens sees 0 corners"), HasSubstr("dictionary")));
}

}  // namespace
}  // namespace raywalk::calibrate
