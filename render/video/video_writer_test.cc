#include "render/video/video_writer.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <random>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"
#include "render/video/test_video.h"
#include "render/video/video_file.h"

namespace raywalk::render {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int kFrames = 8;
const cv::Size kSize{128, 64};

// Colours that a colour matrix can get wrong, and a disc that moves.
cv::Mat frame_of(int index) {
  cv::Mat frame(kSize, CV_8UC3);
  for (int v = 0; v < frame.rows; ++v) {
    for (int u = 0; u < frame.cols; ++u)
      frame.at<cv::Vec3b>(v, u) = cv::Vec3b(2 * u, 4 * v, 255 - 2 * u);
  }
  cv::circle(frame, {20 + 8 * index, 30}, 12, {40, 60, 230}, cv::FILLED, cv::LINE_AA);
  return frame;
}

class VideoWriterTest : public ::testing::Test {
 protected:
  fs::path video(const std::string& extension = ".mp4") const {
    return directory_ / ("video" + extension);
  }
  void write(const VideoSettings& settings, std::optional<StereoMode> stereo) const {
    VideoWriter writer(settings, {kSize, kFrames}, stereo, video(video_extension(settings.codec)));
    for (int i = 0; i < kFrames; ++i) writer.add(frame_of(i));
    writer.finish();
  }
  std::string write_error() const {
    return error_of([&] { write({.fps = 25}, StereoMode::kMono); });
  }
  TestDirectory directory_;
};

TEST_F(VideoWriterTest, EveryCodecIsReadByOthersAsItWasWritten) {
  struct Case {
    VideoCodec codec;
    const char* name;
    const char* pixels;
    double least_psnr_db;
  };
  for (const Case& each : {Case{VideoCodec::kH264, "h264", "yuv420p", 35.0},
                           Case{VideoCodec::kH265, "hevc", "yuv420p", 35.0},
                           Case{VideoCodec::kAv1, "av1", "yuv420p", 35.0},
                           Case{VideoCodec::kProRes, "prores", "yuv422p10le", 38.0}}) {
    SCOPED_TRACE(each.name);
    const VideoSettings settings{.codec = each.codec, .fps = 25};
    const fs::path file = video(video_extension(each.codec));
    write(settings, StereoMode::kMono);
    const auto stream = video_stream(file);
    EXPECT_EQ(stream["codec_name"], each.name);
    EXPECT_EQ(stream["pix_fmt"], each.pixels);
    EXPECT_EQ(stream["r_frame_rate"], "25/1");
    EXPECT_EQ(stream["nb_frames"], std::to_string(kFrames));
    EXPECT_EQ(stream["color_space"], "bt709");
    EXPECT_EQ(side_data(stream, "Spherical Mapping")["projection"], "equirectangular");
    EXPECT_EQ(side_data(stream, "Stereo 3D")["type"], "2D");
    const std::vector<cv::Mat> decoded = video_frames(file, kSize);
    ASSERT_EQ(decoded.size(), static_cast<std::size_t>(kFrames));
    for (int i = 0; i < kFrames; ++i) {
      EXPECT_GT(cv::PSNR(decoded[static_cast<std::size_t>(i)], frame_of(i)), each.least_psnr_db);
    }
    EXPECT_TRUE(read_video(file).by_raywalk);
    fs::remove(file);
    EXPECT_EQ(directory_.entries(), 0U);
  }
}

TEST_F(VideoWriterTest, PlayersMayBeginBeforeAllIsRead) {
  write({}, StereoMode::kMono);
  const std::string bytes = read_file(video());
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
  EXPECT_THAT(bytes, HasSubstr("<GSpherical:ProjectionType>equirectangular<"));
}

TEST_F(VideoWriterTest, FlatVideosAndThoseForTwoEyesSaySo) {
  write({}, std::nullopt);
  EXPECT_TRUE(side_data(video_stream(video()), "Spherical Mapping").empty());
  EXPECT_FALSE(read_video(video()).stereo);
  write({}, StereoMode::kTopBottom);
  EXPECT_EQ(side_data(video_stream(video()), "Stereo 3D")["type"], "top and bottom");
}

TEST_F(VideoWriterTest, OnlyVideosOfRaywalkAreReplaced) {
  write({}, std::nullopt);
  EXPECT_THAT(error_of([&] { require_writable_video(video(), false); }), HasSubstr("--video"));
  require_writable_video(video(), true);
  std::ofstream(video()) << "holiday";
  EXPECT_THAT(error_of([&] { require_writable_video(video(), true); }),
              HasSubstr("not a video of Raywalk's"));
}

TEST_F(VideoWriterTest, SettingsThatDoNotFitAreRefused) {
  const auto error = [](const VideoSettings& settings, const char* file) {
    return error_of([&] { require_video_settings(settings, file); });
  };
  EXPECT_THAT(error({}, "a.mov"), HasSubstr("--codec prores"));
  EXPECT_THAT(error({.codec = VideoCodec::kProRes}, "a.mp4"), HasSubstr("end in .mov"));
  EXPECT_THAT(error({.codec = VideoCodec::kProRes, .crf = 3}, "a.mov"), HasSubstr("leave it out"));
  EXPECT_THAT(error({.crf = 52}, "a.mp4"), HasSubstr("0 to 51"));
  EXPECT_THAT(error_of([&] {
                VideoWriter({}, {{65, 32}, 1}, std::nullopt, video());
              }),
              HasSubstr("two even numbers"));
}

// Sets a variable of the environment for as long as it lives.
class ChangedPath {
 public:
  explicit ChangedPath(const std::string& path) : before_(std::getenv("PATH")) {
    setenv("PATH", path.c_str(), 1);
  }
  ~ChangedPath() { setenv("PATH", before_.c_str(), 1); }

