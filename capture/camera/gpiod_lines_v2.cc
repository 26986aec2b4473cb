// gpio_lines.h over libgpiod 2.x (Debian 13).

#include <gpiod.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <utility>

#include "capture/camera/gpio_lines.h"

namespace raywalk::capture {
namespace {

// Deleter that calls the library's function for the type.
template <auto kFree>
struct Freer {
  template <typename T>
  void operator()(T* object) const {
    kFree(object);
  }
};
using ChipHandle = std::unique_ptr<gpiod_chip, Freer<gpiod_chip_close>>;
using ChipInfo = std::unique_ptr<gpiod_chip_info, Freer<gpiod_chip_info_free>>;
using LineInfo = std::unique_ptr<gpiod_line_info, Freer<gpiod_line_info_free>>;
using LineSettings = std::unique_ptr<gpiod_line_settings, Freer<gpiod_line_settings_free>>;
using LineConfig = std::unique_ptr<gpiod_line_config, Freer<gpiod_line_config_free>>;
using RequestConfig = std::unique_ptr<gpiod_request_config, Freer<gpiod_request_config_free>>;
using LineRequest = std::unique_ptr<gpiod_line_request, Freer<gpiod_line_request_release>>;
using EventBuffer = std::unique_ptr<gpiod_edge_event_buffer, Freer<gpiod_edge_event_buffer_free>>;

// The library's constructors return a null pointer only when out of memory.
template <typename Handle>
Handle made(typename Handle::pointer object) {
  if (object == nullptr) throw std::bad_alloc();
  return Handle(object);
}

// One request per line.
class GpiodLine final : public GpioLine {
 public:
  GpiodLine(LineRequest request, std::string path, int offset)
      : request_(std::move(request)),
        event_(made<EventBuffer>(gpiod_edge_event_buffer_new(1))),
        path_(std::move(path)),
        offset_(static_cast<unsigned int>(offset)) {}

  void set(bool active) override {
    const auto value = active ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
    if (gpiod_line_request_set_value(request_.get(), offset_, value) != 0) throw fault();
  }

  bool is_active() override {
    const gpiod_line_value value = gpiod_line_request_get_value(request_.get(), offset_);
    if (value == GPIOD_LINE_VALUE_ERROR) throw fault();
    return value == GPIOD_LINE_VALUE_ACTIVE;
  }

  std::optional<SteadyTime> wait_edge(Duration timeout) override {
    // A negative time would wait without end.
    const int waited = gpiod_line_request_wait_edge_events(
        request_.get(), std::max(timeout, Duration::zero()).count());
    if (waited == 0 || (waited < 0 && errno == EINTR)) return std::nullopt;
    if (waited < 0 || gpiod_line_request_read_edge_events(request_.get(), event_.get(), 1) != 1) {
      throw fault();
    }
    gpiod_edge_event* const event = gpiod_edge_event_buffer_get_event(event_.get(), 0);
    return SteadyTime{std::chrono::nanoseconds(gpiod_edge_event_get_timestamp_ns(event))};
  }

 private:
  // Reads errno of the failed call.
  DeviceFault fault() const { return gpio_line_fault(path_, static_cast<int>(offset_), errno); }

  LineRequest request_;
  EventBuffer event_;
  std::string path_;  // of its chip
  unsigned int offset_;
};

LineSettings settings_for(const GpioRequest& line) {
  auto settings = made<LineSettings>(gpiod_line_settings_new());
  gpiod_line_settings_set_active_low(settings.get(), line.active_low);
  if (line.is_output) {
    gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_OUTPUT);
    gpiod_line_settings_set_output_value(settings.get(), GPIOD_LINE_VALUE_INACTIVE);
  } else {
    gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_INPUT);
    gpiod_line_settings_set_edge_detection(settings.get(), GPIOD_LINE_EDGE_BOTH);
    // The library's default; stated here because the times of edges rely on it.
    gpiod_line_settings_set_event_clock(settings.get(), GPIOD_LINE_CLOCK_MONOTONIC);
  }
  return settings;
}

class GpiodChip final : public GpioChip {
 public:
  GpiodChip(ChipHandle chip, ChipInfo info, std::string path)
      : chip_(std::move(chip)), info_(std::move(info)), path_(std::move(path)) {}

  std::string description() const override {
    return path_ + " (" + gpiod_chip_info_get_label(info_.get()) + ", " +
           std::to_string(line_count()) + " lines)";
  }

  std::unique_ptr<GpioLine> request(const GpioRequest& line) override {
    if (line.offset < 0 || line.offset >= line_count()) throw refusal(line.offset, EINVAL);
    const LineSettings settings = settings_for(line);
    const auto offset = static_cast<unsigned int>(line.offset);
    const auto config = made<LineConfig>(gpiod_line_config_new());
    if (gpiod_line_config_add_line_settings(config.get(), &offset, 1, settings.get()) != 0) {
      throw refusal(line.offset, errno);
    }
    const auto consumer = made<RequestConfig>(gpiod_request_config_new());
    gpiod_request_config_set_consumer(consumer.get(), kGpioConsumer);
    LineRequest owned(gpiod_chip_request_lines(chip_.get(), consumer.get(), config.get()));
    if (owned == nullptr) throw refusal(line.offset, errno);
    return std::make_unique<GpiodLine>(std::move(owned), path_, line.offset);
  }

 private:
  int line_count() const { return static_cast<int>(gpiod_chip_info_get_num_lines(info_.get())); }

  DeviceFault refusal(int offset, int error) const {
    GpioRequestFailure failure{
        .path = path_, .offset = offset, .line_count = line_count(), .error = error};
    if (error == EBUSY) {
      const LineInfo info(gpiod_chip_get_line_info(chip_.get(), static_cast<unsigned int>(offset)));
      const char* const consumer =
          info == nullptr ? nullptr : gpiod_line_info_get_consumer(info.get());
      if (consumer != nullptr) failure.consumer = consumer;
    }
    return gpio_request_fault(failure);
  }

  ChipHandle chip_;
  ChipInfo info_;
  std::string path_;
};

}  // namespace

std::unique_ptr<GpioChip> open_gpio_chip(const std::string& chip) {
  const std::string path = gpio_chip_path(chip);
  ChipHandle handle(gpiod_chip_open(path.c_str()));
  if (handle == nullptr) throw gpio_open_fault(path, errno);
  ChipInfo info(gpiod_chip_get_info(handle.get()));
  if (info == nullptr) throw gpio_open_fault(path, errno);
  return std::make_unique<GpiodChip>(std::move(handle), std::move(info), path);
}

}  // namespace raywalk::capture
