// The camera and its exposure on a fake device. tests/kernel runs them on real kernel drivers.
#include "capture/camera/v4l2_camera.h"

#include <gmock/gmock.h>
#include <linux/v4l2-controls.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "capture/camera/video_device.h"

namespace raywalk::capture {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;
using enum VideoControl;

// The colour of every pixel (BGR) of a frame that was exposed at a time for some 0.1 ms.
using FakeScene = std::function<cv::Scalar(SteadyTime exposed, int exposure_100us)>;

cv::Scalar grey_scene(SteadyTime /*exposed*/, int exposure_100us) {
  return cv::Scalar::all(std::min(exposure_100us / 4, 255));
}

// Frames are counted from 1; 0 disables a fault.
struct FakeVideo {
  PanoramaSize size{64, 32};
  bool any_size = true;  // else every other size snaps to this one
  std::string pixels{};  // "MJPG", "YUYV": any other format snaps to it; empty: it has all
  double frames_per_second = 25.0;
  int line_padding_bytes = 0;  // of YUYV
  VideoColour colour{};
  bool monotonic_stamps = true;  // else of a clock that the host does not know

  bool controls = true;           // exposure, gain and white balance
  int sensor_exposure = 300;      // measured by the automatic exposure, in 0.1 ms
  int exposure_delay_frames = 2;  // until a new exposure time takes effect
  std::string refused_control{};  // as named by name_of(VideoControl)
  int drift_after_frame = 0;      // the exposure changes after this frame

  int damaged_every = 0;       // with the driver's error flag
  int short_every = 0;         // truncated to half, without the flag
  int empty_every = 0;         // no bytes, without the flag
  int gone_after_frame = 0;    // ENODEV after this frame
  int silent_after_frame = 0;  // no more frames after this one
  bool taken = false;          // another program streams from it
  FakeScene scene = grey_scene;
};

// The file without its segments of Huffman tables (T.81 B.1.1.4), as motion-JPEG cameras send it.
std::string without_huffman_tables(const std::string& file) {
  std::string frame = file.substr(0, 2);
  std::size_t offset = 2;
  while (static_cast<unsigned char>(file[offset + 1]) != 0xDA) {
    const std::size_t length = 2 + std::size_t{256} * static_cast<unsigned char>(file[offset + 2]) +
                               static_cast<unsigned char>(file[offset + 3]);
    if (static_cast<unsigned char>(file[offset + 1]) != 0xC4) frame += file.substr(offset, length);
    offset += length;
  }
  return frame + file.substr(offset);
}

// A frame of one colour, by the definition of luma and colour differences (ITU-R BT.601, 2.5).
std::string yuyv_frame(const cv::Scalar& bgr, const VideoFormat& format) {
  const VideoColour& colour = format.colour;
  const double y =
      (colour.kb * bgr[0] + colour.kr * bgr[2] + (1.0 - colour.kr - colour.kb) * bgr[1]) / 255.0;
  const double luma = colour.full_range ? 255.0 * y : 16.0 + 219.0 * y;
  const auto chroma = [&](double primary, double k) {
    return 128.0 + (colour.full_range ? 255.0 : 224.0) * (primary / 255.0 - y) / (2.0 * (1.0 - k));
  };
  std::string pair;
  for (const double sample : {luma, chroma(bgr[0], colour.kb), luma, chroma(bgr[2], colour.kr)}) {
    pair += static_cast<char>(std::clamp(cvRound(sample), 0, 255));
  }
  std::string line;
  for (int u = 0; u < format.size.width; u += 2) line += pair;
  line.resize(format.bytes_per_line, '\0');
  std::string frame;
  for (int v = 0; v < format.size.height; ++v) frame += line;
  return frame;
}

// Frames follow a Clock.
class FakeVideoDevice final : public VideoDevice {
 public:
  FakeVideoDevice(FakeVideo fake, Clock* clock)
      : fake_(std::move(fake)),
        clock_(clock),
        period_(duration_from_ms(1000.0 / fake_.frames_per_second)) {
    format_ = try_format("MJPG", fake_.size);
  }

