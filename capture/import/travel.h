// The position of the carriage during a recorded pass.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/session/session.h"

namespace raywalk::capture {

// One uninterrupted pass over a line. The position is interpolated linearly between samples. The
// carriage is assumed to be at rest for kRest_s before the first and after the last sample, and its
// position is unknown beyond.
class Travel {
 public:
  static constexpr double kRest_s = 1.5;

  // At least two samples, in ascending time; seconds since any epoch.
  Travel(std::string line, std::vector<double> times_s, std::vector<double> positions_mm);

  const std::string& line() const { return line_; }
  double begin_s() const { return times_s_.front() - kRest_s; }
  double end_s() const { return times_s_.back() + kRest_s; }
  std::optional<double> position_mm(double time_s) const;  // empty where unknown
  // Mean absolute speed between two times.
  double speed_mm_s(double from_s, double to_s) const;

 private:
  std::string line_;
  std::vector<double> times_s_;
  std::vector<double> positions_mm_;
};

// Splits the journal of a line into passes, at gaps of more than a second. Samples that are not
// later than the one before are dropped. Times are in seconds since `start`.
std::vector<Travel> travels_of(const std::string& line, std::span<const JournalSample> journal,
                               WallTime start);

}  // namespace raywalk::capture
