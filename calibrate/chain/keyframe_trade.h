// What fewer keyframes cost in accuracy and save in time: the poses solved again with several
// spacings.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "calibrate/chain/calibration.h"
#include "core/report/html_page.h"

namespace raywalk::calibrate {

// One spacing; differences are against the densest, over all stations, once the common mean
// displacement is taken off (which no picture tells).
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

// Densest first; runs the steps poses and grid for each in OUT/trade/ and keeps OUT/trade.json,
// which is read instead where it is of the same inputs.
std::vector<KeyframeTrial> compare_keyframes(Calibration* calibration,
                                             std::vector<double> spacings_mm);

HtmlTable keyframe_table(const std::vector<KeyframeTrial>& trials);
nlohmann::ordered_json keyframe_json(const std::vector<KeyframeTrial>& trials);

}  // namespace raywalk::calibrate
