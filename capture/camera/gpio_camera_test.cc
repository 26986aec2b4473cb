#include "capture/camera/gpio_camera.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <deque>
#include <map>
#include <set>
#include <vector>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;

constexpr const char* kPath = "/dev/gpiochip-fake";
constexpr int kFocus = 0, kShutter = 1, kBusy = 2, kLines = 8;

enum class Misbehaves { kNever, kNeverBusy, kBusyForEver };

struct Wiring {
  bool active_low = false;  // as wired, independent of the program's settings
  double busy_delay_ms = 30.0;
  double busy_ms = 400.0;
  bool records_video = false;  // a press starts a video, the next one stops it
  Misbehaves camera = Misbehaves::kNever;
  int bad_press = 0;            // the only press, from 1, that misbehaves; 0: all
  int taken_line = -1;          // owned by another program
  int gone_after_changes = -1;  // the chip is removed after this many changes of outputs; -1: never
};

// A change of an output's voltage.
struct Change {
  int line;
  bool high;
  double ms;
  friend bool operator==(const Change&, const Change&) = default;
};

// A chip and the camera that is wired to it, in simulated time. Outlives the chips that it opens.
struct FakeGpio {
  FakeGpio(const Wiring& wired, Clock* time) : wiring(wired), clock(time) {}

  std::unique_ptr<GpioChip> open();

  bool is_released() const {
    return std::ranges::all_of(high,
                               [this](auto& line) { return line.second == wiring.active_low; });
  }
  void set_voltage(int line, bool value) {
    if (wiring.gone_after_changes == static_cast<int>(changes.size())) {
      throw gpio_line_fault(kPath, line, ENODEV);
    }
    // The wiring holds a line that was never driven at the camera's inactive level.
    bool& level = high.try_emplace(line, wiring.active_low).first->second;
    if (level == value) return;
    level = value;
    changes.push_back({line, value, ms_from_duration(clock->now().time_since_epoch())});
    if (line == kShutter && value != wiring.active_low) press();
  }
  void press() {
    catch_up();
    ++presses;
    const bool misbehaves = wiring.bad_press == 0 || wiring.bad_press == presses;
    const bool for_ever = misbehaves && wiring.camera == Misbehaves::kBusyForEver;
    const bool is_end = wiring.records_video && busy;
    if ((busy && !wiring.records_video) || (misbehaves && wiring.camera == Misbehaves::kNeverBusy))
      return;
    const SteadyTime change = clock->now() + duration_from_ms(wiring.busy_delay_ms);
    if (!is_end) edges.push_back(change);
    if (wiring.records_video ? is_end && !for_ever : !for_ever) {
      edges.push_back(change + duration_from_ms(is_end ? 0.0 : wiring.busy_ms));
    }
  }
  // Applies the edges of the busy line that are due.
  void catch_up() {
    for (; !edges.empty() && edges.front() <= clock->now(); edges.pop_front()) {
      busy = !busy;
      queued.push_back(edges.front());
    }
  }

  Wiring wiring;
  Clock* clock;
  std::set<int> owned{};
  std::map<int, bool> high{};  // outputs that were ever driven
  std::vector<Change> changes{};
  int presses = 0;  // also those that a busy camera ignored
  bool busy = false;
  std::deque<SteadyTime> edges{};   // of the busy line, to come
  std::deque<SteadyTime> queued{};  // in the kernel's queue
};

class FakeLine final : public GpioLine {
 public:
  FakeLine(FakeGpio* gpio, const GpioRequest& line) : gpio_(gpio), line_(line) {
    if (line.is_output) gpio_->set_voltage(line.offset, line.active_low);
  }
  ~FakeLine() override { gpio_->owned.erase(line_.offset); }

