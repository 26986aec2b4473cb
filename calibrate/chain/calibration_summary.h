// What a calibration came to: calibration.json for programs, index.html for people.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calibrate/chain/calibration.h"
#include "calibrate/chain/keyframe_trade.h"

namespace raywalk::calibrate {

// A step as it was gone through.
struct StepTaken {
  CalibrationStep step = CalibrationStep::kLens;
  double seconds = 0.0;  // when it was last done
  bool reused = false;   // done earlier, of the same inputs
};

struct CalibrationSummary {
  bool trustworthy = false;
  std::vector<std::string> warnings{};  // of all steps, each with the step it is from
  std::vector<std::string> notes{};
  std::vector<StepTaken> steps{};
  std::vector<KeyframeTrial> trade{};
};

// What the step warned of when it was last done, as its JSON in OUT has it.
std::vector<std::string> step_warnings(const Calibration& calibration, CalibrationStep step);

// Gathers the warnings from what the steps left in OUT. A calibration is trustworthy where its grid
// is, and nothing was wrong with its lenses.
CalibrationSummary summary_of(const Calibration& calibration);

// Writes OUT/calibration.json:
//   {"format_version": 1, "source", "method": "poses" | "rotation", "trustworthy", "warnings",
//    "notes", "lens": null | {"picture_width_px", "picture_height_px", "two_files", "front",
//    "back"}, "scale", "lines" and "crossings" as in grid.json, "frames" as in poses.json,
//    "e_connect" as in rectify.json, "line_tolerance_mm", "keyframe_trade", "steps": [{"step",
//    "seconds", "reused"}]}
void write_calibration_json(const Calibration& calibration, const CalibrationSummary& summary);

// Writes OUT/index.html.
void write_calibration_page(const Calibration& calibration, const CalibrationSummary& summary);

}  // namespace raywalk::calibrate
