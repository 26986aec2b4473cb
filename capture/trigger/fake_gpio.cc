#include "capture/trigger/fake_gpio.h"

#include <fmt/format.h>

#include <cerrno>
#include <utility>

namespace raywalk::capture {
namespace {

constexpr const char* kPath = "/dev/gpiochip-fake";

}  // namespace

class FakeGpioOutput final : public GpioOutput {
 public:
  FakeGpioOutput(FakeGpio* gpio, const GpioLine& line) : gpio_(gpio), line_(line) {
    gpio_->set_voltage(line.offset, line.active_low);
  }
  ~FakeGpioOutput() override {
    try {
      set(false);
    } catch (const DeviceFault&) {
      // The chip was removed, and the line with it.
    }
    gpio_->give_back(line_.offset);
  }

  void set(bool active) override { gpio_->set_voltage(line_.offset, active != line_.active_low); }

 private:
  FakeGpio* gpio_;
  GpioLine line_;
};

class FakeGpioInput final : public GpioInput {
 public:
  FakeGpioInput(FakeGpio* gpio, const GpioLine& line) : gpio_(gpio), line_(line) {}
  ~FakeGpioInput() override { gpio_->give_back(line_.offset); }

  bool is_active() override {
    gpio_->catch_up();
    return gpio_->busy_ != is_inverted();
  }

  std::optional<GpioEdge> wait_edge(Duration timeout) override {
    gpio_->catch_up();
    if (gpio_->queued_.empty()) {
      Duration wait = timeout;
      if (!gpio_->coming_.empty()) {
        wait = std::min(wait, gpio_->coming_.front().time - gpio_->clock_->now());
      }
      gpio_->clock_->sleep(wait);
      gpio_->catch_up();
    }
    if (gpio_->queued_.empty()) return std::nullopt;
    GpioEdge edge = gpio_->queued_.front();
    gpio_->queued_.pop_front();
    edge.active = edge.active != is_inverted();
    return edge;
  }

 private:
  // Whether the program's active_low setting differs from the wiring.
  bool is_inverted() const { return line_.active_low != gpio_->settings_.busy_active_low; }

  FakeGpio* gpio_;
  GpioLine line_;
};

class FakeGpioChip final : public GpioChip {
 public:
  explicit FakeGpioChip(FakeGpio* gpio) : gpio_(gpio) {}

  std::string description() const override {
    return fmt::format("{} (fake, {} lines)", kPath, gpio_->settings_.lines);
  }
  std::unique_ptr<GpioOutput> request_output(const GpioLine& line) override {
    gpio_->take(line);
    return std::make_unique<FakeGpioOutput>(gpio_, line);
  }
  std::unique_ptr<GpioInput> request_input(const GpioLine& line) override {
    gpio_->take(line);
    return std::make_unique<FakeGpioInput>(gpio_, line);
  }

 private:
  FakeGpio* gpio_;
};

FakeGpio::FakeGpio(FakeGpioSettings settings, Clock* clock)
    : settings_(std::move(settings)),
      clock_(clock),
      owned_(static_cast<std::size_t>(settings_.lines), false) {}

std::unique_ptr<GpioChip> FakeGpio::open() {
  if (settings_.open_error != 0) throw gpio_open_fault(kPath, settings_.open_error);
  return std::make_unique<FakeGpioChip>(this);
}

void FakeGpio::take(const GpioLine& line) {
  GpioRequestFailure failure{.path = kPath,
                             .offset = line.offset,
                             .line_count = settings_.lines,
                             .error = EBUSY,
                             .consumer = "raywalk-capture"};
  if (line.offset < 0 || line.offset >= settings_.lines) throw gpio_request_fault(failure);
  if (line.offset == settings_.taken_line) {
    failure.consumer = settings_.taken_by;
    throw gpio_request_fault(failure);
  }
  std::vector<bool>::reference owned = owned_[static_cast<std::size_t>(line.offset)];
  if (owned) throw gpio_request_fault(failure);
  owned = true;
}

void FakeGpio::set_voltage(int line, bool high) {
  const bool has_gone = settings_.gone_after_changes >= 0 &&
                        changes_.size() >= static_cast<std::size_t>(settings_.gone_after_changes);
  if (has_gone) throw gpio_line_fault(kPath, line, ENODEV);
  // The wiring holds a line that was never driven at the camera's inactive level.
  const auto [level, is_new] = high_.try_emplace(line, settings_.shutter_active_low);
  if (level->second == high) return;
  level->second = high;
  changes_.push_back({line, high, clock_->now()});
  if (line == settings_.shutter_line && high != settings_.shutter_active_low) press_camera();
}

void FakeGpio::press_camera() {
  catch_up();
  ++presses_;
  if (settings_.films) {
    filming_ = !filming_;
  } else if (busy_ || !coming_.empty()) {
    return;
  }
  plan_busy();
}

void FakeGpio::plan_busy() {
  if (misbehaves(FakeGpioCamera::kNeverBusy)) return;
  const SteadyTime change = clock_->now() + duration_from_ms(settings_.busy_delay_ms);
  if (settings_.films && !filming_) {
    if (!misbehaves(FakeGpioCamera::kBusyForEver)) coming_.push_back({false, change});
    return;
  }
  coming_.push_back({true, change});
  if (settings_.films || misbehaves(FakeGpioCamera::kBusyForEver)) return;
  coming_.push_back({false, change + duration_from_ms(settings_.busy_ms)});
}

bool FakeGpio::misbehaves(FakeGpioCamera how) const {
  return settings_.camera == how && (settings_.bad_press == 0 || settings_.bad_press == presses_);
}

void FakeGpio::catch_up() {
  while (!coming_.empty() && coming_.front().time <= clock_->now()) {
    busy_ = coming_.front().active;
    queued_.push_back(coming_.front());
    coming_.pop_front();
  }
}

}  // namespace raywalk::capture
