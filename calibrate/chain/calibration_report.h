// The report of a calibration: calibration.json, which holds the JSON of every step, and
// index.html, which shows it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "calibrate/chain/calibration.h"

namespace raywalk::calibrate {

// A step that the report tells of.
struct StepRun {
  CalibrationStep step = CalibrationStep::kLens;
  double seconds = 0.0;  // duration of its last run
  bool reused = false;   // done by an earlier run with the same inputs
};

// The JSON that the step's last run left in OUT; null without one. Throws Error naming a file that
// is damaged.
nlohmann::ordered_json step_document(const Calibration& calibration, CalibrationStep step);

// The figures of a step's document as one line for the terminal:
// "36 of 36 stations posed, residual 0.54 px, positions to 0.19 mm".
std::string step_numbers(CalibrationStep step, const nlohmann::ordered_json& document);

// Writes OUT/calibration.json and OUT/index.html with these steps' documents and images, and
// returns the document; docs/file-formats.md has its keys. A calibration is trustworthy if its
// poses are and the fit of its lenses has no warnings; null without poses. `trade`:
// compare_keyframes, or an empty list. Throws Error if a file cannot be read or written.
nlohmann::ordered_json write_calibration(const Calibration& calibration,
                                         const std::vector<StepRun>& steps,
                                         const nlohmann::ordered_json& trade);

// The same with all steps up to this one: later ones may have other inputs.
void write_calibration_until(const Calibration& calibration, CalibrationStep last);

// Runs the step, and throws as it does. Logs the warnings of its document. Where the poses fail but
// have left their document, writes the report first.
void run_reported(Calibration* calibration, CalibrationStep step);

}  // namespace raywalk::calibrate