  std::string path() const override { return "/dev/video-fake"; }
  VideoIdentity identity() const override {
    return {.driver = "fake 1.0.0", .card = "Fake 360", .bus = "usb-fake"};
  }
  PanoramaSize current_size() override { return format_.size; }
  VideoFormat try_format(const std::string& pixels, PanoramaSize size) override {
    const PanoramaSize snapped = fake_.any_size ? size : fake_.size;
    return {
        .pixels = fake_.pixels.empty() ? pixels : fake_.pixels,
        .size = snapped,
        .bytes_per_line = static_cast<std::size_t>(2 * snapped.width + fake_.line_padding_bytes),
        .colour = fake_.colour};
  }
  VideoFormat set_format(const std::string& pixels, PanoramaSize size) override {
    if (fake_.taken) throw fault(FaultKind::kBusy, " is in use by another program; end that");
    return format_ = try_format(pixels, size);
  }

  std::optional<ControlRange> range_of(VideoControl control) override {
    if (!fake_.controls) return std::nullopt;
    static const std::map<VideoControl, ControlRange> ranges{{kExposureMode, {0, 3, 1}},
                                                             {kExposure, {1, 5000, 1}},
                                                             {kGain, {0, 100, 1}},
                                                             {kWhiteBalance, {2800, 6500, 10}}};
    const auto found = ranges.find(control);
    return found == ranges.end() ? ControlRange{0, 1, 1} : found->second;
  }
  int control(VideoControl control) override {
    return control == kExposure ? exposure_now() : controls_.at(control);
  }
  bool set_control(VideoControl control, int value) override {
    const std::optional<ControlRange> range = range_of(control);
    // As a fixed aperture has it: priority of the aperture is the only automatic.
    const bool is_unknown_mode = control == kExposureMode && value == V4L2_EXPOSURE_AUTO;
    if (!range || is_unknown_mode || fake_.refused_control == name_of(control)) return false;
    if (value < range->least || value > range->most) return false;
    expose_until_now();
    const int before = exposure_now();
    controls_[control] = value / range->step * range->step;
    if (exposure_now() != before) {
      exposures_.assign(static_cast<std::size_t>(fake_.exposure_delay_frames), before);
    }
    return true;
  }

  void start(int buffers) override {
    free_buffers_ = buffers;
    next_exposed_ = clock_->now() + period_;
  }
  std::optional<VideoFrame> next_frame(Duration timeout) override {
    expose_until_now();
    if (std::exchange(lends_, false)) ++free_buffers_;
    if (queued_.empty()) {
      const Duration wait = std::min(timeout, next_exposed_ - clock_->now());
      clock_->sleep(is_over(fake_.silent_after_frame) ? timeout : wait);
      expose_until_now();
    }
    if (queued_.empty() && is_over(fake_.gone_after_frame)) {
      throw fault(FaultKind::kNoContact, " was unplugged; plug it in again and resume");
    }
    if (queued_.empty()) return std::nullopt;
    const Exposed exposed = queued_.front();
    queued_.pop_front();
    lends_ = true;
    return frame_of(exposed);
  }

 private:
  struct Exposed {
    SteadyTime at{};
    int number = 0;  // from 1
    int exposure_100us = 0;
  };

