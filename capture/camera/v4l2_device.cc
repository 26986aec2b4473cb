#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>
#include <vector>

#include "capture/base/device_fault.h"
#include "capture/camera/video_device.h"

namespace raywalk::capture {
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

// The text of a V4L2 character field, which ends at a zero byte or at the end of the field.
template <std::size_t kSize>
std::string text_of(const __u8 (&field)[kSize]) {
  return {std::begin(field), std::find(std::begin(field), std::end(field), 0)};
}

std::string version_text(__u32 version) {
  return std::to_string(version >> 16) + "." + std::to_string((version >> 8) & 0xFF) + "." +
         std::to_string(version & 0xFF);
}

__u32 fourcc_of(const std::string& pixels) {
  return v4l2_fourcc(pixels.at(0), pixels.at(1), pixels.at(2), pixels.at(3));
}

std::string text_of_fourcc(__u32 fourcc) {
  std::string text;
  for (int shift = 0; shift < 32; shift += 8) text += static_cast<char>((fourcc >> shift) & 0x7F);
  return one_line(text);
}

// In the order of VideoControl.
constexpr std::array<__u32, 6> kControlIds = {
    V4L2_CID_EXPOSURE_AUTO, V4L2_CID_EXPOSURE_ABSOLUTE,  V4L2_CID_AUTOGAIN,
    V4L2_CID_GAIN,          V4L2_CID_AUTO_WHITE_BALANCE, V4L2_CID_WHITE_BALANCE_TEMPERATURE};

__u32 id_of(VideoControl control) { return kControlIds.at(static_cast<std::size_t>(control)); }

// The driver's colorimetry, with defaults resolved as in videodev2.h.
VideoColour colour_of(const v4l2_pix_format& pixels) {
  __u32 encoding = pixels.ycbcr_enc;
  if (encoding == V4L2_YCBCR_ENC_DEFAULT) encoding = V4L2_MAP_YCBCR_ENC_DEFAULT(pixels.colorspace);
  __u32 range = pixels.quantization;
  if (range == V4L2_QUANTIZATION_DEFAULT) {
    range = V4L2_MAP_QUANTIZATION_DEFAULT(false, pixels.colorspace, encoding);
  }
  VideoColour colour;
  colour.full_range = range == V4L2_QUANTIZATION_FULL_RANGE;
  switch (encoding) {
    case V4L2_YCBCR_ENC_709:
    case V4L2_YCBCR_ENC_XV709:
      colour.kr = 0.2126;  // ITU-R BT.709
      colour.kb = 0.0722;
      break;
    case V4L2_YCBCR_ENC_BT2020:
      colour.kr = 0.2627;  // ITU-R BT.2020
      colour.kb = 0.0593;
      break;
    case V4L2_YCBCR_ENC_SMPTE240M:
      colour.kr = 0.212;  // SMPTE 240M
      colour.kb = 0.087;
      break;
    default:
      break;  // ITU-R BT.601
  }
  return colour;
}

VideoFormat format_of(const v4l2_pix_format& pixels) {
  return {
      .pixels = text_of_fourcc(pixels.pixelformat),
      .size = {static_cast<int>(pixels.width), static_cast<int>(pixels.height)},
      .bytes_per_line = std::max<std::size_t>(pixels.bytesperline, std::size_t{2} * pixels.width),
      .colour = colour_of(pixels)};
}

class V4l2Device final : public VideoDevice {
 public:
  // Owns the descriptor.
  V4l2Device(int fd, std::string path) : fd_(fd), path_(std::move(path)) {}
  ~V4l2Device() override {
    v4l2_buf_type type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (is_streaming_) call(VIDIOC_STREAMOFF, &type);
    for (const auto& [data, size] : buffers_) munmap(data, size);
    close(fd_);
  }