  void set(bool active) override { gpio_->set_voltage(line_.offset, active != line_.active_low); }
  bool is_active() override {
    gpio_->catch_up();
    return gpio_->busy != (line_.active_low != gpio_->wiring.active_low);
  }
  std::optional<SteadyTime> wait_edge(Duration timeout) override {
    gpio_->catch_up();
    if (gpio_->queued.empty()) {
      const Duration next =
          gpio_->edges.empty() ? timeout : gpio_->edges.front() - gpio_->clock->now();
      gpio_->clock->sleep(std::min(timeout, next));
      gpio_->catch_up();
    }
    if (gpio_->queued.empty()) return std::nullopt;
    const SteadyTime edge = gpio_->queued.front();
    gpio_->queued.pop_front();
    return edge;
  }

 private:
  FakeGpio* gpio_;
  GpioRequest line_;
};

class FakeChip final : public GpioChip {
 public:
  explicit FakeChip(FakeGpio* gpio) : gpio_(gpio) {}

  std::string description() const override { return "/dev/gpiochip-fake (fake, 8 lines)"; }
  std::unique_ptr<GpioLine> request(const GpioRequest& line) override {
    const bool is_taken = line.offset == gpio_->wiring.taken_line;
    if (line.offset >= kLines || is_taken || !gpio_->owned.insert(line.offset).second) {
      throw gpio_request_fault({.path = kPath,
                                .offset = line.offset,
                                .line_count = kLines,
                                .error = EBUSY,
                                .consumer = is_taken ? "lirc" : kGpioConsumer});
    }
    return std::make_unique<FakeLine>(gpio_, line);
  }

 private:
  FakeGpio* gpio_;
};

std::unique_ptr<GpioChip> FakeGpio::open() { return std::make_unique<FakeChip>(this); }

TriggerConfig wired(int focus_line = kFocus, int busy_line = kBusy) {
  return {.focus_line = focus_line, .shutter_line = kShutter, .busy_line = busy_line};
}

struct CableRig {
  explicit CableRig(const Wiring& wiring, const TriggerConfig& config = wired())
      : gpio(wiring, &clock), camera(config, gpio.open(), &clock) {}

  Shot shoot() { return camera.shoot(clock.now()); }
  void expect_fault(FaultKind kind, const std::string& words) {
    raywalk::capture::expect_fault(kind, words, [this] { shoot(); });
    EXPECT_TRUE(gpio.is_released());
  }

  ManualClock clock;
  const WallTime start = clock.wall_now();
  FakeGpio gpio;
  GpioCamera camera;
};

TEST(GpioCamera, PressesHalfThenFullyThenReleasesAndBringsNoPicture) {
  CableRig rig({});
  const Shot shot = rig.shoot();
  EXPECT_THAT(rig.gpio.changes,
              ElementsAre(Change{kFocus, true, 0}, Change{kShutter, true, 300},
                          Change{kShutter, false, 400}, Change{kFocus, false, 400}));
  EXPECT_TRUE(rig.camera.keeps_pictures());
  EXPECT_TRUE(shot.pictures.empty());
  EXPECT_EQ(shot.triggered_at, rig.start + milliseconds(300));
  EXPECT_EQ(shot.exposed_at, rig.start + milliseconds(330));
  EXPECT_DOUBLE_EQ(shot.exposing_ms, 430.0);
}

TEST(GpioCamera, ActiveLowLinesAreHighBetweenPresses) {
  TriggerConfig config = wired(-1);
  config.active_low = config.busy_active_low = true;
  CableRig rig({.active_low = true}, config);
  EXPECT_EQ(rig.camera.report().state, "idle");
  rig.shoot();
  EXPECT_THAT(rig.gpio.changes,
              ElementsAre(Change{kShutter, false, 0}, Change{kShutter, true, 100}));
}

TEST(GpioCamera, TimesFollowTheBusyLineIfThereIsOne) {
  struct Case {
    const char* what;
    TriggerConfig config;
    Wiring wiring;
    double exposed_ms, done_ms;
  };
  for (const Case& each : {Case{"a pulse within the press", wired(), {false, 10, 1}, 10, 100},
                           {"no focus line", wired(-1), {}, 30, 430},
                           {"no busy line", wired(kFocus, -1), {}, 0, 2100}}) {
    SCOPED_TRACE(each.what);
    CableRig rig(each.wiring, each.config);
    const Shot shot = rig.shoot();
    EXPECT_EQ(shot.exposed_at - shot.triggered_at, duration_from_ms(each.exposed_ms));
    EXPECT_DOUBLE_EQ(shot.exposing_ms, each.done_ms);
  }
}

