// Whether a condition has held for long enough, where a single reading may be wrong.
#pragma once

#include <algorithm>

#include "capture/base/clock.h"

namespace raywalk::capture {

// Collects consecutive good readings; the caller starts over at a bad one. The dwell is over once
// there are at least three that span `length`. A reading may be one poll old (see ModbusLink), so
// fewer could all show the same moment.
class Dwell {
 public:
  explicit Dwell(Duration length) : length_(length) {}

  void add(SteadyTime time, double position_mm) {
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

  bool is_over() const { return readings_ >= kMinReadings && latest_ - since_ >= length_; }
  bool is_empty() const { return readings_ == 0; }
  // The dwell must not be empty.
  double mean_mm() const { return sum_mm_ / readings_; }
  // The range of the readings including this one. The dwell must not be empty.
  double spread_with_mm(double position_mm) const {
    return std::max(high_mm_, position_mm) - std::min(low_mm_, position_mm);
  }

 private:
  static constexpr int kMinReadings = 3;

  Duration length_;
  SteadyTime since_{};
  SteadyTime latest_{};
  double sum_mm_ = 0.0;
  double low_mm_ = 0.0;
  double high_mm_ = 0.0;
  int readings_ = 0;
};

}  // namespace raywalk::capture
