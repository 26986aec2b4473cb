// How well the lines connect, E_connect of the paper's equation (11), before and after the
// calibration: measured by raywalk-build-lf and raywalk-render, run as programs on a small room
// made of either frames.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/rectify/frame_tables.h"

namespace raywalk::calibrate {

// Squared 8-bit levels of initial views; NaN where no column could be compared.
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

// A frame list for raywalk-build-lf; `frames` name their files by absolute paths.
struct ConnectionInput {
  std::vector<ListedFrame> frames{};
  int lines = 0;  // that they lie on
};

// `programs` is the directory that holds the two programs; none: that of the running executable.
// Works in the directory `work`, which is removed afterwards. Pictures wider than 1024 pixels are
// measured at that width. What keeps it from measuring (a program that is missing or fails, no
// cell) is told in the note; throws Interrupted.
ConnectionBeforeAfter measure_connection(const ConnectionInput& before,
                                         const ConnectionInput& after,
                                         const std::optional<std::filesystem::path>& programs,
                                         const std::filesystem::path& work);

}  // namespace raywalk::calibrate