TEST(GpioCamera, NeverPressesBeforeTheCarriageSettled) {
  CableRig rig({}, wired(-1));
  rig.camera.shoot(rig.clock.now() + milliseconds(700));
  EXPECT_EQ(rig.gpio.changes.front().ms, 700.0);
}

TEST(GpioCamera, BracketIsAPressPerExposureOrOneForAll) {
  for (const bool per_exposure : {true, false}) {
    TriggerConfig config = wired();
    config.press_per_exposure = per_exposure;
    CableRig rig({}, config);
    rig.camera.prepare({.bracket_ev = {-2.0, 0.0, 2.0}}, "");
    for (int station = 0; station < 100; ++station) rig.shoot();
    EXPECT_EQ(rig.gpio.presses, per_exposure ? 300 : 100);
  }
}

TEST(GpioCamera, RefusesExposureSettings) {
  CableRig rig({});
  EXPECT_THROW(rig.camera.prepare({.shutter_s = 0.01}, ""), UsageError);
  EXPECT_EQ(rig.camera.prepare({}, ""), "");
}

TEST(GpioCamera, VideoIsAPressAtEachEndAndTheBusyLineIsReported) {
  CableRig rig({.busy_delay_ms = 40, .records_video = true});
  EXPECT_EQ(rig.camera.report().identity, "camera on line 1 of /dev/gpiochip-fake (fake, 8 lines)");
  rig.camera.start_video();
  rig.clock.sleep(std::chrono::seconds(60));
  EXPECT_EQ(rig.camera.report().state, "busy");
  rig.camera.stop_video();
  EXPECT_EQ(rig.camera.report().state, "idle");
  EXPECT_EQ(rig.gpio.presses, 2);
  EXPECT_EQ(CableRig({}, wired(kFocus, -1)).camera.report().state, "unknown");
}

TEST(GpioCamera, VideoThatDoesNotStartOrStopIsAFault) {
  CableRig dead({.records_video = true, .camera = Misbehaves::kNeverBusy});
  EXPECT_EQ(fault_of([&] { dead.camera.start_video(); }).kind(), FaultKind::kMissingPicture);
  CableRig endless({.records_video = true, .camera = Misbehaves::kBusyForEver});
  endless.camera.start_video();
  EXPECT_EQ(fault_of([&] { endless.camera.stop_video(); }).kind(), FaultKind::kBusy);
}

TEST(GpioCamera, WaitsForACameraThatIsStillBusy) {
  CableRig rig({.busy_delay_ms = 0, .busy_ms = 5000});
  rig.camera.start_video();  // returns as soon as the camera is busy
  EXPECT_EQ(rig.shoot().triggered_at, rig.start + milliseconds(300 + 5000 + 300));
}

TEST(GpioCamera, CameraThatNeverBecomesBusyTookNoPictureAndTheNextPressDoes) {
  CableRig rig({.camera = Misbehaves::kNeverBusy, .bad_press = 1});
  rig.expect_fault(FaultKind::kMissingPicture, "did not become busy within 2000 ms of the shutter");
  EXPECT_EQ(rig.clock.wall_now(), rig.start + milliseconds(300 + 2000));
  EXPECT_NO_THROW(rig.shoot());
}

TEST(GpioCamera, CameraThatStaysBusyIsAFault) {
  CableRig rig({.camera = Misbehaves::kBusyForEver});
  rig.expect_fault(FaultKind::kBusy, "stayed busy for 30000 ms after the shutter");
  rig.expect_fault(FaultKind::kBusy, "before the shutter");
  EXPECT_EQ(rig.gpio.presses, 1) << "pressed although the camera was busy";
}

