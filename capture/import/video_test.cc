#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <random>
#include <vector>

#include "capture/import/import.h"
#include "capture/import/video_stations.h"
#include "capture/import/video_track.h"
#include "capture/session/session.h"
#include "capture/session/test_session.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::AllOf;
using testing::DoubleNear;
using testing::Gt;
using testing::HasSubstr;
using testing::Lt;
using testing::Optional;
using testing::SizeIs;
using testing::ThrowsMessage;

// --- A pass of the carriage along a line, its journal, and a video shot from it ------------------

// From rest to rest at constant acceleration and speed.
struct TestPass {
  double start_s = 0.0;  // when it begins to move
  double from_mm = 0.0;
  double to_mm = 400.0;
  double speed_mm_s = 40.0;
  double acceleration_mm_s2 = 100.0;

  double end_s() const {
    return start_s + (to_mm - from_mm) / speed_mm_s + speed_mm_s / acceleration_mm_s2;
  }
  double position_mm(double time_s) const {
    const double ramp_s = speed_mm_s / acceleration_mm_s2;
    const double since_s = std::clamp(time_s - start_s, 0.0, end_s() - start_s);
    const double left_s = end_s() - start_s - since_s;
    if (since_s < ramp_s) return from_mm + 0.5 * acceleration_mm_s2 * since_s * since_s;
    if (left_s < ramp_s) return to_mm - 0.5 * acceleration_mm_s2 * left_s * left_s;
    return from_mm + speed_mm_s * (since_s - 0.5 * ramp_s);
  }
  // Samples every 20 ms until 0.3 s after the end.
  std::vector<JournalSample> journal(WallTime epoch) const {
    std::vector<JournalSample> samples;
    for (double time_s = start_s; time_s < end_s() + 0.3; time_s += 0.02) {
      const Duration since{std::llround(time_s * 1e9)};
      samples.push_back(
          {epoch + std::chrono::duration_cast<WallTime::duration>(since), position_mm(time_s)});
    }
    return samples;
  }
};

// A scene that shifts as the carriage moves, one pixel per millimetre, with sensor noise.
class TestScene {
 public:
  explicit TestScene(cv::Size size) : size_(size), random_(17) {
    cv::Mat noise(size.height, 8 * size.width, CV_8UC3);
    random_.fill(noise, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(noise, surrounding_, cv::Size(0, 0), 1.5);
    cv::normalize(surrounding_, surrounding_, 0, 255, cv::NORM_MINMAX);
  }

  cv::Mat picture(double position_mm) {
    const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, -position_mm, 0, 1, 0);
    cv::Mat seen;
    cv::warpAffine(surrounding_, seen, shift, size_, cv::INTER_LINEAR, cv::BORDER_WRAP);
    cv::Mat noise(size_, CV_16SC3);
    random_.fill(noise, cv::RNG::NORMAL, 0, 2);
    cv::add(seen, noise, seen, cv::noArray(), CV_8UC3);
    return seen;
  }

 private:
  cv::Size size_;
  cv::Mat surrounding_;
  cv::RNG random_;
};

struct TestVideo {
  double rate_hz = 25.0;
  double start_s = 0.0;  // when its first frame is exposed
  double length_s = 0.0;
  cv::Size size{160, 80};
  std::function<bool(double position_mm)> blurred{};
};

// Shoots a video (MJPG in AVI) of a carriage that is at `position_mm(time)`.
void shoot_test_video(const std::filesystem::path& file, const TestVideo& video,
                      const std::function<double(double time_s)>& position_mm) {
  cv::VideoWriter writer(file.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), video.rate_hz,
                         video.size);
  TestScene scene(video.size);
  const auto frames = static_cast<std::size_t>(video.length_s * video.rate_hz);
  for (std::size_t i = 0; i < frames; ++i) {
    const double time_s = video.start_s + static_cast<double>(i) / video.rate_hz;
    const double along_mm = position_mm(time_s);
    cv::Mat picture = scene.picture(along_mm);
    if (video.blurred && video.blurred(along_mm)) cv::blur(picture, picture, cv::Size(9, 1));
    writer.write(picture);
  }
}

// --- What a video shows --------------------------------------------------------------------------