  DeviceFault fault(FaultKind kind, const std::string& what) const {
    return {kind, "camera " + path() + what};
  }
  bool is_over(int after) const { return after > 0 && frames_ >= after; }
  int exposure_now() const {
    return controls_.at(kExposureMode) == V4L2_EXPOSURE_MANUAL ? controls_.at(kExposure)
                                                               : fake_.sensor_exposure;
  }
  // Without a free buffer a frame is lost, as with a real driver.
  void expose_until_now() {
    for (; next_exposed_ <= clock_->now(); next_exposed_ += period_) {
      if (free_buffers_ == 0 || is_over(fake_.silent_after_frame) ||
          is_over(fake_.gone_after_frame)) {
        // Where nothing can change until someone takes a frame, time may pass at once.
        next_exposed_ += (clock_->now() - next_exposed_) / period_ * period_;
        continue;
      }
      int exposure = exposure_now();
      if (!exposures_.empty()) {
        exposure = exposures_.front();
        exposures_.pop_front();
      }
      --free_buffers_;
      queued_.push_back({next_exposed_, ++frames_, exposure});
      if (fake_.drift_after_frame == frames_) controls_[kExposure] += 40;
    }
  }
  VideoFrame frame_of(const Exposed& exposed) {
    const auto is_due = [&](int every) { return every > 0 && exposed.number % every == 0; };
    const cv::Scalar colour = fake_.scene(exposed.at, exposed.exposure_100us);
    if (format_.pixels == "YUYV") {
      bytes_ = yuyv_frame(colour, format_);
    } else {
      std::vector<unsigned char> file;
      cv::imencode(".jpg", cv::Mat(format_.size.height, format_.size.width, CV_8UC3, colour), file);
      bytes_ = without_huffman_tables({file.begin(), file.end()});
    }
    if (is_due(fake_.short_every)) bytes_.resize(bytes_.size() / 2);
    if (is_due(fake_.empty_every)) bytes_.clear();
    return {.bytes = std::as_bytes(std::span(bytes_)),
            .stamped_at = fake_.monotonic_stamps ? std::optional(exposed.at) : std::nullopt,
            .is_damaged = is_due(fake_.damaged_every)};
  }

  FakeVideo fake_;
  Clock* clock_;
  VideoFormat format_;
  std::map<VideoControl, int> controls_{{kExposureMode, V4L2_EXPOSURE_APERTURE_PRIORITY},
                                        {kExposure, 156},
                                        {kAutoGain, 1},
                                        {kGain, 8},
                                        {kAutoWhiteBalance, 1},
                                        {kWhiteBalance, 4600}};
  Duration period_{};
  SteadyTime next_exposed_{};
  int frames_ = 0;  // number of frames exposed into a buffer
  int free_buffers_ = 0;
  bool lends_ = false;
  std::deque<Exposed> queued_;
  std::deque<int> exposures_;  // of the next frames, while a change is pending
  std::string bytes_;          // of the frame returned last
};

CameraConfig streaming(PixelFormat pixel_format = PixelFormat::kMjpg) {
  CameraConfig config;
  config.kind = CameraKind::kV4l2;
  config.width_px = 64;
  config.height_px = 32;
  config.v4l2.pixel_format = pixel_format;
  return config;
}

struct VideoRig {
  explicit VideoRig(const FakeVideo& fake = {}, const CameraConfig& config = streaming())
      : device(new FakeVideoDevice(fake, &clock)),
        camera(config, std::unique_ptr<VideoDevice>(device), &clock) {}

  Shot shoot() { return camera.shoot(clock.now()); }
  std::string lock(const ExposureSettings& settings, const std::string& earlier = "") {
    return camera.prepare(settings, earlier);
  }

