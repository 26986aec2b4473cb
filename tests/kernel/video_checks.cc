#include "tests/kernel/video_checks.h"

#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "capture/camera/v4l2_camera.h"
#include "capture/camera/video_device.h"
#include "tests/kernel/vivid.h"

namespace raywalk::capture {
namespace {

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