class VideoTrackTest : public testing::Test {
 protected:
  TestDirectory directory_;
  const std::filesystem::path video_ = directory_ / "video.avi";
};

// As a user names it, relative to the folder; FFmpeg takes a scheme's name for that of an address.
TEST_F(VideoTrackTest, AVideoMayHaveAnyName) {
  const auto before = std::filesystem::current_path();
  shoot_test_video(video_, {.length_s = 1.0}, [](double) { return 0.0; });
  std::filesystem::current_path(directory_.path());
  for (const char* name : {"hall:1.avi", "line %02d.avi", "rtsp:video", "'x0' \xc3\xbc?.avi"}) {
    std::filesystem::copy_file(video_, name);
    EXPECT_EQ(track_video(name).frames.size(), 25U) << name;
  }
  std::filesystem::current_path(before);
}

TEST_F(VideoTrackTest, ASmoothSceneIsNotBlurred) {
  VideoTrack track;
  for (int i = 0; i < 100; ++i) {
    track.frames.push_back({0.04 * i, 1.0, 100.0 * std::exp(-0.03 * i)});  // texture decreases
  }
  EXPECT_THAT(blurred_frames(track), testing::Each(false));
}

TEST_F(VideoTrackTest, AFileThatIsNotAVideoIsRefused) {
  EXPECT_THAT([&] { track_video(video_); }, ThrowsMessage<Error>(HasSubstr("no such file")));
  std::ofstream(video_) << "<!DOCTYPE html>";
  EXPECT_THAT([&] { track_video(video_); }, ThrowsMessage<Error>(HasSubstr("not a video")));
  std::ofstream(video_, std::ios::trunc).close();
  EXPECT_THAT([&] { track_video(video_); }, ThrowsMessage<Error>(HasSubstr("video.avi")));
}

TEST_F(VideoTrackTest, ATruncatedVideoGivesItsRemainingFrames) {
  shoot_test_video(video_, {.length_s = 2.0}, [](double) { return 0.0; });
  const std::string whole = read_file(video_);
  std::ofstream(video_, std::ios::binary | std::ios::trunc) << whole.substr(0, whole.size() / 2);
  EXPECT_THAT(track_video(video_).frames, SizeIs(AllOf(Gt(10U), Lt(40U))));
}

const WallTime kEpoch = std::chrono::sys_days{std::chrono::year{2026} / 5 / 1};

// --- Its frames at the stations ------------------------------------------------------------------

TEST(Travel, AGapSplitsTheJournalAndSamplesOutOfOrderAreDropped) {
  const std::vector<JournalSample> journal{
      {kEpoch, 0.0},       {kEpoch + 500ms, 5.0}, {kEpoch + 200ms, 99.0}, {kEpoch + 500ms, 99.0},
      {kEpoch + 1s, 10.0}, {kEpoch + 40s, 77.0},  {kEpoch + 90s, 0.0},    {kEpoch + 90500ms, 7.0}};
  const auto travels = travels_of("z1", journal, kEpoch);
  ASSERT_EQ(travels.size(), 2U);  // none of a single sample
  EXPECT_EQ(travels[0].line, "z1");
  EXPECT_THAT(travels[0].position_mm(0.25), Optional(DoubleNear(2.5, 1e-9)));
  EXPECT_THAT(travels[0].position_mm(0.75), Optional(DoubleNear(7.5, 1e-9)));
  EXPECT_THAT(travels[1].position_mm(90.25), Optional(DoubleNear(3.5, 1e-9)));
  EXPECT_FALSE(travels[0].position_mm(45.0));
  EXPECT_TRUE(travels_of("x0", {}, kEpoch).empty());
}

// The track of a video of some passes, without pictures: activity is proportional to the distance
// between two frames and varies along the line with the scene.
struct TrackSettings {
  double offset_s = 0.0;  // journal time minus video time
  double length_s = 20.0;
  double rate_hz = 25.0;
  double noise = 0.1;      // of the activity, in grey levels
  double variation = 0.0;  // relative variation of activity with the scene
  std::uint32_t seed = 1;
};