  ManualClock clock;
  FakeVideoDevice* device;
  V4l2Camera camera;
};

cv::Scalar colour_of(const Picture& picture) {
  const std::vector<unsigned char> bytes(picture.bytes.begin(), picture.bytes.end());
  const cv::Mat decoded = cv::imdecode(bytes, cv::IMREAD_COLOR);
  EXPECT_EQ(decoded.size(), cv::Size(picture.size.width, picture.size.height));
  return cv::mean(decoded);
}

class V4l2CameraPixels : public testing::TestWithParam<PixelFormat> {};
INSTANTIATE_TEST_SUITE_P(Formats, V4l2CameraPixels, testing::ValuesIn(kPixelFormats));

TEST_P(V4l2CameraPixels, PictureWasExposedAfterTheCarriageSettled) {
  // A scene that shows when it was exposed, in steps of 100 ms.
  const auto clock_face = [](SteadyTime exposed, int) {
    return cv::Scalar::all(static_cast<double>(exposed.time_since_epoch() / milliseconds(100)));
  };
  VideoRig rig({.scene = clock_face}, streaming(GetParam()));
  rig.camera.prepare({}, "");
  for (int station = 0; station < 4; ++station) {
    rig.clock.sleep(milliseconds(2300));  // the slider moves, and nobody fetches frames
    const SteadyTime settled = rig.clock.now();
    const Shot shot = rig.camera.shoot(settled);
    ASSERT_EQ(shot.pictures.size(), 1U);
    EXPECT_EQ(shot.pictures[0].extension, "jpg");
    EXPECT_EQ(shot.pictures[0].size, (PanoramaSize{64, 32}));
    const double settled_steps = static_cast<double>(settled.time_since_epoch().count()) / 1e8;
    EXPECT_GE(colour_of(shot.pictures[0])[1] + 2.5, settled_steps);
    EXPECT_GE(shot.exposed_at, wall_time_of(rig.clock, settled) + milliseconds(40));
    // 40 ms of exposure, and the period of the first whole frame after that.
    EXPECT_LE(shot.exposing_ms, 80.0);
  }
}

// The boundary itself: with frames 40 ms apart and a station settled at any time.
TEST(V4l2Camera, NoFrameIsStampedBeforeSettlingAndExposure) {
  for (const double shutter_s : {0.0, 0.25}) {
    for (int offset_ms = 0; offset_ms < 90; offset_ms += 7) {
      VideoRig rig;
      rig.camera.prepare({.shutter_s = shutter_s}, "");
      rig.clock.sleep(milliseconds(500 + offset_ms));
      const SteadyTime settled = rig.clock.now();
      EXPECT_GE(rig.camera.shoot(settled).exposed_at,
                wall_time_of(rig.clock, settled) + milliseconds(shutter_s > 0.0 ? 250 : 40))
          << offset_ms;
    }
  }
}

TEST(V4l2Camera, ReportsWithoutStreaming) {
  VideoRig rig;
  const CameraReport report = rig.camera.report();
  EXPECT_EQ(report.identity, "Fake 360, driver fake 1.0.0, bus usb-fake");
  EXPECT_EQ(report.state, "can stream 64x32 MJPG");
  rig.camera.prepare({}, "");
  EXPECT_EQ(rig.camera.report().state, "streams 64x32 MJPG");
  EXPECT_EQ(rig.camera.description(), "Fake 360 at /dev/video-fake");
  EXPECT_THROW(rig.camera.start_video(), UsageError);
}

TEST(V4l2Camera, UsesTheCurrentSizeIfNoneIsConfigured) {
  CameraConfig config = streaming();
  config.width_px = config.height_px = 0;
  VideoRig rig({.size = {96, 48}}, config);
  EXPECT_EQ(rig.shoot().pictures.at(0).size, (PanoramaSize{96, 48}));
}

TEST(V4l2Camera, FormatsThatDoNotFitAreAWrongDevice) {
  CameraConfig high = streaming();
  high.height_px = 40;
  for (const auto& [fake, config, words] :
       {std::tuple{FakeVideo{.size = {80, 40}, .any_size = false}, streaming(),
                   "offers 80x40 MJPG instead of 64x32 MJPG; set camera.width_px"},
        {FakeVideo{.pixels = "YUYV"}, streaming(), "offers 64x32 YUYV"},
        {FakeVideo{}, high, "a panorama is twice as wide as high"}}) {
    VideoRig rig(fake, config);
    expect_fault(FaultKind::kWrongDevice, words, [&] { rig.camera.report(); });
    expect_fault(FaultKind::kWrongDevice, words, [&] { rig.camera.prepare({}, ""); });
  }
  high.frames = FrameKind::kDualFisheye;
  EXPECT_NO_THROW(VideoRig({}, high).camera.report());
}

TEST_P(V4l2CameraPixels, DamagedShortAndEmptyFramesAreSkipped) {
  VideoRig rig({.damaged_every = 2, .short_every = 3, .empty_every = 5}, streaming(GetParam()));
  rig.camera.prepare({}, "");
  for (int station = 0; station < 20; ++station) {
    rig.clock.sleep(milliseconds(330));
    const Shot shot = rig.shoot();
    ASSERT_EQ(shot.pictures.size(), 1U);
    EXPECT_NEAR(colour_of(shot.pictures[0])[1], 75.0, 2.0);  // the locked exposure
  }
}

TEST_P(V4l2CameraPixels, OnlyDamagedFramesAreABadPicture) {
  for (const auto how :
       {&FakeVideo::damaged_every, &FakeVideo::short_every, &FakeVideo::empty_every}) {
    FakeVideo fake;
    fake.*how = 1;
    VideoRig rig(fake, streaming(GetParam()));
    expect_fault(FaultKind::kBadPicture, "gave only damaged frames within 3000 ms (",
                 [&] { rig.shoot(); });
  }
}

TEST(V4l2Camera, CameraThatFallsSilentIsATimeout) {
  VideoRig rig({.silent_after_frame = 80});
  rig.camera.prepare({}, "");
  SteadyTime settled;
  expect_fault(FaultKind::kTimeout, "gave no frame within 3000 ms of settling", [&] {
    for (int station = 0; station < 80; ++station) {
      rig.clock.sleep(milliseconds(300));  // frames queue and become old
      settled = rig.clock.now();
      rig.shoot();
    }
  });
  EXPECT_EQ(rig.clock.now(), settled + milliseconds(40 + 3000));
}

TEST(V4l2Camera, FaultsAreNoticedBeforeAnyMoveOrDuringTheSession) {
  for (const auto& [fake, kind, words] :
       {std::tuple{FakeVideo{.silent_after_frame = 1}, FaultKind::kTimeout, "gave no frame"},
        {FakeVideo{.taken = true}, FaultKind::kBusy, "in use by another program"},
        {FakeVideo{.monotonic_stamps = false}, FaultKind::kWrongDevice,
         "uvcvideo: clock=CLOCK_MONOTONIC"},
        {FakeVideo{.gone_after_frame = 60}, FaultKind::kNoContact, "plug it in again and resume"},
        {FakeVideo{.drift_after_frame = 80}, FaultKind::kExposure,
         "has exposure_100us at 340 and not at the 300"}}) {
    VideoRig rig(fake);
    expect_fault(kind, words, [&] {
      rig.camera.prepare({}, "");
      for (int station = 0; station < 80; ++station) rig.shoot();
    });
  }
}

// The brightness of each picture shows that the sensor had changed before it was exposed.
TEST(V4l2Camera, BracketIsOnePictureOfEachExposure) {
  VideoRig rig({.sensor_exposure = 200, .exposure_delay_frames = 3});
  rig.lock({.bracket_ev = {-2.0, 0.0, 1.5}});
  for (int station = 0; station < 3; ++station) {
    rig.clock.sleep(milliseconds(1000));
    const Shot shot = rig.shoot();
    ASSERT_EQ(shot.pictures.size(), 3U);
    for (const auto& [i, exposure] : {std::pair{0, 50}, {1, 200}, {2, 566}}) {
      EXPECT_NEAR(colour_of(shot.pictures[i])[1], exposure / 4.0, 2.0);
      EXPECT_THAT(shot.pictures[i].exposure,
                  HasSubstr("\"exposure_100us\":" + std::to_string(exposure)));
    }
  }
}

// In every encoding, and with lines of any padding.
TEST(V4l2Camera, YuyvKeepsItsColours) {
  for (const VideoColour& colour :
       {VideoColour{}, VideoColour{.full_range = true}, VideoColour{.kr = 0.2126, .kb = 0.0722}}) {
    for (const cv::Scalar& bgr : {cv::Scalar(30, 120, 220), cv::Scalar(0, 0, 0),
                                  cv::Scalar(255, 255, 255), cv::Scalar(200, 60, 20)}) {
      const FakeVideo fake{.line_padding_bytes = bgr[0] > 100.0 ? 64 : 0,
                           .colour = colour,
                           .scene = [bgr](SteadyTime, int) { return bgr; }};
      VideoRig rig(fake, streaming(PixelFormat::kYuyv));
      const cv::Scalar seen = colour_of(rig.shoot().pictures.at(0));
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], bgr[c], 3.0) << bgr << colour.kr;
    }
  }
}

