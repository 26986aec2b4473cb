#include "capture/run/set_up_moves.h"

#include <fmt/format.h>

#include <memory>

#include "capture/run/open_devices.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

// A slider moved by hand; a signal stops it before the program ends.
class SliderByHand {
 public:
  explicit SliderByHand(const SliderConfig& config)
      : slider_(open_slider(config, &clock_)),
        carriage_(slider_.get(), &clock_, limits_of(config), config.motion) {}

  Slider& slider() { return *slider_; }
  Carriage& carriage() { return carriage_; }
  std::string position_text() {
    return fmt::format("slider at {:.3f} mm", slider_->read_state().position_mm);
  }

 private:
  DeferStopSignals protection_;
  SystemClock clock_;
  std::unique_ptr<Slider> slider_;
  Carriage carriage_;
};

}  // namespace

std::string home_slider(const SliderConfig& config) {
  SliderByHand by_hand(config);
  by_hand.carriage().home();
  return "homed; " + by_hand.position_text();
}

std::string jog_slider(const SliderConfig& config, double mm) {
  SliderByHand by_hand(config);
  const SliderState state = by_hand.slider().read_state();
  if (!state.homed.value_or(true)) {
    throw Error(by_hand.slider().description() +
                ": the drive is not homed; run raywalk-capture home first");
  }
  const SafePosition target = by_hand.carriage().limits().require(state.position_mm + mm, "jog");
  return fmt::format("slider at {:.3f} mm, moved by {:+.3f} mm",
                     by_hand.carriage().move_to(target).measured_mm, mm);
}

std::string stop_slider(const SliderConfig& config) {
  SliderByHand by_hand(config);
  by_hand.carriage().stop();
  return "stopped; " + by_hand.position_text();
}

}  // namespace raywalk::capture