VideoTrack track_of(const std::vector<TestPass>& passes, const TrackSettings& settings) {
  std::mt19937 random(settings.seed);
  std::normal_distribution<double> noise(0.0, settings.noise);
  VideoTrack track;
  const double step_s = 1.0 / settings.rate_hz;
  for (int i = 0; i * step_s < settings.length_s; ++i) {
    const double now_s = i * step_s + settings.offset_s;
    double moved_mm = 0.0;
    double along_mm = 0.0;
    for (const TestPass& pass : passes) {
      moved_mm += pass.position_mm(now_s) - pass.position_mm(now_s - step_s);
      along_mm += pass.position_mm(now_s);
    }
    const double scene = 1.0 + settings.variation * std::sin(0.05 * along_mm + settings.seed);
    track.frames.push_back(
        {i * step_s, std::max(0.0, 1.5 + 8.0 * moved_mm * scene + noise(random)), 100.0});
  }
  return track;
}

VideoClock match(const VideoTrack& track, const std::vector<TestPass>& passes) {
  std::vector<Travel> travels;
  for (const TestPass& pass : passes) {
    for (const Travel& each : travels_of("x0", pass.journal(kEpoch), kEpoch)) {
      travels.push_back(each);
    }
  }
  return match_video_clock(track, travels, "video.mp4");
}

TEST(VideoClock, TheOffsetIsFoundFromStartsAndStops) {
  struct Case {
    const char* what;
    std::vector<TestPass> passes;
    TrackSettings video;
    double within_s;
  };
  const std::vector<Case> cases{
      {"one pass", {{.start_s = 100.0}}, {.offset_s = 97.654, .length_s = 16.0}, 0.008},
      {"a video that ends before the pass",
       {{.start_s = 100.0, .to_mm = 1200.0}},
       {.offset_s = 98.2, .length_s = 15.0},
       0.02},
      {"two passes told apart by their pause",
       {{.start_s = 100.0}, {.start_s = 130.0}},
       {.offset_s = 98.0, .length_s = 46.0},
       0.008},
  };
  for (const auto& [what, passes, video, within_s] : cases) {
    const VideoClock clock = match(track_of(passes, video), passes);
    EXPECT_NEAR(clock.offset_s, video.offset_s, within_s) << what;
    EXPECT_LT(clock.uncertainty_s, 0.04) << what;
  }
}

TEST(VideoClock, AVideoOfSomethingElseOrTooShortIsRefused) {
  const std::vector<TestPass> passes{{.start_s = 100.0, .to_mm = 1200.0}};
  const std::vector<TestPass> others{{.start_s = 103.0, .to_mm = 60.0},
                                     {.start_s = 106.0, .to_mm = 40.0},
                                     {.start_s = 112.0, .to_mm = 100.0},
                                     {.start_s = 122.0, .to_mm = 30.0}};
  const VideoTrack other = track_of(others, {.offset_s = 100.0, .length_s = 30.0});
  EXPECT_THAT([&] { match(other, passes); },
              ThrowsMessage<Error>(HasSubstr("video.mp4: the motion, with 8 starts and stops, does "
                                             "not fit the journal")));
  const VideoTrack glimpse = track_of(passes, {.offset_s = 98.0, .length_s = 0.3});
  EXPECT_THAT([&] { match(glimpse, passes); }, ThrowsMessage<Error>(HasSubstr("too few")));
}

TEST(VideoStations, AClockTooUncertainToTellStationsApartIsRefused) {
  const TestPass pass{.start_s = 100.0};
  SessionContents contents{.lines = {{.id = "x0"}}};
  for (const double planned_mm : {100.0, 104.0, 108.0}) {
    contents.stations.push_back({.name = "x0", .planned_mm = planned_mm});
  }
  const auto travels = travels_of("x0", pass.journal(kEpoch), kEpoch);
  const VideoTrack track = track_of({pass}, {.offset_s = 98.0, .length_s = 14.0});
  const auto found = [&](double uncertainty_s) {
    return find_station_frames(contents, track, travels, {98.0, uncertainty_s}, "video.mp4").found;
  };
  EXPECT_EQ(found(0.04).size(), 3U);  // at 40 mm/s
  EXPECT_THAT([&] { found(0.06); },
              ThrowsMessage<Error>(HasSubstr("known to 0.06 s, or 2.4 mm of travel")));
}