  // Whether it is a camera that streams.
  bool is_camera() {
    if (call(VIDIOC_QUERYCAP, &capability_) != 0) return false;
    // device_caps describes this node; `capabilities` the whole device with its metadata nodes.
    const __u32 abilities = (capability_.capabilities & V4L2_CAP_DEVICE_CAPS) != 0
                                ? capability_.device_caps
                                : capability_.capabilities;
    constexpr __u32 kNeeded = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
    return (abilities & kNeeded) == kNeeded;
  }

  std::string path() const override { return path_; }

  VideoIdentity identity() const override {
    return {.driver = text_of(capability_.driver) + " " + version_text(capability_.version),
            .card = text_of(capability_.card),
            .bus = text_of(capability_.bus_info)};
  }

  PanoramaSize current_size() override { return format_of(current_format().fmt.pix).size; }

  VideoFormat try_format(const std::string& pixels, PanoramaSize size) override {
    return exchange_format(VIDIOC_TRY_FMT, pixels, size);
  }

  VideoFormat set_format(const std::string& pixels, PanoramaSize size) override {
    return exchange_format(VIDIOC_S_FMT, pixels, size);
  }

  std::optional<ControlRange> range_of(VideoControl control) override {
    v4l2_queryctrl query{};
    query.id = id_of(control);
    if (call(VIDIOC_QUERYCTRL, &query) != 0) {
      if (errno == ENODEV) throw fault("list its controls");
      return std::nullopt;
    }
    if ((query.flags & (V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY)) != 0) {
      return std::nullopt;
    }
    return ControlRange{query.minimum, query.maximum, std::max(query.step, 1)};
  }

  int control(VideoControl control) override {
    v4l2_control value{.id = id_of(control), .value = 0};
    if (call(VIDIOC_G_CTRL, &value) != 0) throw fault("report its " + name_of(control));
    return value.value;
  }

  bool set_control(VideoControl control, int value) override {
    v4l2_control wanted{.id = id_of(control), .value = value};
    if (call(VIDIOC_S_CTRL, &wanted) == 0) return true;
    if (errno == ENODEV) throw fault("set its " + name_of(control));
    return false;
  }

  void start(int buffers) override {
    v4l2_requestbuffers request{};
    request.count = static_cast<__u32>(buffers);
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    if (call(VIDIOC_REQBUFS, &request) != 0) throw fault("allocate buffers");
    for (__u32 index = 0; index < request.count; ++index) {
      v4l2_buffer buffer = buffer_at(index);
      if (call(VIDIOC_QUERYBUF, &buffer) != 0) throw fault("describe its buffers");
      void* const data = mmap(nullptr, buffer.length, PROT_READ, MAP_SHARED, fd_, buffer.m.offset);
      if (data == MAP_FAILED) throw fault("map its buffers");
      buffers_.emplace_back(data, buffer.length);
      queue(index);
    }
    v4l2_buf_type type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (call(VIDIOC_STREAMON, &type) != 0) throw fault("start to stream");
    is_streaming_ = true;
  }

  std::optional<VideoFrame> next_frame(Duration timeout) override {
    if (lent_) queue(*std::exchange(lent_, std::nullopt));
    if (!wait(timeout)) return std::nullopt;
    v4l2_buffer buffer = buffer_at(0);
    if (call(VIDIOC_DQBUF, &buffer) != 0) {
      if (errno == EAGAIN) return std::nullopt;
      throw fault("deliver a frame");
    }
    lent_ = buffer.index;
    return frame_of(buffer);
  }

 private:
  // ioctl, repeated if a signal interrupted it.
  int call(unsigned long request, void* argument) {
    int result = 0;
    do {
      result = ioctl(fd_, request, argument);
    } while (result != 0 && errno == EINTR);
    return result;
  }

