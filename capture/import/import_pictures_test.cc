#include <fmt/chrono.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "capture/import/import.h"
#include "capture/import/test_pictures.h"
#include "capture/session/session_database.h"
#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;

// Four lines of five stations, captured with a camera that keeps its pictures on its card and whose
// clock is a little over two hours ahead.
class ImportPicturesTest : public testing::Test {
 protected:
  void SetUp() override {
    capture_.directory = directory_ / "session";
    capture_.plan.lines.clear();
    for (const std::string id : {"x0", "x1", "z0", "z1"}) {
      const LineAxis axis = id[0] == 'x' ? LineAxis::kX : LineAxis::kZ;
      capture_.plan.lines.push_back(test_line(id, axis, id[1] - '0' - 0.5, -1.0, 0.5, 5));
    }
    capture_.config.camera.kind = CameraKind::kGpio;
    const auto session = capture_.open();
    for (const CaptureLine& line : capture_.plan.lines) {
      capture_.clock.sleep(120s);
      for (const CaptureStation& station : line.stations) {
        capture_.capture(session.get(), station);
        taken_.emplace_back(station.name, capture_.clock.wall_now());
      }
    }
    fs::create_directories(card_);
  }

  // The default card: one picture per station.
  void fill_card() {
    for (const auto& [station, time] : taken_) write_picture("R_" + station + ".JPG", time);
  }
  void write_picture(const std::string& name, WallTime time, int width = 64) {
    write_test_picture(card_ / name, width, width / 2, 40 + next_level_++);
    write_test_exif(card_ / name, {{0x9003, exif_text(time)}});
  }
  static std::string exif_text(WallTime time) {
    return fmt::format("{:%Y:%m:%d %H:%M:%S}",
                       std::chrono::floor<std::chrono::seconds>(time + 7203s));
  }
  ImportResult import(bool allow_missing = false, const std::string& first_station = "") {
    const std::vector<fs::path> given{card_};
    return import_pictures(capture_.directory, given, allow_missing, &capture_.clock,
                           first_station);
  }
  std::string error_of_import() {
    return error_of([&] { import(); });
  }
  SessionContents contents() { return SessionReader(capture_.directory).contents(); }
  std::size_t captured() { return contents().frames.size(); }

  TestDirectory directory_;
  TestCapture capture_;
  fs::path card_ = directory_ / "card";
  std::vector<std::pair<std::string, WallTime>> taken_;
  int next_level_ = 0;
};

TEST_F(ImportPicturesTest, EveryStationGetsItsOwnPictureWithItsChecksum) {
  fill_card();
  const ImportResult result = import();
  EXPECT_EQ(result.imported, 20U);
  EXPECT_THAT(result.summary, AllOf(HasSubstr("20 stations imported"), HasSubstr("+7203.")));
  const SessionContents imported = contents();
  ASSERT_EQ(imported.frames.size(), 20U);
  for (const SessionFrame& frame : imported.frames) {
    const std::string bytes = read_file(capture_.directory / frame.file);
    EXPECT_EQ(bytes, read_file(card_ / ("R_" + imported.station_of(frame).name + ".JPG")));
    EXPECT_EQ(frame.sha256, sha256_hex(bytes));
  }
  const ImportResult again = import();
  EXPECT_EQ(again.imported, 0U);
  EXPECT_EQ(again.already_there, 20U);
  EXPECT_EQ(captured(), 20U);
  write_picture("R_x1_000.JPG", taken_[5].second);
  EXPECT_THAT(error_of_import(), HasSubstr("R_x1_000.JPG: is assigned to x1_000, which already"));
}

TEST_F(ImportPicturesTest, APictureOfAnotherKindThanTheFramesIsRefusedBeforeAnyIsImported) {
  fill_card();
  write_test_circles(card_ / "R_z0_000.JPG");
  write_test_exif(card_ / "R_z0_000.JPG", {{0x9003, exif_text(taken_[10].second)}});
  EXPECT_THAT(error_of_import(), AllOf(HasSubstr("R_z0_000.JPG shows two fisheye circles"),
                                       HasSubstr("camera.frames is panorama")));
  EXPECT_EQ(captured(), 0U);
}

TEST_F(ImportPicturesTest, AnImportInterruptedBetweenFileAndRowResumes) {
  fill_card();
  fs::copy(card_ / "R_x0_000.JPG", capture_.directory / "frames" / "x0_000.jpg");
  EXPECT_EQ(import().imported, 20U);
  EXPECT_EQ(captured(), 20U);
}

