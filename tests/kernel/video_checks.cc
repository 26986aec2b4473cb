#include <fcntl.h>
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

#include "capture/camera/v4l2_camera.h"
#include "capture/camera/video_device.h"
#include "tests/kernel/check_report.h"

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
// independent of the checked code. Methods throw CheckFailure.
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

ExposureSettings unlocked() {
  ExposureSettings settings;
  settings.lock = false;
  return settings;
}

struct Rig {
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

void check_stream() {
  const auto device = open_video_device(kDevice);
  const VideoFormat format = device->set_format("YUYV", kSize);
  require(format.size == kSize && format.pixels == "YUYV",
          "not the requested size and pixel format");
  device->start(4);
  const SystemClock clock;
  SteadyTime latest = clock.now();
  for (int i = 0; i < 8; ++i) {
    const VideoFrame frame = wait_for_frame(device.get());
    require(!frame.is_damaged, "a frame is marked damaged");
    require(frame.bytes.size() == std::size_t{2} * kSize.width * kSize.height, "not a whole frame");
    require(frame.stamped_at.has_value(), "a frame has no monotonic stamp");
    require(*frame.stamped_at > latest, "stamps do not rise");
    // vivid's timestamp is the end of the readout, one frame period after its start.
    require(*frame.stamped_at <= clock.now() + kFramePeriod, "stamps are ahead of the clock");
    latest = *frame.stamped_at;
  }
}

// The reason for dropping frames: the driver returns frames queued earlier.
void check_queued_frames() {
  SystemClock clock;
  const auto device = open_video_device(kDevice);
  device->set_format("YUYV", kSize);
  device->start(4);
  wait_for_frame(device.get());
  clock.sleep(std::chrono::seconds(1));
  const SteadyTime settled = clock.now();
  require(*wait_for_frame(device.get()).stamped_at < settled, "the driver queued no old frame");
}

void check_fresh_picture() {
  Vivid vivid(kDevice);
  Rig rig;
  vivid.show(VividScene::kWhite);
  rig.camera.prepare(unlocked(), "");
  for (const VividScene scene : {VividScene::kBlack, VividScene::kWhite, VividScene::kBlack}) {
    rig.clock.sleep(std::chrono::seconds(1));  // buffers fill with the previous scene
    vivid.show(scene);
    const SteadyTime settled = rig.clock.now();
    const Shot shot = rig.camera.shoot(settled);
    const double expected = scene == VividScene::kBlack ? 0.0 : 255.0;
    require_near(mean_colour(shot)[1], expected, 4.0, "brightness after the scene changed");
    require(shot.exposed_at >= wall_time_of(rig.clock, settled), "exposed before settling");
  }
}

// vivid's test pattern generator converts from RGB with the colorimetry that it reports.
void check_colours() {
  Vivid vivid(kDevice);
  Rig rig;
  rig.camera.prepare(unlocked(), "");
  const std::map<VividScene, cv::Scalar> scenes = {{VividScene::kRed, {0, 0, 255}},
                                                   {VividScene::kGreen, {0, 255, 0}},
                                                   {VividScene::kBlue, {255, 0, 0}}};
  for (const auto& [scene, expected] : scenes) {
    vivid.show(scene);
    const cv::Scalar colour = mean_colour(rig.camera.shoot(rig.clock.now()));
    for (int channel = 0; channel < 3; ++channel) {
      require_near(colour[channel], expected[channel], 4.0,
                   "channel " + std::to_string(channel) + " of a plain colour");
    }
  }
}

// vivid's automatic gain is the time in seconds, so it drifts unless locked.
void check_locked_gain() {
  Vivid vivid(kDevice);
  Rig rig;
  const std::string locked = rig.camera.prepare({}, "");
  require(locked.find("\"gain\":") != std::string::npos, "gain is not locked: " + locked);
  rig.clock.sleep(std::chrono::seconds(2));
  const Shot shot = rig.camera.shoot(rig.clock.now());
  require(shot.pictures.at(0).exposure == locked, "gain drifted: " + shot.pictures[0].exposure);
  vivid.change_gain();
  require_fault(FaultKind::kExposure, "gain", [&] { rig.camera.shoot(rig.clock.now()); });
}

void check_missing_control() {
  Rig rig;
  ExposureSettings settings;
  settings.shutter_s = 0.01;
  require_fault(FaultKind::kExposure, "no control for exposure_100us",
                [&] { rig.camera.prepare(settings, ""); });
}

void check_second_user() {
  Rig rig;
  rig.camera.prepare(unlocked(), "");
  Rig other;
  require_fault(FaultKind::kBusy, "in use by another program",
                [&] { other.camera.prepare(unlocked(), ""); });
}

void check_snapped_size() {
  Vivid(kDevice).select_input(kWebcamInput);
  Rig rig;
  require_fault(FaultKind::kWrongDevice, "offers 1920x1080 YUYV instead of 1920x960 YUYV",
                [&] { rig.camera.report(); });
  Vivid(kDevice).select_input(kHdmiInput);
}

void check_disconnect() {
  {
    Rig rig;
    rig.camera.prepare(unlocked(), "");
    Vivid(kDevice).disconnect();
    require_fault(FaultKind::kNoContact, "was unplugged",
                  [&] { rig.camera.shoot(rig.clock.now()); });
    require_fault(FaultKind::kNoContact, "no camera at", [] { open_video_device(kDevice); });
  }
  Rig again;
  again.camera.prepare(unlocked(), "");
  require(again.camera.shoot(again.clock.now()).pictures.size() == 1, "no picture afterwards");
}

void check_other_devices() {
  require_fault(FaultKind::kNoContact, "no camera at", [] { open_video_device("/dev/video99"); });
  require_fault(FaultKind::kWrongDevice, "is not a camera", [] { open_video_device("/dev/null"); });
}

}  // namespace

void check_video(CheckReport* report) {
  Vivid(kDevice).select_input(kHdmiInput);
  report->run("video: streams 1920x960 YUYV with rising monotonic stamps", check_stream);
  report->run("video: the driver queues old frames", check_queued_frames);
  report->run("video: pictures are exposed after settling", check_fresh_picture);
  report->run("video: colours", check_colours);
  report->run("video: automatic gain is locked, and a change detected", check_locked_gain);
  report->run("video: exposure time on a camera without that control", check_missing_control);
  report->run("video: camera in use by another program", check_second_user);
  report->run("video: webcam that returns another size", check_snapped_size);
  report->run("video: camera unplugged while streaming, and replugged", check_disconnect);
  report->run("video: devices that are not cameras", check_other_devices);
}

}  // namespace raywalk::capture
