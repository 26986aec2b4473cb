// The connection error of the lines, E_connect of the paper's equation (11), before and after the
// calibration: measured by running raywalk-build-lf and raywalk-render on a small light field of
// each.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/rectify/frame_tables.h"

namespace raywalk::calibrate {

// Squared 8-bit levels of initial views; NaN if no column could be compared.
struct ConnectionAtK {
  double k_deg = 0.0;
  double before = 0.0;
  double after = 0.0;
};

struct ConnectionBeforeAfter {
  std::vector<ConnectionAtK> rows{};  // empty: not measured
  int width_px = 0;                   // of the panoramas it was measured on
  std::string note{};                 // why it was not measured
};

// A frame list for raywalk-build-lf, with absolute paths.
struct ConnectionInput {
  std::vector<ListedFrame> frames{};
  int lines = 0;
  GridTolerance tolerance{};  // how the lines of the capture were found
};

// `programs` is the directory of the two programs; nullopt: that of the running executable. Works
// in the directory `work`, which is removed afterwards. Pictures wider than 1024 pixels are reduced
// to that width. If it cannot be measured (a program is missing or fails, there is no cell), the
// note gives the reason; throws Interrupted.
ConnectionBeforeAfter measure_connection(const ConnectionInput& before,
                                         const ConnectionInput& after,
                                         const std::optional<std::filesystem::path>& programs,
                                         const std::filesystem::path& work);

}  // namespace raywalk::calibrate
