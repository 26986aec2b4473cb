// Whether something has held for long enough, by readings that each may be off.
#pragma once

#include <algorithm>

#include "capture/base/clock.h"

namespace raywalk::capture {

// Collects readings while they are good; one that is not starts it over. It is over once the good
// ones span the time and are at least three: a reading may be a poll old (ModbusLink says how), so
// fewer could all be of one moment.
class Dwell {
 public:
  explicit Dwell(Duration length) : length_(length) {}

  void good(SteadyTime time, double position_mm) {
    if (readings_ == 0) {
      since_ = time;
      low_mm_ = high_mm_ = position_mm;
    }
    latest_ = time;
    low_mm_ = std::min(low_mm_, position_mm);
    high_mm_ = std::max(high_mm_, position_mm);
    sum_mm_ += position_mm;
    ++readings_;
  }
  void start_over() { *this = Dwell(length_); }

  bool is_over() const { return readings_ >= kLeastReadings && latest_ - since_ >= length_; }
  bool is_empty() const { return readings_ == 0; }
  // Of a dwell that is not empty.
  double mean_mm() const { return sum_mm_ / readings_; }
  // How far apart the readings would be with this one among them.
  double spread_with_mm(double position_mm) const {
    return std::max(high_mm_, position_mm) - std::min(low_mm_, position_mm);
  }

 private:
  static constexpr int kLeastReadings = 3;

  Duration length_;
  SteadyTime since_{};
  SteadyTime latest_{};
  double sum_mm_ = 0.0;
  double low_mm_ = 0.0;
  double high_mm_ = 0.0;
  int readings_ = 0;
};

}  // namespace raywalk::capture
