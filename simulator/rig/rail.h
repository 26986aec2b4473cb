// The true pose of the simulated rail, which deviates from the plan, and of the camera on its
// carriage.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/base/clock.h"
#include "capture/plan/capture_plan.h"
#include "simulator/room/cameras.h"

namespace raywalk::simulator {

using capture::CaptureLine;
using capture::CapturePlan;
using capture::CaptureStation;
using capture::Duration;

// Spreads and jitters are standard deviations. Errors of a placing depend only on the seed and the
// id of the line's placement, jitter also on the station's number on the line, so repeated placings
// and pictures are identical.
struct RailSettings {
  int seed = 1;
  double placing_spread_mm = 2.0;     // across the line, along it and in height, each
  double direction_spread_deg = 0.2;  // yaw of the rail around the line's middle
  double tilt_spread_deg = 0.1;       // of its far end, upwards
  double sag_mm = 0.5;                // at mid-span, downwards
  double bow_mm = 0.3;                // at mid-span, to the left as seen along the line
  double twist_deg = 0.0;  // of the far end against the near one, clockwise as seen along the line
  double attitude_spread_deg = 0.2;  // yaw, pitch and roll of the camera on the carriage, each
  // Independent error of each station: of the position along each axis; of yaw, pitch and roll.
  double jitter_mm = 0.0;
  double jitter_deg = 0.0;
  double vibration_mm = 0.5;  // amplitude A while moving and when stopping
  double vibration_hz = 7.0;
  double vibration_decay_ms = 150.0;  // time constant: decays to 1/e
};

// The span of the rail between its two supports, rail positions in millimetres.
struct RailSpan {
  double low_mm = 0.0;
  double high_mm = 2000.0;
};

class Rail {
 public:
  // Throws Error for a span that is not positive.
  Rail(const RailSettings& settings, const CapturePlan& plan, const RailSpan& span);

  // By placement_id of capture_plan.h, as all ids of lines here.
  bool has_line(const std::string& line_id) const { return placings_.contains(line_id); }

  // The camera's pose with the rail placed at a line and the carriage at a rail position
  // (millimetres from home), `still_for` after it stopped (empty: moving). World frame, metres.
  // Throws Error if the plan does not have the line.
  //
  // With u from -1 to 1 along the span, a rail held at its ends sags by sag (1 - u^2), which is
  // within 2 % of the curve of a uniformly loaded beam, and bows likewise. Twist is linear in u.
  // The camera rotates with the rail's slope and twist. The jitter is that of the nearest station.
  // Vibration displaces the camera vertically and along the line by
  //   A exp(-t / decay) cos(2 pi f t + phase),
  // where the phase depends on the position.
  CameraPose carriage_pose(const std::string& line_id, double carriage_mm,
                           std::optional<Duration> still_for) const;

 private:
  // A line with its errors.
  struct Placing {
    LineAxis axis = LineAxis::kX;
    Eigen::Vector3d middle_m{0, 0, 0};  // true position of the line's middle
    double middle_mm = 0.0;             // its rail position
    double direction_rad = 0.0;         // error, as a yaw
    double tilt_rad = 0.0;
    Attitude camera{};                  // errors of the camera on the carriage
    std::uint64_t key = 0;              // of its stations' jitter
    std::vector<double> stations_mm{};  // rail positions
  };

  Placing placed(const CaptureLine& line) const;
  double vibration_mm(double carriage_mm, std::optional<Duration> still_for,
                      std::uint64_t direction) const;

  RailSettings settings_;
  RailSpan span_;
  std::map<std::string, Placing> placings_;
};

}  // namespace raywalk::simulator
