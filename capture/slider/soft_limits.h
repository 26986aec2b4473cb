// Where the carriage may go. A position that a slider can be sent to exists only as a SafePosition,
// and only SoftLimits makes one, so no code can command a move outside of the limits.
#pragma once

#include <string>

namespace raywalk::capture {

// A position on the rail, in millimetres from its home, that lies inside soft limits.
class SafePosition {
 public:
  double mm() const { return mm_; }

 private:
  friend class SoftLimits;
  explicit SafePosition(double mm) : mm_(mm) {}

  double mm_;
};

// Both ends belong to the allowed range.
class SoftLimits {
 public:
  // Throws UsageError where a limit is not finite or low_mm is not below high_mm.
  SoftLimits(double low_mm, double high_mm);

  double low_mm() const { return low_mm_; }
  double high_mm() const { return high_mm_; }
  bool contains(double mm) const { return mm >= low_mm_ && mm <= high_mm_; }
  // Throws UsageError, starting with `what` ("station x0_003"), for a position that is not finite
  // or outside of the limits.
  SafePosition require(double mm, const std::string& what) const;

 private:
  double low_mm_;
  double high_mm_;
};

}  // namespace raywalk::capture
