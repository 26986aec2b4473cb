#include "build_lf/quality/frame_checks.h"

#include <gmock/gmock.h>
#include <hdf5.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/quality/colour_comparison.h"
#include "core/base/error.h"
#include "core/room/hdf5_file.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::ThrowsMessage;

FrameChecks checks_of(const Room& room, double reach_m = 0.5) {
  const auto links = measure_links(room, pairs_to_compare(room.grid()));
  return check_frames(room, links, reach_m);
}

std::vector<std::string> described(const FrameChecks& checks) {
  std::vector<std::string> texts;
  for (const FrameFinding& finding : checks.frames) {
    texts.push_back(finding.file + " " + std::string(name_of(finding.fault)) + " " +
                    std::to_string(finding.measure));
  }
  return texts;
}

class SoundRoom : public ::testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(SoundRoom, HasNoFindings) {
  const auto [scale, noise] = GetParam();
  const SyntheticRoomSpec spec = line_of_scale(scale, static_cast<unsigned>(10.0 * scale));
  const DepthTestRoom room(spec, [deviation = noise](StationIndex station, cv::Mat* frame) {
    add_noise(station, deviation, frame);
  });
  const FrameChecks checks = checks_of(room.room(), 0.5 * scale);
  EXPECT_THAT(described(checks), IsEmpty());
  EXPECT_THAT(checks.lines, IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(ScalesAndNoise, SoundRoom,
                         ::testing::Combine(::testing::Values(0.2, 1.0, 5.0),
                                            ::testing::Values(0.0, 3.0)));

// A frame as seen from elsewhere than its station.
cv::Mat seen_from(const Eigen::Vector3d& position_m) {
  const SyntheticRoomSpec spec = line_of_scale(1.0);
  return render_scene(spec.scene, position_m, spec.width);
}
cv::Mat seen_from_station(size_t station) {
  return seen_from(synthetic_grid(line_of_scale(1.0)).lines[0].stations[station].position_m);
}

// Edits some frames of a line, and what is found of them.
struct FaultyLine {
  std::string name{};
  DepthTestRoom::Edit edit{};
  FrameFault fault = FrameFault::kSameFile;
  std::vector<int> stations{};
  std::vector<int> others{};       // that each is compared with; empty: a neighbour
  double least = 0.0, most = 0.0;  // the measure of the first
};

using Edit = DepthTestRoom::Edit;

Edit copied(int to, size_t from) {
  return [=](StationIndex station, cv::Mat* frame) {
    if (station.station == to) *frame = seen_from_station(from);
  };
}

// Noise makes the files differ.
Edit standing_still_from(int first, int end) {
  return [=](StationIndex station, cv::Mat* frame) {
    const int s = station.station;
    if (s > first && s < end) *frame = seen_from_station(static_cast<size_t>(first));
    add_noise(station, 2.0, frame);
  };
}

Edit obstructed(int wrong) {
  return [=](StationIndex station, cv::Mat* frame) {
    if (station.station != wrong) return;
    cv::rectangle(*frame, {30, 20}, {45, 40}, cv::Scalar(20, 40, 30), cv::FILLED);
  };
}

Edit misplaced(int wrong) {
  return [=](StationIndex station, cv::Mat* frame) {
    if (station.station == wrong) *frame = seen_from({0.1, 0.0, 0.7});
  };
}

Edit darker_from(int first, const cv::Scalar& factors) {
  return [=](StationIndex station, cv::Mat* frame) {
    if (station.station >= first) cv::multiply(*frame, factors, *frame);
  };
}

std::vector<FaultyLine> faulty_lines() {
  using enum FrameFault;
  constexpr double kAny = 1e9, kSpacing_m = 0.0625;
  const double unlike = std::sqrt(2.0);
  return {
      {"CopiedFile", copied(6, 5), kSameFile, {6}, {5}, kSpacing_m - 1e-12, kSpacing_m + 1e-12},
      {"StandingCamera", standing_still_from(8, 12), kNotMoved, {9, 10, 11}, {8, 9, 10}, 0, 0.5},
      {"Obstruction", obstructed(11), kUnlikeNeighbours, {11}, {}, unlike, kAny},
      {"MisplacedFrame", misplaced(7), kUnlikeNeighbours, {7}, {}, unlike, kAny},
      {"MisplacedFirst", misplaced(0), kUnlikeNeighbours, {0}, {}, unlike, kAny},
      {"MisplacedLast", misplaced(16), kUnlikeNeighbours, {16}, {}, unlike, kAny},
      {"ExposureStep", darker_from(10, cv::Scalar::all(0.8)), kExposureStep, {10}, {9}, 0.79, 0.81},
      {"StepOfOneColour", darker_from(10, {0.8, 1, 1}), kExposureStep, {10}, {9}, 0.79, 0.81},
  };
}

class FaultyLineTest : public ::testing::TestWithParam<FaultyLine> {};

TEST_P(FaultyLineTest, IsFound) {
  const FaultyLine& line = GetParam();
  const DepthTestRoom room(line_of_scale(1.0), line.edit);
  ASSERT_THAT(room.grid().lines[0].stations, SizeIs(17));
  const FrameChecks checks = checks_of(room.room());
  ASSERT_THAT(checks.frames, SizeIs(line.stations.size()))
      << ::testing::PrintToString(described(checks));
  for (size_t i = 0; i < line.stations.size(); ++i) {
    const FrameFinding& found = checks.frames[i];
    EXPECT_EQ(found.fault, line.fault);
    EXPECT_EQ(found.station, (StationIndex{0, line.stations[i]}));
    EXPECT_EQ(found.file, room.grid().station(found.station).file);
    if (line.others.empty()) continue;
    EXPECT_EQ(found.other, (StationIndex{0, line.others[i]}));
  }
  EXPECT_GE(checks.frames[0].measure, line.least);
  EXPECT_LE(checks.frames[0].measure, line.most);
  if (line.fault != FrameFault::kExposureStep) return;
  EXPECT_EQ(checks.largest_exposure_step, checks.frames[0].measure);
}

INSTANTIATE_TEST_SUITE_P(Lines, FaultyLineTest, ::testing::ValuesIn(faulty_lines()),
                         [](const auto& line) { return line.param.name; });

// Stations close together see almost the same, which is not a fault.
TEST(FrameChecksTest, AcceptStationsCloseTogether) {
  const SyntheticRoomSpec spec = line_of_scale(1.0);
  Grid grid = synthetic_grid(spec);
  for (Line& line : grid.lines) {
    Station& moved = line.stations[8];
    const Station& before = line.stations[7];
    moved.along_m = before.along_m + 0.1 * (moved.along_m - before.along_m);
    moved.position_m = before.position_m + 0.1 * (moved.position_m - before.position_m);
  }
  const DepthTestRoom room(spec, grid, nullptr);
  EXPECT_THAT(described(checks_of(room.room())), IsEmpty());
}

// A camera's lenses may differ in exposure, and differently at every station.
TEST(FrameChecksTest, AcceptExposuresThatDifferOnlyInPartsOfThePicture) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const DepthTestRoom room(
        line_of_scale(1.0, seed), [seed](StationIndex station, cv::Mat* frame) {
          cv::RNG random(1000 * seed + static_cast<unsigned>(station.station) + 1);
          for (int quarter = 0; quarter < 4; ++quarter) {
            const int width = frame->cols / 4;
            cv::Mat part = frame->colRange(quarter * width, (quarter + 1) * width);
            part *= 0.9 + random.gaussian(0.1);
          }
        });
    const FrameChecks checks = checks_of(room.room());
    for (const FrameFinding& finding : checks.frames) {
      EXPECT_EQ(finding.fault, FrameFault::kExposureStep)
          << ::testing::PrintToString(described(checks));
    }
  }
}

