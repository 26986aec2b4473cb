// The V4L2 camera on the kernel's vivid driver. Needs vivid at /dev/video0 with a webcam as input 0
// and HDMI as input 1.
//
// vivid does not support MJPG, which is covered by unit tests only: v4l2loopback supports it, but
// is not part of the kernel and must be built with dkms.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <linux/v4l2-dv-timings.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "capture/base/test_fault.h"
#include "capture/camera/v4l2_camera.h"
#include "capture/camera/video_device.h"
#include "tests/kernel/require.h"

namespace raywalk::capture {
namespace {

constexpr int kWebcamInput = 0;  // a few fixed sizes
constexpr int kHdmiInput = 1;    // any size, cropped from 1920x1080

// drivers/media/test-drivers/vivid/vivid-ctrls.c
constexpr std::uint32_t kTestPattern = 0x00f0f000;
constexpr std::uint32_t kTextMode = 0x00f0f001;
constexpr std::uint32_t kDisconnect = 0x00f0f041;
constexpr int kNoText = 2;

// Values of its control "Test Pattern" (Documentation/admin-guide/media/vivid.rst).
enum class VividScene { kBlack = 5, kWhite = 6, kRed = 7, kGreen = 8, kBlue = 9 };

// Controls the scene and connection of vivid's simulated camera: a second user of the device,
// independent of the checked code. Methods throw where it refuses.
class Vivid {
 public:
  explicit Vivid(const std::string& device) : fd_(open(device.c_str(), O_RDWR | O_CLOEXEC)) {
    require(fd_ >= 0, "cannot open " + device);
  }
  ~Vivid() { close(fd_); }
  Vivid(const Vivid&) = delete;
  Vivid& operator=(const Vivid&) = delete;

  void select_input(int input) {  // not while streaming
    require(ioctl(fd_, VIDIOC_S_INPUT, &input) == 0, "vivid refuses the input");
    if (input != kHdmiInput) return;
    // The default signal has 720 lines, which would not fill larger frames.
    v4l2_dv_timings timings = V4L2_DV_BT_CEA_1920X1080P60;
    require(ioctl(fd_, VIDIOC_S_DV_TIMINGS, &timings) == 0, "vivid refuses the HDMI timings");
  }
  // A uniform colour, from the start of the next frame.
  void show(VividScene scene) {
    set_control(kTextMode, kNoText);
    set_control(kTestPattern, static_cast<int>(scene));
  }
  // Simulates a change by another program.
  void change_gain() {
    v4l2_control gain{.id = V4L2_CID_GAIN, .value = 0};
    require(ioctl(fd_, VIDIOC_G_CTRL, &gain) == 0, "vivid does not report its gain");
    set_control(V4L2_CID_GAIN, (gain.value + 100) % 256);
  }
  // Simulates unplugging; the device returns when its last user has closed it.
  void disconnect() { set_control(kDisconnect, 1); }

 private:
  void set_control(std::uint32_t id, int value) {
    v4l2_control control{.id = id, .value = value};
    require(ioctl(fd_, VIDIOC_S_CTRL, &control) == 0, "vivid refuses a control");
  }

  int fd_;
};

const std::string kDevice = "/dev/video0";
constexpr PanoramaSize kSize{1920, 960};
constexpr auto kFramePeriod = std::chrono::milliseconds(17);  // 60 Hz

CameraConfig streaming() {
  CameraConfig config;
  config.kind = CameraKind::kV4l2;
  config.width_px = kSize.width;
  config.height_px = kSize.height;
  config.v4l2.device = kDevice;
  config.v4l2.pixel_format = PixelFormat::kYuyv;
  config.v4l2.frame_timeout_ms = 10000.0;  // the virtual machine may be slow
  return config;
}

const ExposureSettings kUnlocked{.lock = false};

class VividTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { Vivid(kDevice).select_input(kHdmiInput); }

