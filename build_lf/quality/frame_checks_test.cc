#include "build_lf/quality/frame_checks.h"

#include <gmock/gmock.h>
#include <hdf5.h>

#include <opencv2/imgproc.hpp>

#include "build_lf/depth/depth_test_room.h"
#include "core/base/error.h"
#include "core/room/hdf5_file.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::ThrowsMessage;

FrameChecks checks_of(const Room& room, double reach_m = 0.5) {
  const auto links = measure_links(room, pairs_to_compare(room.grid()));
  return check_frames(room, links, reach_m);
}

// A finding without its measure.
MATCHER_P3(Finds, station, fault, other, "") {
  return arg.station == station && arg.fault == fault && arg.other == other;
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

TEST(FrameChecksTest, FindACopiedFile) {
  const SyntheticRoomSpec spec = line_of_scale(1.0);
  const Grid grid = synthetic_grid(spec);
  const DepthTestRoom room(spec, [&](StationIndex station, cv::Mat* frame) {
    if (station == StationIndex{0, 6}) {
      *frame = render_scene(spec.scene, grid.lines[0].stations[5].position_m, spec.width);
    }
  });
  const FrameChecks checks = checks_of(room.room());
  ASSERT_THAT(checks.frames,
              ElementsAre(Finds(StationIndex{0, 6}, FrameFault::kSameFile, StationIndex{0, 5})));
  EXPECT_EQ(checks.frames[0].file, "x0_006.png");
  EXPECT_NEAR(checks.frames[0].measure, 0.0625, 1e-12);
}

TEST(FrameChecksTest, FindACameraThatDidNotMove) {
  const SyntheticRoomSpec spec = line_of_scale(1.0);
  const Grid grid = synthetic_grid(spec);
  // The camera does not move for three stations; noise makes the files differ.
  const DepthTestRoom room(spec, [&](StationIndex station, cv::Mat* frame) {
    if (station.station >= 9 && station.station < 12) {
      *frame = render_scene(spec.scene, grid.lines[0].stations[8].position_m, spec.width);
    }
    add_noise(station, 2.0, frame);
  });
  const FrameChecks checks = checks_of(room.room());
  ASSERT_THAT(checks.frames,
              ElementsAre(Finds(StationIndex{0, 9}, FrameFault::kNotMoved, StationIndex{0, 8}),
                          Finds(StationIndex{0, 10}, FrameFault::kNotMoved, StationIndex{0, 9}),
                          Finds(StationIndex{0, 11}, FrameFault::kNotMoved, StationIndex{0, 10})));
  EXPECT_LT(checks.frames[0].measure, 0.5);
}

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

TEST(FrameChecksTest, FindAnObstructedFrame) {
  const DepthTestRoom room(line_of_scale(1.0), [](StationIndex station, cv::Mat* frame) {
    if (station == StationIndex{0, 11}) {
      cv::rectangle(*frame, {30, 20}, {45, 40}, cv::Scalar(20, 40, 30), cv::FILLED);
    }
  });
  const FrameChecks checks = checks_of(room.room());
  ASSERT_THAT(checks.frames, SizeIs(1)) << ::testing::PrintToString(described(checks));
  EXPECT_EQ(checks.frames[0].station, (StationIndex{0, 11}));
  EXPECT_EQ(checks.frames[0].fault, FrameFault::kUnlikeNeighbours);
  EXPECT_GT(checks.frames[0].measure, std::sqrt(2.0));
}

TEST(FrameChecksTest, FindAMisplacedFrameAlsoAtTheEnds) {
  for (const int wrong : {0, 7, 16}) {
    const SyntheticRoomSpec spec = line_of_scale(1.0);
    ASSERT_EQ(synthetic_grid(spec).lines[0].stations.size(), 17);
    const DepthTestRoom room(spec, [&](StationIndex station, cv::Mat* frame) {
      if (station == StationIndex{0, wrong}) {
        *frame = render_scene(spec.scene, {0.1, 0.0, 0.7}, spec.width);
      }
    });
    const FrameChecks checks = checks_of(room.room());
    ASSERT_THAT(checks.frames, SizeIs(1)) << wrong << ::testing::PrintToString(described(checks));
    EXPECT_EQ(checks.frames[0].station, (StationIndex{0, wrong}));
    EXPECT_EQ(checks.frames[0].fault, FrameFault::kUnlikeNeighbours);
  }
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

TEST(FrameChecksTest, FindAnExposureStep) {
  const DepthTestRoom room(line_of_scale(1.0), [](StationIndex station, cv::Mat* frame) {
    if (station.station >= 10) *frame *= 0.8;
  });
  const FrameChecks checks = checks_of(room.room());
  ASSERT_THAT(checks.frames, ElementsAre(Finds(StationIndex{0, 10}, FrameFault::kExposureStep,
                                               StationIndex{0, 9})));
  EXPECT_NEAR(checks.frames[0].measure, 0.8, 0.01);
  EXPECT_EQ(checks.largest_exposure_step, checks.frames[0].measure);
}

TEST(FrameChecksTest, FindAStepOfOneColour) {
  const DepthTestRoom room(line_of_scale(1.0), [](StationIndex station, cv::Mat* frame) {
    if (station.station >= 10) cv::multiply(*frame, cv::Scalar(0.8, 1.0, 1.0), *frame);
  });
  const FrameChecks checks = checks_of(room.room());
  ASSERT_THAT(checks.frames, ElementsAre(Finds(StationIndex{0, 10}, FrameFault::kExposureStep,
                                               StationIndex{0, 9})));
  EXPECT_NEAR(checks.frames[0].measure, 0.8, 0.01);
}

TEST(FrameChecksTest, FindLinesTooShortForDistances) {
  SyntheticRoomSpec spec = line_of_scale(1.0);
  spec.width = 64;
  spec.spacing_m = 1.0;  // a line of 1 m with its two ends only
  const DepthTestRoom room(spec);
  EXPECT_THAT(checks_of(room.room(), 2.0).lines, IsEmpty());
  const FrameChecks short_line = checks_of(room.room(), 4.5);
  ASSERT_THAT(short_line.lines, SizeIs(1));
  EXPECT_EQ(short_line.lines[0].fault, LineFault::kTooShort);
  EXPECT_DOUBLE_EQ(short_line.lines[0].measure_m, 1.0);
  EXPECT_DOUBLE_EQ(short_line.lines[0].needed_m, 1.125);
  const FrameChecks sparse_line = checks_of(room.room(), 0.5);
  ASSERT_THAT(sparse_line.lines, SizeIs(1));
  EXPECT_EQ(sparse_line.lines[0].fault, LineFault::kTooSparse);
  EXPECT_DOUBLE_EQ(sparse_line.lines[0].measure_m, 1.0);
  EXPECT_DOUBLE_EQ(sparse_line.lines[0].needed_m, 0.5);
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
  {
    Hdf5File other = Hdf5File::create(beside);
    other.write_strings("sha256", {std::string(64, 'a')});
    other.close();
  }
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

}  // namespace
}  // namespace raywalk::build_lf