TEST(GpioCamera, ChipRemovedDuringAPressIsNoContact) {
  CableRig rig({.gone_after_changes = 2});
  expect_fault(FaultKind::kNoContact, "line 1 of /dev/gpiochip-fake no longer answers",
               [&] { rig.shoot(); });
}

TEST(GpioCamera, OwnsItsLinesUntilDestroyed) {
  ManualClock clock;
  FakeGpio gpio({}, &clock);
  {
    const GpioCamera camera(wired(), gpio.open(), &clock);
    EXPECT_THAT(gpio.owned, ElementsAre(kFocus, kShutter, kBusy));
    expect_fault(FaultKind::kNoContact, "in use by 'raywalk-capture'",
                 [&] { const GpioCamera second(wired(), gpio.open(), &clock); });
  }
  EXPECT_TRUE(gpio.owned.empty());
}

TEST(GpioCamera, NamesWhatCannotBeUsed) {
  expect_fault(FaultKind::kNoContact, "line 2 of /dev/gpiochip-fake is in use by 'lirc'",
               [] { CableRig rig({.taken_line = 2}); });
  expect_fault(FaultKind::kWrongDevice, "no line 8 of /dev/gpiochip-fake, which has 8 lines",
               [] { CableRig rig({}, wired(kLines)); });
  EXPECT_THROW(CableRig({}, TriggerConfig{}), UsageError) << "no shutter line";
  EXPECT_EQ(gpio_open_fault(kPath, ENOENT).kind(), FaultKind::kNoContact);
  EXPECT_THAT(gpio_open_fault(kPath, EACCES).what(), testing::HasSubstr("no permission"));
  EXPECT_EQ(gpio_open_fault(kPath, ENOTTY).kind(), FaultKind::kWrongDevice);
}

// tests/kernel runs the lines themselves on real kernel drivers.
TEST(GpioLines, WhatIsNoChipIsNamed) {
  expect_fault(FaultKind::kNoContact,
               "no GPIO chip /dev/gpiochip-missing; set trigger.chip to one that gpiodetect lists",
               [] { open_gpio_chip("gpiochip-missing"); });
  expect_fault(FaultKind::kWrongDevice, "/dev/null is not a GPIO chip",
               [] { open_gpio_chip("/dev/null"); });
}

// Raises SIGINT at a time, as an operator might at any moment.
class InterruptingClock final : public Clock {
 public:
  explicit InterruptingClock(double ms) : when_(duration_from_ms(ms)) {}
  SteadyTime now() const override { return clock_.now(); }
  WallTime wall_now() const override { return clock_.wall_now(); }
  void sleep(Duration duration) override {
    clock_.sleep(duration);
    if (clock_.now() >= when_ && !interrupt_requested()) std::raise(SIGINT);
  }

 private:
  ManualClock clock_;
  SteadyTime when_;
};

// Exit code: the changes of lines before the interruption; 0 if not all are released.
void interrupt_picture_at(double ms) {
  install_interrupt_handlers();
  InterruptingClock clock(ms);
  FakeGpio gpio({.camera = Misbehaves::kBusyForEver}, &clock);
  GpioCamera camera(wired(), gpio.open(), &clock);
  EXPECT_THROW(camera.shoot(clock.now()), Interrupted);
  const bool is_well = gpio.is_released() && !testing::Test::HasFailure();
  std::exit(is_well ? static_cast<int>(gpio.changes.size()) : 0);
}

TEST(GpioCameraDeathTest, InterruptAtTheHalfPressTakesNoPictureAndAnyReleasesTheLines) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  for (const auto& [ms, code] : {std::pair{100.0, 2}, {300.0, 2}, {350.0, 4}, {5000.0, 4}}) {
    EXPECT_EXIT(interrupt_picture_at(ms), testing::ExitedWithCode(code), "") << ms;
  }
}

}  // namespace
}  // namespace raywalk::capture
