// Fitting lenses to the frames of a capture: which stations are used, how they moved, the fit.
#include "calibrate/lens/calibrate_lens.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <random>
#include <set>

#include "calibrate/base/test_lines.h"
#include "calibrate/lens/lens_test_camera.h"
#include "calibrate/lens/motion_check.h"
#include "calibrate/lens/station_choice.h"
#include "core/files/image_file.h"
#include "core/files/test_json.h"
#include "core/files/test_support.h"
#include "simulator/room/sensor.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::calibrate {
namespace {

using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;

constexpr PanoramaSize kCapturedPicture{560, 280};

// Two lines, one along each axis, each off the plan, of a furnished room, taken once for all tests.
struct Capture {
  TestDirectory directory{};
  CaptureSet set{.layout = FrameLayout::kDualFisheye, .frame = kCapturedPicture};

  Capture() {
    add_test_line(&set, "x0", LineAxis::kX, -0.5, 1.2, 5);
    add_test_line(&set, "z0", LineAxis::kZ, 0.5, 1.2, 5);
    const simulator::VirtualRoom room((simulator::VirtualRoomSettings()));
    const DualFisheyeLayout lenses = true_camera(kCapturedPicture).layout;
    for (std::size_t i = 0; i < set.frames.size(); ++i) {
      CaptureFrame& frame = set.frames[i];
      const std::size_t number = i % 5;
      const double sign = frame.line == 0 ? 1.0 : -1.0;
      const Attitude placed{radians_from_degrees(sign * 1.1), radians_from_degrees(-0.4 * sign),
                            radians_from_degrees(0.7 + 0.1 * static_cast<double>(number))};
      simulator::CameraPose pose{frame.nominal_m + Vector3d(0.012, -0.006 * sign, 0.009), placed};
      // The rail itself is turned.
      pose.position_m[frame.line == 0 ? 2 : 0] += sign * 0.01 * set.rail_m(i);
      const cv::Mat clean = room.render(simulator::DualFisheyeRays(lenses, kCapturedPicture), pose);
      frame.file = directory / (frame.name + ".png");
      write_image(frame.file,
                  simulator::apply_sensor(clean, {1.0, 0.01, 0.0}, 1.0, 10 * frame.line + number));
    }
  }
};

const Capture& capture() {
  static const Capture taken;
  return taken;
}

TEST(CaptureFitTest, RecoversLensesFromTheFramesOfACapture) {
  const DualFisheyeCamera start = plain_camera(kCapturedPicture),
                          truth = true_camera(kCapturedPicture);
  ASSERT_GT(imaging_difference_px(start.layout, truth.layout), 1.5);
  const LensFit fit = fit_to_capture(capture().set, start, {.pairs = 10});
  EXPECT_LT(imaging_difference_px(fit.camera.layout, truth.layout), 0.3);
  EXPECT_LT(fit.residual_px, 0.4);
  EXPECT_LT(fit.sigma.worst_px(), 0.3);
  EXPECT_GT(fit.overlap_points, 20);
  EXPECT_TRUE(fit.trustworthy());
  // The field of view is seen in the pictures, the start has 95 degrees.
  for (const FisheyeLens& lens : {fit.camera.layout.front, fit.camera.layout.back}) {
    EXPECT_NEAR(degrees_from_radians(lens.largest_angle_rad), 97.0, 0.5);
  }
  EXPECT_EQ(fit.pictures, 10);
  EXPECT_EQ(static_cast<int>(fit.residuals.size()), fit.observations);
}

// The same capture with every picture changed.
template <typename Change>
CaptureSet changed_pictures(const TestDirectory& directory, const Change& change) {
  CaptureSet set = capture().set;
  for (CaptureFrame& frame : set.frames) {
    const cv::Mat picture = change(read_picture(frame.file));
    frame.file = directory / (frame.name + ".png");
    write_image(frame.file, picture);
  }
  return set;
}

// Pictures that contradict the plan, or show nothing to go by.
TEST(CaptureFitTest, OtherPicturesAreRefusedWithAdvice) {
  const auto complaint = [](const CaptureSet& set, const DualFisheyeCamera& start) {
    return error_of([&] { fit_to_capture(set, start, {.pairs = 10}); });
  };
  const TestDirectory directory;
  const DualFisheyeCamera start = plain_camera(kCapturedPicture);
  const CaptureSet mirrored = changed_pictures(directory, [](const cv::Mat& picture) {
    // Each half by itself, as a camera would that flips what its sensors see.
    cv::Mat flipped(picture.size(), picture.type());
    for (const int half : {0, 1}) {
      const cv::Rect area(half * picture.cols / 2, 0, picture.cols / 2, picture.rows);
      cv::Mat target = flipped(area);
      cv::flip(picture(area), target, 1);
    }
    return flipped;
  });
  EXPECT_THAT(complaint(mirrored, start), HasSubstr("mirrored"));
  DualFisheyeCamera swapped = start;
  std::swap(swapped.layout.front, swapped.layout.back);
  EXPECT_THAT(complaint(capture().set, swapped), HasSubstr("swapped"));
  const CaptureSet plain = changed_pictures(directory, [](const cv::Mat& picture) {
    return cv::Mat(picture.size(), picture.type(), cv::Scalar(90, 100, 110));
  });
  EXPECT_THAT(complaint(plain, start),
              AllOf(HasSubstr("only 0 features"), HasSubstr("more texture")));
}

// `lines` of each axis, `stations` each, 5 cm apart.
CaptureSet grid_of(int along_x, int along_z, int stations) {
  CaptureSet set;
  for (int line = 0; line < along_x + along_z; ++line) {
    const bool is_x = line < along_x;
    add_test_line(&set, std::to_string(line), is_x ? LineAxis::kX : LineAxis::kZ,
                  0.5 * (is_x ? line : line - along_x), 0.05 * (stations - 1), stations);
  }
  return set;
}

TEST(StationChoiceTest, EveryLineHasItsEndsAndMiddle) {
  const CaptureSet set = grid_of(2, 2, 31);
  const std::vector<std::size_t> chosen = choose_stations(set, 24);
  EXPECT_THAT(chosen, ::testing::SizeIs(24));
  EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
  for (int line = 0; line < 4; ++line) {
    EXPECT_THAT(chosen, ::testing::IsSupersetOf({31 * line, 31 * line + 15 - 3, 31 * line + 30}));
  }
}

TEST(StationChoiceTest, FewStationsAreOnFewLinesButOfBothAxes) {
  for (const auto& [along_x, along_z] : {std::pair(3, 2), {1, 6}, {6, 1}, {20, 20}}) {
    const CaptureSet set = grid_of(along_x, along_z, 9);
    std::set<LineAxis> axes;
    std::set<int> lines;
    for (const std::size_t frame : choose_stations(set, 10)) {
      lines.insert(set.frames[frame].line);
      axes.insert(set.lines[*lines.rbegin()].axis);
    }
    EXPECT_EQ(lines.size(), 2U);
    EXPECT_EQ(axes.size(), 2U);
  }
}

TEST(StationChoiceTest, ShortCapturesAreUsedWhole) {
  EXPECT_THAT(choose_stations(grid_of(1, 0, 4), 24), ::testing::ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(choose_stations(grid_of(1, 1, 2), 24), ::testing::SizeIs(4));
  EXPECT_THAT(choose_stations(CaptureSet{}, 24), ::testing::IsEmpty());
}

Vector3d random_direction(std::mt19937_64* random) {
  std::normal_distribution<double> normal;
  return Vector3d(normal(*random), normal(*random), normal(*random)).normalized();
}

// Points two metres away, seen before and after a motion; a share of the matches is wrong.
std::vector<BearingPair> seen_around(const Vector3d& motion_m, double wrong_share,
                                     std::mt19937_64* random) {
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const Eigen::Matrix3d turn = world_from_camera({0.02, -0.01, 0.015});
  std::vector<BearingPair> seen;
  for (int i = 0; i < 300; ++i) {
    const Vector3d before = random_direction(random);
    Vector3d after = turn * (2.0 * before - motion_m).normalized();
    if (share(*random) < wrong_share)
      after = (before + 0.3 * random_direction(random)).normalized();
    seen.push_back({before, after});
  }
  return seen;
}

TEST(MotionCheckTest, DirectionIsRobustToWrongMatchesAndRotations) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20; ++i) {
    const Vector3d motion = random_direction(&random);
    const auto seen = motion_direction(seen_around(0.3 * motion, 0.3, &random));
    ASSERT_TRUE(seen);
    EXPECT_GT(seen->dot(motion), std::cos(radians_from_degrees(20.0)));
  }
  // Without agreement there is none.
  EXPECT_FALSE(motion_direction(seen_around({0.3, 0, 0}, 1.0, &random)));
  EXPECT_FALSE(motion_direction({}));
}