// --- Exposure -----------------------------------------------------------------------------------

template <typename Call>
void expect_exposure_fault(const std::string& words, const Call& call) {
  expect_fault(FaultKind::kExposure, words, call);
}

TEST(V4l2Exposure, LocksWhatIsGivenAndTheRestAsTheCameraMeasuredIt) {
  VideoRig rig({.sensor_exposure = 240});
  const std::string locked = rig.lock({});
  EXPECT_EQ(locked, R"({"exposure_100us":240,"gain":8,"white_balance_k":4600})");
  EXPECT_EQ(rig.device->control(kExposureMode), 1);
  EXPECT_EQ(rig.device->control(kAutoGain), 0);
  EXPECT_EQ(rig.device->control(kAutoWhiteBalance), 0);
  const Picture picture = rig.shoot().pictures.at(0);
  EXPECT_EQ(picture.exposure, locked);
  EXPECT_NEAR(colour_of(picture)[1], 60.0, 2.0);
  // The camera has steps of 10.
  EXPECT_EQ(rig.lock({.shutter_s = 0.02, .white_balance_k = 5003}),
            R"({"exposure_100us":200,"gain":8,"white_balance_k":5000})");
}

TEST(V4l2Exposure, ResumedSessionIsSetAgainAndNotMeasured) {
  VideoRig rig({.sensor_exposure = 999});
  const std::string earlier = R"({"exposure_100us":321,"gain":3,"white_balance_k":4700})";
  EXPECT_EQ(rig.lock({}, earlier), earlier);
  EXPECT_LT(rig.clock.now().time_since_epoch(), milliseconds(1000)) << "it measured";
  for (const std::string other : {R"({"iso":100})", "nonsense", "[1]"}) {
    expect_exposure_fault("not settings of a V4L2 camera; resume with the camera",
                          [&] { rig.lock({}, other); });
  }
}