TEST_F(ImportPicturesTest, AMissingPictureIsRefusedUnlessAllowed) {
  fill_card();
  fs::remove(card_ / "R_x1_004.JPG");
  EXPECT_THAT(error_of_import(), AllOf(HasSubstr("1 of 20 stations lack pictures: x1_004"),
                                       HasSubstr("--allow-missing")));
  EXPECT_EQ(captured(), 0U);
  const ImportResult result = import(true);
  EXPECT_EQ(result.imported, 19U);
  EXPECT_THAT(result.summary, HasSubstr("x1_004"));
  write_picture("R_x1_004.JPG", taken_[9].second);
  EXPECT_EQ(taken_[9].first, "x1_004");
  EXPECT_EQ(import().imported, 1U);
}

TEST_F(ImportPicturesTest, APictureIsAssignedByHandWhateverItsTime) {
  write_picture("LATER.jpg", taken_[9].second + 12h);
  fs::rename(card_ / "LATER.jpg", card_ / "LATER.insp");
  const ImportResult result = import(false, "x1_004");
  EXPECT_THAT(result.summary, AllOf(HasSubstr("1 stations imported"), HasSubstr("by the names")));
  const SessionContents imported = contents();
  ASSERT_EQ(imported.frames.size(), 1U);
  EXPECT_EQ(imported.station_of(imported.frames[0]).name, "x1_004");
  EXPECT_TRUE(imported.frames[0].file.ends_with(".jpg"));
}

TEST_F(ImportPicturesTest, APictureOfAnInterruptedAttemptIsLeftOut) {
  fill_card();
  {
    const auto session = capture_.open();
    capture_.clock.sleep(60s);
    EXPECT_TRUE(session->is_captured("x0_000"));
    session->fail_attempt(session->begin_attempt("x0_000", 50.0), "interrupted", "Ctrl-C");
  }
  write_picture("TRY.JPG", capture_.clock.wall_now());
  const ImportResult result = import();
  EXPECT_EQ(result.imported, 20U);
  EXPECT_THAT(result.summary, HasSubstr("pictures of failed attempts left out: 1"));
}

TEST_F(ImportPicturesTest, FrontAndBackBecomeTwoFramesOfAStation) {
  for (const auto& [station, time] : taken_) {
    write_picture("GPFR_" + station + ".JPG", time);
    write_picture("GPBK_" + station + ".JPG", time);
  }
  EXPECT_EQ(import().imported, 20U);
  const SessionContents imported = contents();
  const std::vector<SessionFrame>& frames = imported.frames;
  ASSERT_EQ(frames.size(), 40U);
  EXPECT_NE(frames[0].lens, frames[1].lens);
  EXPECT_EQ(frames[0].station, frames[1].station);
  const bool front = frames[0].lens == FrameLens::kFront;
  EXPECT_EQ(read_file(capture_.directory / frames[0].file),
            read_file(card_ / ((front ? "GPFR_" : "GPBK_") + imported.station_of(frames[0]).name +
                               ".JPG")));
}

TEST_F(ImportPicturesTest, ATruncatedPictureOrOneOfAnotherSizeIsNamedAndTheImportCanResume) {
  fill_card();
  const std::string name = "R_x0_003.JPG";
  const std::string whole = read_file(card_ / name);
  std::ofstream(card_ / name, std::ios::binary) << whole.substr(0, whole.size() - 20);
  EXPECT_THAT(error_of_import(), HasSubstr(name));
  EXPECT_EQ(captured(), 3U);
  std::ofstream(card_ / name, std::ios::binary) << whole;
  write_picture("R_x1_000.JPG", taken_[5].second, 128);
  EXPECT_THAT(error_of_import(), AllOf(HasSubstr("R_x1_000.JPG"), HasSubstr("128")));
  write_picture("R_x1_000.JPG", taken_[5].second);
  EXPECT_EQ(import().imported, 15U);
}

TEST_F(ImportPicturesTest, ASessionWhoseCameraSentItsPicturesIsRefused) {
  fill_card();
  TestCapture other;
  other.directory = directory_ / "other";
  other.plan = short_plan();
  { const auto session = other.open(); }
  const std::vector<fs::path> given{card_};
  EXPECT_THAT(error_of([&] { import_pictures(other.directory, given, false, &other.clock); }),
              HasSubstr("osc camera sent its pictures during the run"));
  EXPECT_THAT(error_of([&] { import_pictures(directory_ / "none", given, false, &other.clock); }),
              HasSubstr("none"));
}

}  // namespace
}  // namespace raywalk::capture
