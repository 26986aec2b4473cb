// gpio_lines.h over libgpiod 1.6 (Debian 12).

#include <gpiod.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <utility>

#include "capture/camera/gpio_lines.h"

namespace raywalk::capture {
namespace {

struct ChipCloser {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
using ChipHandle = std::unique_ptr<gpiod_chip, ChipCloser>;

// Owns the request of a line; the line itself belongs to its chip.
class GpiodLine final : public GpioLine {
 public:
  GpiodLine(gpiod_line* line, std::string path) : line_(line), path_(std::move(path)) {}
  ~GpiodLine() override { gpiod_line_release(line_); }

  void set(bool active) override {
    if (gpiod_line_set_value(line_, active ? 1 : 0) != 0) throw fault();
  }

  bool is_active() override {
    const int value = gpiod_line_get_value(line_);
    if (value < 0) throw fault();
    return value == 1;
  }

  std::optional<SteadyTime> wait_edge(Duration timeout) override {
    const Duration patience = std::max(timeout, Duration::zero());
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(patience);
    const timespec wait{seconds.count(), (patience - seconds).count()};
    const int waited = gpiod_line_event_wait(line_, &wait);
    if (waited == 0 || (waited < 0 && errno == EINTR)) return std::nullopt;
    gpiod_line_event event{};
    if (waited < 0 || gpiod_line_event_read(line_, &event) != 0) throw fault();
    return SteadyTime{std::chrono::seconds(event.ts.tv_sec) +
                      std::chrono::nanoseconds(event.ts.tv_nsec)};
  }

 private:
  // Reads errno of the failed call.
  DeviceFault fault() const {
    const int error = errno;
    return gpio_line_fault(path_, static_cast<int>(gpiod_line_offset(line_)), error);
  }

  gpiod_line* line_;
  std::string path_;
};

class GpiodChip final : public GpioChip {
 public:
  GpiodChip(ChipHandle chip, std::string path) : chip_(std::move(chip)), path_(std::move(path)) {}

  std::string description() const override {
    return path_ + " (" + gpiod_chip_label(chip_.get()) + ", " + std::to_string(line_count()) +
           " lines)";
  }

  std::unique_ptr<GpioLine> request(const GpioRequest& line) override {
    errno = EINVAL;
    gpiod_line* const handle =
        line.offset < 0 ? nullptr
                        : gpiod_chip_get_line(chip_.get(), static_cast<unsigned int>(line.offset));
    if (handle == nullptr) throw refusal(line.offset, nullptr);
    const int flags = line.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
    // The last argument is the initial logical level.
    const int result =
        line.is_output ? gpiod_line_request_output_flags(handle, kGpioConsumer, flags, 0)
                       : gpiod_line_request_both_edges_events_flags(handle, kGpioConsumer, flags);
    if (result != 0) throw refusal(line.offset, handle);
    return std::make_unique<GpiodLine>(handle, path_);
  }

 private:
  int line_count() const { return static_cast<int>(gpiod_chip_num_lines(chip_.get())); }

  // Reads errno of the failed call.
  DeviceFault refusal(int offset, gpiod_line* handle) const {
    GpioRequestFailure failure{
        .path = path_, .offset = offset, .line_count = line_count(), .error = errno};
    // The library's copy of the line's consumer is older than the request.
    if (handle != nullptr && gpiod_line_update(handle) == 0) {
      const char* const consumer = gpiod_line_consumer(handle);
      if (consumer != nullptr) failure.consumer = consumer;
    }
    return gpio_request_fault(failure);
  }

  ChipHandle chip_;
  std::string path_;
};

}  // namespace

std::unique_ptr<GpioChip> open_gpio_chip(const std::string& chip) {
  const std::string path = gpio_chip_path(chip);
  ChipHandle handle(gpiod_chip_open(path.c_str()));
  if (handle == nullptr) throw gpio_open_fault(path, errno);
  return std::make_unique<GpiodChip>(std::move(handle), path);
}

}  // namespace raywalk::capture