  // For the call that has just failed.
  DeviceFault fault(const std::string& deed) const {
    switch (errno) {
      case ENODEV:
      case ENXIO:
        return {FaultKind::kNoContact,
                "camera " + path_ +
                    " was unplugged; plug it in again and resume (the names in "
                    "/dev/v4l/by-id stay the same)"};
      case EBUSY:
        return {FaultKind::kBusy, "camera " + path_ +
                                      " is in use by another program; end that (fuser -v " + path_ +
                                      " names it)"};
      default:
        return {FaultKind::kNoContact, "camera " + path_ + " cannot " + deed + " (" +
                                           reason(errno) + "); plug it in again, or see dmesg"};
    }
  }

  v4l2_format current_format() {
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (call(VIDIOC_G_FMT, &format) != 0) throw fault("report its format");
    return format;
  }

  // Starts from the current format, so that the other fields keep values that the driver knows.
  VideoFormat exchange_format(unsigned long request, const std::string& pixels, PanoramaSize size) {
    v4l2_format format = current_format();
    format.fmt.pix.pixelformat = fourcc_of(pixels);
    format.fmt.pix.width = static_cast<__u32>(size.width);
    format.fmt.pix.height = static_cast<__u32>(size.height);
    format.fmt.pix.field = V4L2_FIELD_NONE;
    format.fmt.pix.bytesperline = 0;
    if (call(request, &format) != 0) throw fault("set a format");
    return format_of(format.fmt.pix);
  }

  static v4l2_buffer buffer_at(__u32 index) {
    v4l2_buffer buffer{};
    buffer.index = index;
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    return buffer;
  }

  void queue(__u32 index) {
    v4l2_buffer buffer = buffer_at(index);
    if (call(VIDIOC_QBUF, &buffer) != 0) throw fault("queue a buffer");
  }

  // Whether there is a frame, or an error that VIDIOC_DQBUF will report.
  bool wait(Duration timeout) {
    const Duration patience = std::max(timeout, Duration::zero());
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(patience);
    const timespec limit{seconds.count(), (patience - seconds).count()};
    pollfd frames{.fd = fd_, .events = POLLIN, .revents = 0};
    return ppoll(&frames, 1, &limit, nullptr) > 0;
  }

  VideoFrame frame_of(const v4l2_buffer& buffer) const {
    VideoFrame frame;
    // Never beyond the buffer, whatever size the driver reports.
    const auto& [data, size] = buffers_.at(buffer.index);
    frame.bytes = {static_cast<const std::byte*>(data),
                   std::min<std::size_t>(buffer.bytesused, size)};
    frame.is_damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
    if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) {
      frame.stamped_at = SteadyTime{std::chrono::seconds(buffer.timestamp.tv_sec) +
                                    std::chrono::microseconds(buffer.timestamp.tv_usec)};
    }
    return frame;
  }

  int fd_;
  std::string path_;
  v4l2_capability capability_{};
  std::vector<std::pair<void*, std::size_t>> buffers_;  // of the driver, mapped: address and size
  std::optional<__u32> lent_;                           // the buffer of the frame returned last
  bool is_streaming_ = false;
};

DeviceFault open_fault(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return {FaultKind::kNoContact, "no camera at " + path +
                                         "; plug it in, or set camera.v4l2.device to one that "
                                         "v4l2-ctl --list-devices names"};
    case EACCES:
    case EPERM:
      return {FaultKind::kNoContact,
              "no permission for camera " + path + "; add this user to the group video"};
    default:
      return {FaultKind::kNoContact, "cannot open camera " + path + " (" + reason(error) +
                                         "); see v4l2-ctl --list-devices"};
  }
}

}  // namespace

std::unique_ptr<VideoDevice> open_video_device(const std::string& path) {
  const int fd = open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) throw open_fault(path, errno);
  auto device = std::make_unique<V4l2Device>(fd, path);
  if (device->is_camera()) return device;
  throw DeviceFault(FaultKind::kWrongDevice,
                    path +
                        " is not a camera that streams; set camera.v4l2.device to one that "
                        "v4l2-ctl --list-devices names (of several, usually the first)");
}

}  // namespace raywalk::capture
