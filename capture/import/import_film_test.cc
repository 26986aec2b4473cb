#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "capture/import/import.h"
#include "capture/import/test_film.h"
#include "capture/session/session_database.h"
#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

constexpr double kApproach_mm = 5.0;

// A filmed session of one line, eleven stations 40 mm apart. Its film starts at an unknown time
// before the carriage does.
class ImportFilmTest : public testing::Test {
 protected:
  void SetUp() override {
    capture_.directory = directory_ / "session";
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
  void film_line(const std::function<bool(double position_mm)>& blurred = {}) {
    record("x0", pass_);
    shoot({.start_s = kFilmStart_s,
           .length_s = pass_.end_s() - kFilmStart_s + 2.0,
           .blurred = blurred});
  }
  void shoot(const TestFilm& film) {
    shoot_test_film(film_, film, [&](double time_s) { return pass_.position_mm(time_s); });
  }
  ImportResult import(const FilmImportOptions& options = {}) {
    return import_film(capture_.directory, film_, options, &capture_.clock);
  }
  std::string error_of_import(const FilmImportOptions& options = {}) {
    return error_of([&] { import(options); });
  }
  SessionContents contents() { return SessionReader(capture_.directory).contents(); }

  static constexpr double kFilmStart_s = 27.813;
  TestDirectory directory_;
  TestCapture capture_;
  const fs::path film_ = directory_ / "film.avi";
  TestPass pass_{};  // over the line that is filmed
};

TEST_F(ImportFilmTest, EveryStationGetsAFrameWithItsTruePosition) {
  film_line();
  const ImportResult result = import({.format = "png"});
  EXPECT_EQ(result.imported, 11U);
  EXPECT_THAT(result.summary,
              AllOf(HasSubstr("11 stations imported"), HasSubstr("the film starts at")));
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

TEST_F(ImportFilmTest, BlurredFramesAreSkipped) {
  const double station_mm = capture_.plan.lines[0].stations[5].rail_mm;
  film_line([&](double position_mm) { return std::abs(position_mm - station_mm) < 2.5; });
  const ImportResult result = import();
  EXPECT_EQ(result.imported, 11U);
  EXPECT_THAT(result.summary, HasSubstr("blurred frames skipped: 1"));
  const double off_mm = std::abs(contents().stations[5].shot->measured_mm - station_mm);
  EXPECT_GT(off_mm, 2.2);
  EXPECT_LT(off_mm, 4.5);
}

TEST_F(ImportFilmTest, AFilmShorterThanThePassListsTheMissingStations) {
  record("x0", pass_);
  shoot({.start_s = kFilmStart_s, .length_s = 8.5});
  EXPECT_THAT(error_of_import(),
              AllOf(HasSubstr("does not show"), HasSubstr("x0_010"), HasSubstr("--allow-missing")));
  EXPECT_TRUE(contents().frames.empty());
  const ImportResult result = import({.allow_missing = true});
  EXPECT_GT(result.imported, 3U);
  EXPECT_LT(result.imported, 11U);
  EXPECT_THAT(result.summary, HasSubstr("x0_010"));
}

TEST_F(ImportFilmTest, TwoEqualLinesRequireTheLineOption) {
  capture_.plan.lines.push_back(test_line("x1", LineAxis::kX, -0.5, -0.2, 0.04, 11));
  film_line();
  record("x1", pass_over(capture_.plan.lines[1], 90.0));
  EXPECT_THAT(error_of_import(),
              AllOf(HasSubstr("at two times, 60.0 s apart"), HasSubstr("--line")));
  EXPECT_EQ(import({.line = "x0"}).imported, 11U);
  const SessionContents captured = contents();
  for (const SessionFrame& frame : captured.frames) {
    EXPECT_EQ(captured.line_of(captured.station_of(frame)).id, "x0");
  }
}

TEST_F(ImportFilmTest, WhatCannotBeImportedIsNamed) {
  { const auto session = capture_.open(); }
  shoot({.length_s = 1.0});
  EXPECT_THAT(error_of_import(), AllOf(HasSubstr("no journal"), HasSubstr("run.mode: video")));
  film_line();
  EXPECT_THAT(error_of_import({.line = "x7"}), AllOf(HasSubstr("no line x7"), HasSubstr("x0")));
  shoot({.start_s = 0.0, .length_s = 10.0});
  EXPECT_THAT(error_of_import(), HasSubstr("no start or stop of motion"));
  shoot({.start_s = kFilmStart_s, .length_s = 14.0, .size = {160, 96}});
  EXPECT_THAT(error_of_import(), AllOf(HasSubstr("160 x 96"), HasSubstr("stitch")));
}

}  // namespace
}  // namespace raywalk::capture