TEST(V4l2Exposure, CameraWithoutControlsIsLeftAlone) {
  VideoRig rig({.controls = false});
  EXPECT_EQ(rig.lock({}), "");
  EXPECT_EQ(rig.shoot().pictures.at(0).exposure, "");
  expect_exposure_fault("has no control for exposure_100us",
                        [&] { rig.lock({.shutter_s = 0.02}); });
}

TEST(V4l2Exposure, NothingIsLockedIfTheLockIsOff) {
  VideoRig rig;
  EXPECT_EQ(rig.lock({.lock = false}), "");
  EXPECT_EQ(rig.device->control(kExposureMode), 3);
  EXPECT_THROW(rig.lock({.lock = false, .bracket_ev = {-1.0, 0.0}}), UsageError);
}

TEST(V4l2Exposure, NamesUnsupportedSettings) {
  VideoRig rig({.sensor_exposure = 200});
  expect_exposure_fault("takes exposure_100us from 1 to 5000, not 20000",
                        [&] { rig.lock({.shutter_s = 2.0}); });
  // Of a bracket too, at the start.
  for (const double ev : {-9.0, 5.0, 1e300}) {
    expect_exposure_fault("cannot expose by", [&] { rig.lock({.bracket_ev = {0.0, ev}}); });
  }
  EXPECT_THROW(rig.lock({.iso = 100}), UsageError);
  for (const std::string control : {"exposure_mode", "auto_gain", "gain", "white_balance_k"}) {
    VideoRig stubborn({.refused_control = control});
    expect_exposure_fault("refuses", [&] { stubborn.lock({}); });
  }
}

TEST(V4l2Exposure, AChangeByAnotherProgramIsAFault) {
  VideoRig rig;
  rig.lock({});
  rig.device->set_control(kGain, 55);
  expect_exposure_fault("has gain at 55 and not at the 8", [&] { rig.shoot(); });
  rig.device->set_control(kGain, 8);
  rig.device->set_control(kAutoWhiteBalance, 1);
  expect_exposure_fault("has auto_white_balance at 1", [&] { rig.shoot(); });
}

TEST(V4l2Device, WhatIsNoCameraIsNamed) {
  expect_fault(FaultKind::kNoContact,
               "no camera at /dev/v4l/by-id/missing; plug it in, or set camera.v4l2.device",
               [] { open_video_device("/dev/v4l/by-id/missing"); });
  expect_fault(FaultKind::kWrongDevice, "/dev/null is not a camera that streams",
               [] { open_video_device("/dev/null"); });
  expect_fault(FaultKind::kNoContact, "cannot open camera /dev (Is a directory)",
               [] { open_video_device("/dev"); });
}

}  // namespace
}  // namespace raywalk::capture