TEST(MotionCheckTest, ErrorsNameTheCause) {
  const auto complaint = [](const std::vector<MotionComparison>& motions) {
    return error_of([&] { require_motion_as_planned(motions); });
  };
  const Vector3d x = Vector3d::UnitX(), z = Vector3d::UnitZ();
  const Vector3d slanted = Vector3d(1, 0, 0.4).normalized();
  EXPECT_EQ(complaint({{x, slanted}, {z, z}}), "no error");
  EXPECT_EQ(complaint({}), "no error");
  EXPECT_THAT(complaint({{x, -x}, {z, -z}}), HasSubstr("swapped"));
  EXPECT_THAT(complaint({{x, -x}, {z, z}}), HasSubstr("mirrored"));
  EXPECT_THAT(complaint({{x, x}, {z, -z}}), HasSubstr("mirrored"));
  EXPECT_THAT(complaint({{x, z}, {z, -x}}), HasSubstr("90 degrees"));
}

class CalibrateLensTest : public ::testing::Test {
 protected:
  CalibrateLensTest() {
    write_lens_file(options_.start, plain_camera({640, 320}));
    set_.lines = {{"x0", LineAxis::kX, 0.0, false, {0}}};
    set_.frames.emplace_back();
  }
  std::string complaint() const {
    return error_of([&] { calibrate_lens(set_, options_); });
  }

