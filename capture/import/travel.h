// Where the carriage was at any time of a recorded pass.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/session/session.h"

namespace raywalk::capture {

// One uninterrupted pass over a line. Between samples the position is interpolated linearly; for
// kRest_s before the first and after the last the carriage is taken to stand still there, as a film
// starts and ends at rest. Beyond that nothing is known.
class Travel {
 public:
  static constexpr double kRest_s = 1.5;

  // Samples of one pass in ascending time, at least two; times are seconds since any moment.
  Travel(std::string line, std::vector<double> times_s, std::vector<double> positions_mm);

  const std::string& line() const { return line_; }
  double begin_s() const { return times_s_.front() - kRest_s; }
  double end_s() const { return times_s_.back() + kRest_s; }
  std::optional<double> position_mm(double time_s) const;
  // Over the time between two frames.
  double speed_mm_s(double from_s, double to_s) const;

 private:
  std::string line_;
  std::vector<double> times_s_;
  std::vector<double> positions_mm_;
};

// Cuts a line's journal into passes, wherever the feedback was not recorded for over a second.
// Samples out of order or at the same time as the one before are left out. Times become seconds
// since `start`.
std::vector<Travel> travels_of(const std::string& line, std::span<const JournalSample> journal,
                               WallTime start);

}  // namespace raywalk::capture