 private:
  std::string before_;
};

TEST_F(VideoWriterTest, AnEncoderThatDiesLeavesNothing) {
  const TestDirectory programs;
  const ChangedPath path(programs.path().string() + ":" + std::getenv("PATH"));
  const auto encoder = [&](const std::string& script) {
    std::ofstream(programs / "ffmpeg") << "#!/bin/sh\n" << script << "\n";
    fs::permissions(programs / "ffmpeg", fs::perms::owner_all);
  };
  encoder("head -c 100000 >/dev/null; echo first >&2; echo 'it hurts' >&2; exit 3");
  EXPECT_THAT(write_error(), AllOf(HasSubstr("video.mp4: ffmpeg failed with exit code 3 after"),
                                   HasSubstr("(it hurts)")));
  encoder("head -c 30000 >/dev/null; kill -9 $$");
  EXPECT_THAT(write_error(), HasSubstr("was killed by signal 9 after"));
  // It says that all went well, but half of the video is missing.
  encoder("cat >/dev/null; for file; do :; done; printf 'nothing' >\"${file#file:}\"");
  EXPECT_THAT(write_error(), HasSubstr("not a complete video"));
  EXPECT_EQ(directory_.entries(), 0U);
  const ChangedPath nowhere("/nowhere");
  EXPECT_THAT(write_error(), HasSubstr("apt install ffmpeg"));
}

TEST_F(VideoWriterTest, AFullDiskLeavesNothing) {
  std::signal(SIGXFSZ, SIG_IGN);  // as the programs do
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{.rlim_cur = 22000, .rlim_max = before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string error = write_error();
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(error, AllOf(HasSubstr("video.mp4"), HasSubstr("File too large")));
  EXPECT_EQ(directory_.entries(), 0U);
}

TEST_F(VideoWriterTest, VideosThatAreCutShortAreRefused) {
  write({}, StereoMode::kMono);
  const std::string whole = read_file(video());
  const fs::path cut = directory_ / "cut.mp4";
  for (std::size_t i = 0; i < 40; ++i) {
    std::ofstream(cut, std::ios::binary) << whole.substr(0, i * whole.size() / 40);
    EXPECT_THROW(read_video(cut), Error) << i;
    EXPECT_THROW(set_spherical(cut, StereoMode::kMono, "video"), Error) << i;
  }
}

// Whatever bytes there are, they are read or refused with the video's name.
TEST_F(VideoWriterTest, DamagedVideosDoNoHarm) {
  write({}, StereoMode::kTopBottom);
  const std::string whole = read_file(video());
  const fs::path file = directory_ / "damaged.mp4";
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    std::string damaged = whole;
    for (int k = 0; k < 3; ++k) {
      const char values[] = {'\0', '\1', '\x7f', '\xff', static_cast<char>(random())};
      damaged[random() % 1500] = values[random() % 5];  // where the description is
    }
    std::ofstream(file, std::ios::binary) << damaged;
    try {
      read_video(file);
      set_spherical(file, StereoMode::kMono, file.string());
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("damaged.mp4"));
    }
  }
}

TEST_F(VideoWriterTest, AVideoWithoutFreeBytesIsRefused) {
  write({}, std::nullopt);
  for (int i = 0; i < 3; ++i) set_spherical(video(), StereoMode::kMono, "video.mp4");
  EXPECT_THAT(error_of([&] {
                for (int i = 0; i < 100; ++i)
                  set_spherical(video(), StereoMode::kMono, "video.mp4");
              }),
              HasSubstr("video.mp4: there is no room"));
}

}  // namespace
}  // namespace raywalk::render