  SystemClock clock;
  V4l2Camera camera{streaming(), open_video_device(kDevice), &clock};
};

cv::Scalar mean_colour(const Shot& shot) {
  require(shot.pictures.size() == 1, "not one picture");
  const std::string& bytes = shot.pictures[0].bytes;
  const cv::Mat picture =
      cv::imdecode(std::vector<unsigned char>(bytes.begin(), bytes.end()), cv::IMREAD_COLOR);
  require(picture.size() == cv::Size(kSize.width, kSize.height), "not a picture of that size");
  return cv::mean(picture);
}

VideoFrame wait_for_frame(VideoDevice* device) {
  const auto frame = device->next_frame(std::chrono::seconds(10));
  require(frame.has_value(), "no frame came");
  return *frame;
}

TEST_F(VividTest, StreamsWithRisingMonotonicStamps) {
  const auto device = open_video_device(kDevice);
  const VideoFormat format = device->set_format("YUYV", kSize);
  EXPECT_EQ(format.size, kSize);
  EXPECT_EQ(format.pixels, "YUYV");
  device->start(4);
  SteadyTime latest = clock.now();
  for (int i = 0; i < 8; ++i) {
    const VideoFrame frame = wait_for_frame(device.get());
    EXPECT_FALSE(frame.is_damaged);
    EXPECT_EQ(frame.bytes.size(), std::size_t{2} * kSize.width * kSize.height);
    ASSERT_TRUE(frame.stamped_at) << "no monotonic stamp";
    EXPECT_GT(*frame.stamped_at, latest);
    // vivid's timestamp is the end of the readout, one frame period after its start.
    EXPECT_LE(*frame.stamped_at, clock.now() + kFramePeriod);
    latest = *frame.stamped_at;
  }
}

// The reason for dropping frames: the driver returns frames queued earlier.
TEST_F(VividTest, DriverQueuesOldFrames) {
  const auto device = open_video_device(kDevice);
  device->set_format("YUYV", kSize);
  device->start(4);
  wait_for_frame(device.get());
  clock.sleep(std::chrono::seconds(1));
  const SteadyTime settled = clock.now();
  EXPECT_LT(*wait_for_frame(device.get()).stamped_at, settled);
}

TEST_F(VividTest, PicturesAreExposedAfterSettling) {
  Vivid vivid(kDevice);
  vivid.show(VividScene::kWhite);
  camera.prepare(kUnlocked, "");
  for (const VividScene scene : {VividScene::kBlack, VividScene::kWhite, VividScene::kBlack}) {
    clock.sleep(std::chrono::seconds(1));  // buffers fill with the previous scene
    vivid.show(scene);
    const SteadyTime settled = clock.now();
    const Shot shot = camera.shoot(settled);
    EXPECT_NEAR(mean_colour(shot)[1], scene == VividScene::kBlack ? 0.0 : 255.0, 4.0);
    EXPECT_GE(shot.exposed_at, wall_time_of(clock, settled));
  }
}

// vivid's test pattern generator converts from RGB with the colorimetry that it reports.
TEST_F(VividTest, Colours) {
  Vivid vivid(kDevice);
  camera.prepare(kUnlocked, "");
  const std::map<VividScene, cv::Scalar> scenes = {{VividScene::kRed, {0, 0, 255}},
                                                   {VividScene::kGreen, {0, 255, 0}},
                                                   {VividScene::kBlue, {255, 0, 0}}};
  for (const auto& [scene, expected] : scenes) {
    vivid.show(scene);
    const cv::Scalar colour = mean_colour(camera.shoot(clock.now()));
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(colour[i], expected[i], 4.0) << "channel " << i;
  }
}

// vivid's automatic gain is the time in seconds, so it drifts unless locked.
TEST_F(VividTest, AutomaticGainIsLockedAndAChangeDetected) {
  const std::string locked = camera.prepare({}, "");
  EXPECT_THAT(locked, ::testing::HasSubstr("\"gain\":"));
  clock.sleep(std::chrono::seconds(2));
  EXPECT_EQ(camera.shoot(clock.now()).pictures.at(0).exposure, locked);
  Vivid(kDevice).change_gain();
  expect_fault(FaultKind::kExposure, "gain", [&] { camera.shoot(clock.now()); });
}

TEST_F(VividTest, ExposureTimeOfACameraWithoutThatControl) {
  expect_fault(FaultKind::kExposure, "no control for exposure_100us",
               [&] { camera.prepare({.shutter_s = 0.01}, ""); });
}

TEST_F(VividTest, CameraThatAnotherProgramUses) {
  camera.prepare(kUnlocked, "");
  V4l2Camera other(streaming(), open_video_device(kDevice), &clock);
  expect_fault(FaultKind::kBusy, "in use by another program",
               [&] { other.prepare(kUnlocked, ""); });
}

TEST_F(VividTest, WebcamThatReturnsAnotherSize) {
  Vivid(kDevice).select_input(kWebcamInput);
  expect_fault(FaultKind::kWrongDevice, "offers 1920x1080 YUYV instead of 1920x960 YUYV",
               [&] { camera.report(); });
  Vivid(kDevice).select_input(kHdmiInput);
}

TEST(VividLostTest, CameraUnpluggedWhileStreamingAndPluggedInAgain) {
  SystemClock clock;
  {
    V4l2Camera camera(streaming(), open_video_device(kDevice), &clock);
    camera.prepare(kUnlocked, "");
    Vivid(kDevice).disconnect();
    expect_fault(FaultKind::kNoContact, "was unplugged", [&] { camera.shoot(clock.now()); });
    expect_fault(FaultKind::kNoContact, "no camera at", [] { open_video_device(kDevice); });
  }
  V4l2Camera again(streaming(), open_video_device(kDevice), &clock);
  again.prepare(kUnlocked, "");
  EXPECT_EQ(again.shoot(clock.now()).pictures.size(), 1U);
}

TEST(VideoDevice, DevicesThatAreNoCameras) {
  expect_fault(FaultKind::kNoContact, "no camera at", [] { open_video_device("/dev/video99"); });
  expect_fault(FaultKind::kWrongDevice, "is not a camera", [] { open_video_device("/dev/null"); });
}

}  // namespace
}  // namespace raywalk::capture
