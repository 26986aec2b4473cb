#include "calibrate/chain/run_all.h"

#include <fmt/format.h>

#include "calibrate/chain/calibration_numbers.h"
#include "calibrate/chain/calibration_summary.h"
#include "calibrate/rectify/rectify_report.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"

namespace raywalk::calibrate {
namespace {

StepRun run_if_needed(Calibration* calibration, CalibrationStep step, std::ostream& out) {
  throw_if_interrupted();
  const bool reused = calibration->is_done(step);
  if (!reused) calibration->run(step);
  const double seconds = calibration->seconds(step);
  out << fmt::format("{:<8}{:>7.1f} s{}", step_name(step), seconds,
                     reused ? "  (done earlier)" : "")
      << std::endl;
  return {.step = step, .seconds = seconds, .reused = reused};
}

void require_trustworthy(const Calibration& calibration, const CalibrationSummary& summary) {
  if (summary.trustworthy) return;
  const std::string first =
      summary.warnings.empty() ? "its own checks contradict it" : summary.warnings.front();
  throw Error(fmt::format(
      "the result is not trustworthy ({} warnings, the first: {}); outputs are kept in {}, see "
      "index.html and calibration.json there",
      summary.warnings.size(), first, calibration.out().string()));
}

}  // namespace

void run_all(Calibration* calibration, const ChainOptions& options, std::ostream& out) {
  if (options.redo) calibration->forget(*options.redo);
  std::vector<StepRun> steps;
  for (const CalibrationStep step : kCalibrationSteps) {
    if (calibration->has(step)) steps.push_back(run_if_needed(calibration, step, out));
  }
  CalibrationSummary summary = summary_of(*calibration);
  summary.steps = std::move(steps);
  if (!options.compare_keyframes_mm.empty()) {
    summary.trade = compare_keyframes(calibration, options.compare_keyframes_mm);
  }
  write_calibration(*calibration, summary);
  for (const StepRun& run : summary.steps) {
    out << fmt::format("{}: {}\n", step_name(run.step), step_numbers(*calibration, run.step));
  }
  out << fmt::format("{}; see {}\n{}\n", summary.trustworthy ? "trustworthy" : "not trustworthy",
                     escaped((calibration->out() / "index.html").string()),
                     escaped(pack_command(calibration->rectified(), calibration->out())));
  require_trustworthy(*calibration, summary);
}

}  // namespace raywalk::calibrate
