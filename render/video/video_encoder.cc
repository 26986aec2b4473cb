#include "render/video/video_encoder.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/child_process.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "render/video/video_file.h"

namespace raywalk::render {
namespace {

std::string last_line(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = text.find_last_of("\r\n");
    std::string line = one_line(end == std::string_view::npos ? text : text.substr(end + 1));
    if (!line.empty()) return line;
    text = text.substr(0, end == std::string_view::npos ? 0 : end);
  }
  return {};
}

std::vector<std::string> ffmpeg_arguments(const VideoSettings& settings, const VideoShape& shape,
                                          const std::filesystem::path& file) {
  std::vector<std::string> arguments = {"-hide_banner",
                                        "-nostdin",
                                        "-xerror",
                                        "-loglevel",
                                        "error",
                                        "-f",
                                        "rawvideo",
                                        "-pixel_format",
                                        "bgr24",
                                        "-video_size",
                                        fmt::format("{}x{}", shape.size.width, shape.size.height),
                                        "-framerate",
                                        fmt::format("{}", settings.fps),
                                        "-i",
                                        "pipe:0",
                                        "-an"};
  const std::vector<std::string> coding = codec_arguments(settings);
  arguments.insert(arguments.end(), coding.begin(), coding.end());
  // Room for the description before the frames, so that players begin before they have read all of
  // a video: the sizes, times and places of its frames, of some 40 bytes each at most, and the
  // rest.
  constexpr std::int64_t kFrameBytes = 64, kOtherBytes = 16384 + kSphericalBytes;
  arguments.insert(arguments.end(),
                   {"-moov_size", std::to_string(shape.frames * kFrameBytes + kOtherBytes)});
  // "file:" so that no name is taken for a protocol or a flag.
  arguments.insert(arguments.end(),
                   {"-metadata", std::string("comment=") + kVideoComment, "file:" + file.string()});
  return arguments;
}

}  // namespace

// What ffmpeg prints, in memory: on a full disk a file could not take it.
class VideoEncoder::Log {
 public:
  Log() : file_(memfd_create("ffmpeg", MFD_CLOEXEC)) {
    if (file_ < 0) {
      throw Error(fmt::format("no memory for what ffmpeg prints ({})",
                              std::generic_category().message(errno)));
    }
  }
  ~Log() { close(file_); }
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  std::filesystem::path path() const { return fmt::format("/proc/self/fd/{}", file_); }
  std::string text() const {
    constexpr off_t kMost = off_t{64} << 10;
    const off_t size = lseek(file_, 0, SEEK_END);
    const off_t from = std::max<off_t>(0, size - kMost);
    std::string text(static_cast<std::size_t>(size - from), '\0');
    const ssize_t count = pread(file_, text.data(), text.size(), from);
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    return text;
  }

 private:
  int file_;
};

std::filesystem::path find_ffmpeg() {
  auto ffmpeg = find_program("ffmpeg");
  if (!ffmpeg) {
    throw Error(
        "no ffmpeg found in PATH, which videos need; install it (Debian: apt install "
        "ffmpeg), or leave --video out for pictures");
  }
  return *std::move(ffmpeg);
}

VideoEncoder::VideoEncoder(const VideoSettings& settings, const VideoShape& shape,
                           const std::filesystem::path& file, const std::string& name)
    : name_(name), size_(shape.size), log_(std::make_unique<Log>()) {
  // SVT-AV1 prints its settings unless it is told to print errors alone.
  std::vector<std::string> words = ffmpeg_arguments(settings, shape, file);
  words.insert(words.begin(), {"SVT_LOG=1", find_ffmpeg().string()});
  ffmpeg_ =
      std::make_unique<ChildProcess>("/usr/bin/env", words, log_->path(), ChildInput::kWritten);
}

VideoEncoder::~VideoEncoder() = default;

void VideoEncoder::add(const cv::Mat& frame) {
  if (frame.size() != size_ || frame.type() != CV_8UC3) {
    throw Error(fmt::format("{}: a frame of {}x{} in a video of {}x{}", name_, frame.cols,
                            frame.rows, size_.width, size_.height));
  }
  const cv::Mat pixels = frame.isContinuous() ? frame : frame.clone();
  const std::size_t bytes = pixels.total() * pixels.elemSize();
  if (!ffmpeg_->write_input(std::as_bytes(std::span(pixels.data, bytes)))) throw_failure();
  ++frames_;
}

void VideoEncoder::finish() {
  ffmpeg_->end_input();
  if (!succeeded(ffmpeg_->wait())) throw_failure();
}

void VideoEncoder::throw_failure() {
  // One that only stopped reading ends now, or is made to.
  ffmpeg_->end_input();
  const int status = ffmpeg_->wait();
  const std::string line = last_line(log_->text());
  throw Error(fmt::format("cannot write {}: ffmpeg {} after {}{}", name_,
                          succeeded(status) ? "ended" : describe_failure(status),
                          counted(frames_, "frame"), line.empty() ? "" : " (" + line + ")"));
}

}  // namespace raywalk::render
