#include "capture/import/film_track.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgproc.hpp>

#include "capture/import/test_film.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

class FilmTrackTest : public testing::Test {
 protected:
  TestDirectory directory_;
  const std::filesystem::path film_ = directory_ / "film.avi";
};

TEST_F(FilmTrackTest, FramesComeInOrderWithTheirTimes) {
  shoot_test_film(film_, {.rate_hz = 20.0, .length_s = 2.0}, [](double) { return 0.0; });
  std::size_t frames = 0;
  read_film(film_, [&](const DecodedFrame& frame) {
    EXPECT_EQ(frame.number, frames);
    EXPECT_NEAR(frame.time_s, 0.05 * static_cast<double>(frames), 1e-3);
    EXPECT_EQ(frame.picture.size(), cv::Size(160, 80));
    ++frames;
    return true;
  });
  EXPECT_EQ(frames, 40U);
}

// As a user names it, relative to the folder; FFmpeg takes a scheme's name for that of an address.
TEST_F(FilmTrackTest, AFilmMayHaveAnyName) {
  const auto before = std::filesystem::current_path();
  shoot_test_film(film_, {.length_s = 1.0}, [](double) { return 0.0; });
  std::filesystem::current_path(directory_.path());
  for (const char* name : {"hall:1.avi", "line %02d.avi", "rtsp:film", "'x0' \xc3\xbc?.avi"}) {
    std::filesystem::copy_file(film_, name);
    EXPECT_EQ(track_film(name).frames.size(), 25U) << name;
  }
  std::filesystem::current_path(before);
}

TEST_F(FilmTrackTest, ABlurredFrameStandsOutAmongItsNeighbours) {
  const auto is_blurred = [](double frame) { return std::lround(frame) % 30 == 20; };
  shoot_test_film(film_,
                  {.length_s = 3.0,
                   .blurred = [&](double position_mm) { return is_blurred(position_mm / 1.6); }},
                  [](double time_s) { return 40.0 * time_s; });
  const std::vector<bool> blurred = blurred_frames(track_film(film_));
  ASSERT_EQ(blurred.size(), 75U);
  for (std::size_t i = 0; i < blurred.size(); ++i) {
    EXPECT_EQ(blurred[i], is_blurred(static_cast<double>(i))) << i;
  }
}

TEST_F(FilmTrackTest, ASmoothSceneIsNotBlurred) {
  FilmTrack track;
  for (int i = 0; i < 100; ++i) {
    track.frames.push_back({0.04 * i, 1.0, 100.0 * std::exp(-0.03 * i)});  // texture decreases
  }
  EXPECT_THAT(blurred_frames(track), testing::Each(false));
}

TEST_F(FilmTrackTest, AFileThatIsNotAFilmIsRefused) {
  EXPECT_THAT([&] { track_film(film_); }, ThrowsMessage<Error>(HasSubstr("no such file")));
  std::ofstream(film_) << "<!DOCTYPE html>";
  EXPECT_THAT([&] { track_film(film_); }, ThrowsMessage<Error>(HasSubstr("not a film")));
  std::ofstream(film_, std::ios::trunc).close();
  EXPECT_THAT([&] { track_film(film_); }, ThrowsMessage<Error>(HasSubstr("film.avi")));
}

TEST_F(FilmTrackTest, ATruncatedFilmGivesItsRemainingFrames) {
  shoot_test_film(film_, {.length_s = 2.0}, [](double) { return 0.0; });
  const std::string whole = read_file(film_);
  std::ofstream(film_, std::ios::binary | std::ios::trunc) << whole.substr(0, whole.size() / 2);
  const FilmTrack track = track_film(film_);
  EXPECT_GT(track.frames.size(), 10U);
  EXPECT_LT(track.frames.size(), 40U);
}

}  // namespace
}  // namespace raywalk::capture