  TestDirectory directory_;
  CaptureSet set_{.source = "somewhere", .layout = FrameLayout::kDualFisheye, .frame = {640, 320}};
  LensOptions options_{.start = directory_ / "start.yaml", .out = directory_ / "out"};
};

TEST_F(CalibrateLensTest, PanoramasAndStartsOfOtherCamerasAreRefused) {
  set_.layout = FrameLayout::kPanorama;
  EXPECT_THAT(complaint(), AllOf(HasSubstr("somewhere"), HasSubstr("panoramas already")));
  EXPECT_EQ(directory_.entries(), 1U);  // nothing written
  set_.layout = FrameLayout::kDualFisheye;
  set_.frame = {640, 360};
  EXPECT_THAT(complaint(), HasSubstr("another aspect ratio"));
  set_.frame = {640, 320};
  set_.frames.front().back = "back.jpg";
  EXPECT_THAT(complaint(), AllOf(HasSubstr("start.yaml"), HasSubstr("one file")));
  options_.start = directory_ / "none.yaml";
  EXPECT_THAT(complaint(), HasSubstr("none.yaml"));
}

TEST_F(CalibrateLensTest, InvalidOptionsAreUsageErrors) {
  options_.pairs = 5;
  EXPECT_THROW(calibrate_lens(set_, options_), UsageError);
  options_.pairs = 24;
  for (const double cone_deg : {-1.0, 90.0, std::nan("")}) {
    options_.ignore_below_deg = cone_deg;
    EXPECT_THROW(calibrate_lens(set_, options_), UsageError) << cone_deg;
  }
}

// Residuals that point outwards by 0.5 px in a ring of the front lens.
LensFit fit_with_residuals() {
  LensFit fit;
  fit.start = plain_camera({1120, 560});
  fit.camera = true_camera({1120, 560});
  fit.sigma.front.focal_px = 0.02;
  fit.dropped_still = 17;
  const FisheyeLens& lens = fit.camera.layout.front;
  for (int i = 0; i < 12; ++i) {
    const double around_rad = kTwoPi * i / 12;
    const double off_axis_rad = radians_from_degrees(62.0);
    const PixelPosition seen = *project(lens, at_angle(off_axis_rad, around_rad));
    fit.residuals.push_back({false, seen, 0.5 * std::cos(around_rad), -0.5 * std::sin(around_rad)});
  }
  fit.observations = 12;
  return fit;
}

TEST(LensReportTest, JsonHoldsStartFittedValuesAndErrorsOfTheRadialModel) {
  const LensFit fit = fit_with_residuals();
  const nlohmann::json json = lens_document(fit);
  expect_keys(json["front"]["focal_px"], {{"start", fit.start.layout.front.focal_px},
                                          {"fitted", fit.camera.layout.front.focal_px},
                                          {"sigma", 0.02}});
  EXPECT_TRUE(json["front"]["largest_angle_deg"]["sigma"].is_null());
  // 180.4 and -179.6 degrees are the same yaw: the one nearer to the start's is reported.
  EXPECT_NEAR(json["back"]["yaw_deg"]["fitted"], 180.4, 1e-9);
  EXPECT_NEAR(json["baseline_mm"]["z"]["fitted"], -10.0, 1e-9);
  expect_keys(json, {{"dropped_still", 17}, {"trustworthy", true}});
  const auto& rings = json["residuals_over_angle"];
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_NEAR(rings[0]["off_axis_deg"], 62.5, 1e-9);
  EXPECT_EQ(rings[0]["count"], 12);
  EXPECT_NEAR(rings[0]["rms_px"], 0.5, 1e-9);
  EXPECT_NEAR(rings[0]["radial_px"], 0.5, 1e-9);
}

TEST(LensReportTest, FiguresShowTheResidualsOfEachLens) {
  const TestDirectory out;
  const nlohmann::ordered_json figures = residual_figures(fit_with_residuals(), out.path());
  ASSERT_EQ(figures.size(), 2U);
  EXPECT_THAT(figures[0]["caption"], testing::StartsWith("front lens: 12 image points"));
  const auto ink = [&](int lens) {
    const cv::Mat image = read_picture(out / figures[lens]["file"].get<std::string>());
    return cv::norm(image, cv::Mat(image.size(), CV_8UC3, cv::Scalar(255, 255, 255)), cv::NORM_L1);
  };
  EXPECT_GT(ink(0), 1.05 * ink(1));  // both have a rim
  EXPECT_EQ(residual_figures(LensFit{}, out.path()).size(), 2U);
}

}  // namespace
}  // namespace raywalk::calibrate