TEST(VideoClockProperty, TheOffsetLiesWithinItsUncertaintyOrIsRefused) {
  int found = 0;
  constexpr int kVideos = 40;
  for (std::uint32_t seed = 0; seed < kVideos; ++seed) {
    std::mt19937 random(seed);
    const auto between = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    TestPass pass{.start_s = between(0.0, 1e4)};
    pass.to_mm = between(200.0, 1500.0);
    pass.speed_mm_s = std::exp(between(std::log(10.0), std::log(80.0)));
    const double before_s = between(0.5, 4.0);
    TrackSettings settings{.offset_s = pass.start_s - before_s, .seed = seed};
    settings.length_s = before_s + pass.end_s() - pass.start_s + between(0.5, 4.0);
    settings.rate_hz = seed % 2 == 0 ? 24.0 : 29.97;
    settings.noise = std::exp(between(std::log(0.01), std::log(0.5)));
    settings.variation = between(0.0, 0.6);
    try {
      const VideoClock clock = match(track_of({pass}, settings), {pass});
      ++found;
      // 95 % of errors are within the uncertainty; one more frame interval of margin is still far
      // from a wrong match.
      EXPECT_NEAR(clock.offset_s, settings.offset_s, 2.0 * clock.uncertainty_s + 0.01)
          << "seed " << seed;
    } catch (const Error&) {
      continue;
    }
  }
  EXPECT_GT(found, kVideos * 3 / 4);
}

// --- The import ----------------------------------------------------------------------------------

constexpr double kApproach_mm = 5.0;

// A recorded session of one line, eleven stations 40 mm apart. Its video starts at an unknown time
// before the carriage does.
class ImportVideoTest : public SessionCase {
 protected:
  void SetUp() override {
    capture_.config.run.mode = CaptureMode::kVideo;
    capture_.plan.lines = {test_line("x0", LineAxis::kX, 0.5, -0.2, 0.04, 11)};
    pass_ = pass_over(capture_.plan.lines[0], 30.0);
  }

  TestPass pass_over(const CaptureLine& line, double start_s) const {
    return {.start_s = start_s,
            .from_mm = line.stations.front().rail_mm - kApproach_mm,
            .to_mm = line.stations.back().rail_mm + kApproach_mm};
  }
  void record(const std::string& line, const TestPass& pass) {
    const auto session = capture_.open();
    session->record_journal(line, pass.journal(capture_.clock.wall_now()));
  }
  // The usual: one line, from two seconds before its pass until two after.
  void shoot_line(const std::function<bool(double position_mm)>& blurred = {}) {
    record("x0", pass_);
    shoot({.start_s = kVideoStart_s,
           .length_s = pass_.end_s() - kVideoStart_s + 2.0,
           .blurred = blurred});
  }
  void shoot(const TestVideo& video) {
    shoot_test_video(video_, video, [&](double time_s) { return pass_.position_mm(time_s); });
  }
  ImportResult import(const VideoImportOptions& options = {}) {
    return import_video(capture_.directory, video_, options, &capture_.clock);
  }
  std::string error_of_import(const VideoImportOptions& options = {}) {
    return error_of([&] { import(options); });
  }

  static constexpr double kVideoStart_s = 27.813;
  const fs::path video_ = directory_ / "video.avi";
  TestPass pass_{};  // over the line that is recorded
};