TEST(FrameChecksTest, FindLinesTooShortForDistances) {
  SyntheticRoomSpec spec = line_of_scale(1.0);
  spec.width = 64;
  spec.spacing_m = 1.0;  // a line of 1 m with its two ends only
  const DepthTestRoom room(spec);
  EXPECT_THAT(checks_of(room.room(), 2.0).lines, IsEmpty());
  const auto is_fault = [](LineFault fault, double needed_m) {
    return AllOf(Field(&LineFinding::fault, fault), Field(&LineFinding::measure_m, DoubleEq(1.0)),
                 Field(&LineFinding::needed_m, DoubleEq(needed_m)));
  };
  EXPECT_THAT(checks_of(room.room(), 4.5).lines,
              ElementsAre(is_fault(LineFault::kTooShort, 1.125)));
  EXPECT_THAT(checks_of(room.room(), 0.5).lines, ElementsAre(is_fault(LineFault::kTooSparse, 0.5)));
}

TEST(FrameChecksTest, WorkWithoutChecksumsAndContrast) {
  SyntheticRoomSpec spec = line_of_scale(1.0);
  spec.width = 64;
  spec.scene.contrast = 0.0;
  spec.distances = false;
  const TestDirectory directory;
  write_synthetic_room(spec, directory / "room");
  EXPECT_THAT(described(checks_of(Room::open(directory / "room"))), IsEmpty());
}

TEST(FrameChecksTest, RejectChecksumsOfOtherStations) {
  SyntheticRoomSpec spec = line_of_scale(1.0);
  spec.width = 32;
  const DepthTestRoom room(spec);
  const auto file = line_volume_path(room.room().directory(), "x0");
  // Beside it first, as the room has the file mapped.
  const auto beside = std::filesystem::path(file).replace_extension(".other");
  Hdf5File other = Hdf5File::create(beside);
  other.write_strings("sha256", {std::string(64, 'a')});
  other.close();
  std::filesystem::rename(beside, file);
  EXPECT_THAT([&] { checks_of(room.room()); },
              ThrowsMessage<Error>(HasSubstr("x0.h5: holds 1 checksums for 17 stations")));
}

