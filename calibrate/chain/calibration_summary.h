// The summary of a calibration: calibration.json and index.html.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "calibrate/chain/calibration.h"
#include "calibrate/chain/keyframe_trade.h"

namespace raywalk::calibrate {

// A step of the current run.
struct StepRun {
  CalibrationStep step = CalibrationStep::kLens;
  double seconds = 0.0;  // duration of its last run
  bool reused = false;   // done by an earlier run with the same inputs
};

struct CalibrationSummary {
  bool trustworthy = false;
  std::vector<std::string> warnings{};  // of all steps, each prefixed with the step's name
  std::vector<std::string> notes{};
  std::vector<StepRun> steps{};
  std::vector<KeyframeTrial> trade{};
};

// The warnings of the step's last run, read from its JSON in OUT.
std::vector<std::string> step_warnings(const Calibration& calibration, CalibrationStep step);

// Collects the warnings from the steps' results in OUT. A calibration is trustworthy if its grid is
// and the fit of its lenses has no warnings.
CalibrationSummary summary_of(const Calibration& calibration);

// The document of OUT/calibration.json; docs/file-formats.md has its keys.
nlohmann::ordered_json calibration_document(const Calibration& calibration,
                                            const CalibrationSummary& summary);

// Writes OUT/calibration.json and from it OUT/index.html. Throws Error if a file cannot be written.
void write_calibration(const Calibration& calibration, const CalibrationSummary& summary);

}  // namespace raywalk::calibrate