TEST_F(ImportVideoTest, EveryStationGetsAFrameWithItsTruePosition) {
  shoot_line();
  const ImportResult result = import({.format = "png"});
  EXPECT_EQ(result.imported, 11U);
  EXPECT_THAT(result.summary,
              AllOf(HasSubstr("11 stations imported"), HasSubstr("the video starts at")));
  const WallTime created = SessionReader(capture_.directory).facts().created;
  TestScene scene({160, 80});
  const SessionContents captured = contents();
  ASSERT_EQ(captured.frames.size(), captured.stations.size());
  for (const SessionFrame& stored : captured.frames) {
    const SessionStation& station = captured.station_of(stored);
    const SessionShot& shot = station.shot.value();
    // 40 mm/s at 25 frames per second is 1.6 mm from frame to frame.
    EXPECT_NEAR(shot.measured_mm, station.planned_mm, 0.8 + 0.1) << station.name;
    const WallTime exposed_at = wall_time_from(shot.exposed_utc_us.value());
    const double exposed_s = std::chrono::duration<double>(exposed_at - created).count();
    EXPECT_NEAR(pass_.position_mm(exposed_s), shot.measured_mm, 0.4) << station.name;
    EXPECT_NEAR(stored.position_m.x_m, -0.2 + 1e-3 * (shot.measured_mm - kTestFirst_mm), 1e-9);
    EXPECT_TRUE(stored.file.ends_with(".png"));
    const cv::Mat frame = cv::imread((capture_.directory / stored.file).string());
    const auto difference = [&](double off_mm) {
      return cv::norm(frame, scene.picture(shot.measured_mm + off_mm), cv::NORM_L1);
    };
    EXPECT_LT(difference(0.0), difference(1.6)) << station.name;
    EXPECT_LT(difference(0.0), difference(-1.6)) << station.name;
  }
  const ImportResult again = import();
  EXPECT_EQ(again.imported, 0U);
  EXPECT_EQ(again.already_there, 11U);
  EXPECT_EQ(contents().frames.size(), 11U);
}

TEST_F(ImportVideoTest, BlurredFramesAreSkipped) {
  const double station_mm = capture_.plan.lines[0].stations[5].rail_mm;
  shoot_line([&](double position_mm) { return std::abs(position_mm - station_mm) < 2.5; });
  const ImportResult result = import();
  EXPECT_EQ(result.imported, 11U);
  EXPECT_THAT(result.summary, HasSubstr("blurred frames skipped: 1"));
  EXPECT_THAT(std::abs(contents().stations[5].shot->measured_mm - station_mm),
              AllOf(Gt(2.2), Lt(4.5)));
}

TEST_F(ImportVideoTest, AVideoShorterThanThePassListsTheMissingStations) {
  record("x0", pass_);
  shoot({.start_s = kVideoStart_s, .length_s = 8.5});
  EXPECT_THAT(error_of_import(),
              AllOf(HasSubstr("does not show"), HasSubstr("x0_010"), HasSubstr("--allow-missing")));
  EXPECT_TRUE(contents().frames.empty());
  const ImportResult result = import({.allow_missing = true});
  EXPECT_THAT(result.imported, AllOf(Gt(3U), Lt(11U)));
  EXPECT_THAT(result.summary, HasSubstr("x0_010"));
}

TEST_F(ImportVideoTest, TwoEqualLinesRequireTheLineOption) {
  capture_.plan.lines.push_back(test_line("x1", LineAxis::kX, -0.5, -0.2, 0.04, 11));
  shoot_line();
  record("x1", pass_over(capture_.plan.lines[1], 90.0));
  EXPECT_THAT(error_of_import(),
              AllOf(HasSubstr("at two times, 60.0 s apart"), HasSubstr("--line")));
  EXPECT_EQ(import({.line = "x0"}).imported, 11U);
  const SessionContents captured = contents();
  for (const SessionFrame& frame : captured.frames) {
    EXPECT_EQ(captured.line_of(captured.station_of(frame)).id, "x0");
  }
}

TEST_F(ImportVideoTest, WhatCannotBeImportedIsNamed) {
  { const auto session = capture_.open(); }
  shoot({.length_s = 1.0});
  EXPECT_THAT(error_of_import(), AllOf(HasSubstr("no journal"), HasSubstr("run.mode: video")));
  shoot_line();
  EXPECT_THAT(error_of_import({.line = "x7"}), AllOf(HasSubstr("no line x7"), HasSubstr("x0")));
  shoot({.start_s = 0.0, .length_s = 10.0});
  EXPECT_THAT(error_of_import(), HasSubstr("no start or stop of motion"));
  shoot({.start_s = kVideoStart_s, .length_s = 14.0, .size = {160, 96}});
  EXPECT_THAT(error_of_import(), AllOf(HasSubstr("160 x 96"), HasSubstr("stitch")));
}

}  // namespace
}  // namespace raywalk::capture
