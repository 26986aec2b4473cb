// The allowed range of the carriage. Sliders take targets only as SafePosition, which only
// SoftLimits creates, so no code can command a move outside the limits.
#pragma once

#include <string>

namespace raywalk::capture {

// A position on the rail, in millimetres from its home, within soft limits.
class SafePosition {
 public:
  double mm() const { return mm_; }

 private:
  friend class SoftLimits;
  explicit SafePosition(double mm) : mm_(mm) {}

  double mm_;
};

// A closed interval in millimetres.
class SoftLimits {
 public:
  // Throws UsageError if a limit is not finite or low_mm is not below high_mm.
  SoftLimits(double low_mm, double high_mm);

  double low_mm() const { return low_mm_; }
  double high_mm() const { return high_mm_; }
  bool contains(double mm) const { return mm >= low_mm_ && mm <= high_mm_; }
  // Throws UsageError, starting with `what` ("station x0_003"), if the position is not finite or
  // outside the limits.
  SafePosition require(double mm, const std::string& what) const;

 private:
  double low_mm_;
  double high_mm_;
};

}  // namespace raywalk::capture
