#include "tests/kernel/vivid.h"

#include <fcntl.h>
#include <linux/v4l2-dv-timings.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "tests/kernel/check_report.h"

namespace raywalk::capture {
namespace {

// drivers/media/test-drivers/vivid/vivid-ctrls.c
constexpr std::uint32_t kTestPattern = 0x00f0f000;
constexpr std::uint32_t kTextMode = 0x00f0f001;
constexpr std::uint32_t kDisconnect = 0x00f0f041;
constexpr int kNoText = 2;

}  // namespace

Vivid::Vivid(const std::string& device) : fd_(open(device.c_str(), O_RDWR | O_CLOEXEC)) {
  require(fd_ >= 0, "cannot open " + device);
}

Vivid::~Vivid() { close(fd_); }

void Vivid::select_input(int input) {
  require(ioctl(fd_, VIDIOC_S_INPUT, &input) == 0, "vivid refuses the input");
  if (input != kHdmiInput) return;
  // The default signal has 720 lines, which would not fill larger frames.
  v4l2_dv_timings timings = V4L2_DV_BT_CEA_1920X1080P60;
  require(ioctl(fd_, VIDIOC_S_DV_TIMINGS, &timings) == 0, "vivid refuses the HDMI timings");
}

void Vivid::show(VividScene scene) {
  set_control(kTextMode, kNoText);
  set_control(kTestPattern, static_cast<int>(scene));
}

void Vivid::change_gain() {
  v4l2_control gain{.id = V4L2_CID_GAIN, .value = 0};
  require(ioctl(fd_, VIDIOC_G_CTRL, &gain) == 0, "vivid does not report its gain");
  set_control(V4L2_CID_GAIN, (gain.value + 100) % 256);
}

void Vivid::disconnect() { set_control(kDisconnect, 1); }

void Vivid::set_control(std::uint32_t id, int value) {
  v4l2_control control{.id = id, .value = value};
  require(ioctl(fd_, VIDIOC_S_CTRL, &control) == 0, "vivid refuses a control");
}

}  // namespace raywalk::capture