// Every warning names the files, the measurement and the consequence.
TEST(FrameWarningsTest, NameFaultFilesAndConsequence) {
  SyntheticRoomSpec spec = room_of_scale(1.0);
  spec.width = 32;
  const DepthTestRoom room(spec);
  const FrameChecks checks{
      {{{0, 6}, "x0_006.png", FrameFault::kSameFile, {1, 5}, 0.0625},
       {{0, 9}, "x0_009.png", FrameFault::kNotMoved, {0, 8}, 0.1},
       {{2, 3}, "z0_003.png", FrameFault::kUnlikeNeighbours, {2, 4}, 3.21},
       {{3, 1}, "z1_001.png", FrameFault::kExposureStep, {3, 0}, 1.3}},
      {{0, LineFault::kTooShort, 0.05, 0.125}, {3, LineFault::kTooSparse, 0.75, 0.5}}};
  EXPECT_THAT(warnings_of(room.room(), checks),
              ElementsAre(AllOf(HasSubstr("x0_006.png is a copy of x1_005.png"),
                                HasSubstr("0.062 m"), HasSubstr("not used")),
                          AllOf(HasSubstr("x0_009.png"), HasSubstr("x0_008.png"),
                                HasSubstr("not to have moved"), HasSubstr("not used")),
                          AllOf(HasSubstr("z0_003.png differs from z0_004.png"),
                                HasSubstr("3.2 times"), HasSubstr("not used")),
                          AllOf(HasSubstr("z1_001.png"), HasSubstr("1.30 times that of z1_000.png"),
                                HasSubstr("scaled")),
                          AllOf(HasSubstr("line x0"), HasSubstr("0.050 m"), HasSubstr("0.125 m")),
                          AllOf(HasSubstr("line z1"), HasSubstr("0.750 m"), HasSubstr("0.500 m"))));
  EXPECT_THAT(warnings_of(room.room(), {}), IsEmpty());
}

// Patches of varying brightness in three colours, shifted by `shift_px` rows, with noise.
ComparedPicture picture_of(double exposure, unsigned noise_seed, double shift_px = 0.0) {
  std::mt19937 random(noise_seed);
  std::normal_distribution<double> noise(0.0, 0.5);
  cv::Mat picture(kComparisonWidth, kComparisonWidth / 2, CV_8UC3);
  for (const auto [v, u] : pixels_of({picture.cols, picture.rows})) {
    const double patch =
        0.2 + 0.15 * std::sin(16.0 * 2.0 * M_PI * (u - shift_px) / 256.0) * std::cos(0.27 * v);
    for (int c = 0; c < 3; ++c) {
      const double light = patch * (1.0 + 0.2 * c) * exposure;
      picture.at<cv::Vec3b>(u, v)[c] = cv::saturate_cast<uchar>(255.0 * light + noise(random));
    }
  }
  return {.colours = picture};
}

// Also for ratios far below one level, which must not be lost to rounding.
TEST(ColourComparisonTest, RatioIsThatOfTheLevels) {
  for (const double exposure : {0.7, 0.99, 1.002, 1.0, 1.3}) {
    const ColourComparison compared = compare_colours(picture_of(1.0, 1), picture_of(exposure, 2));
    ASSERT_TRUE(compared.comparable);
    for (const double log_ratio : compared.log_ratio) {
      EXPECT_NEAR(log_ratio, std::log(exposure), 0.0025) << exposure;
    }
  }
}

TEST(ColourComparisonTest, MotionIsCompensated) {
  const ColourComparison compared = compare_colours(picture_of(1.0, 1), picture_of(1.1, 2, 2.0));
  ASSERT_TRUE(compared.comparable);
  EXPECT_NEAR(compared.log_ratio[1], std::log(1.1), 0.01);
  EXPECT_LT(compared.unexplained_change, 0.5 * compared.change);
}

TEST(ColourComparisonTest, MaskedAndClippedPixelsAreIgnored) {
  const ComparedPicture first = picture_of(1.0, 1);
  ComparedPicture second = picture_of(1.2, 2);
  // Two thirds of the picture, enough to change a median.
  second.colours.colRange(40, 128) = cv::Scalar(140, 140, 140);
  const auto log_ratio = [&] { return compare_colours(first, second).log_ratio[0]; };
  EXPECT_GT(std::abs(log_ratio() - std::log(1.2)), 0.05);
  second.valid = cv::Mat(256, 128, CV_8UC1, cv::Scalar(255));
  second.valid.colRange(30, 128) = cv::Scalar(0);
  EXPECT_NEAR(log_ratio(), std::log(1.2), 0.005);
  second.valid = cv::Scalar(0);
  EXPECT_FALSE(compare_colours(first, second).comparable);
  second.valid.release();
  second.colours = cv::Scalar(255, 255, 255);
  EXPECT_FALSE(compare_colours(first, second).comparable);
}

}  // namespace
}  // namespace raywalk::build_lf
