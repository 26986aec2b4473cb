// The trade-off between accuracy and time of fewer keyframes: the poses solved again with several
// keyframe spacings.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "calibrate/chain/calibration.h"

namespace raywalk::calibrate {

// One spacing. Differences are to the densest spacing, over all stations, after removing the mean
// displacement, which is unobservable.
struct KeyframeTrial {
  double keyframes_mm = 0.0;  // 0: every station
  int keyframes = 0;
  double seconds = 0.0;  // of the steps poses and grid
  double median_mm = 0.0;
  double largest_mm = 0.0;
  double median_deg = 0.0;
  double largest_deg = 0.0;
  bool trustworthy = false;
};

// Runs the steps poses and grid for each spacing in OUT/trade/, densest first, and writes
// OUT/trade.json, which is read instead if it has the same inputs.
std::vector<KeyframeTrial> compare_keyframes(Calibration* calibration,
                                             std::vector<double> spacings_mm);

nlohmann::ordered_json keyframe_json(const std::vector<KeyframeTrial>& trials);

}  // namespace raywalk::calibrate
