#include "calibrate/chain/run_all.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "calibrate/chain/calibration_report.h"
#include "calibrate/chain/keyframe_trade.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"

namespace raywalk::calibrate {
namespace {

using nlohmann::ordered_json;

StepRun run_if_needed(Calibration* calibration, CalibrationStep step, std::ostream& out) {
  throw_if_interrupted();
  const bool reused = calibration->is_done(step);
  if (!reused) run_reported(calibration, step);
  const double seconds = calibration->seconds(step);
  out << fmt::format("{:<8}{:>7.1f} s{}", step_name(step), seconds,
                     reused ? "  (done earlier)" : "")
      << std::endl;
  return {.step = step, .seconds = seconds, .reused = reused};
}

void require_trustworthy(const Calibration& calibration, const ordered_json& document) {
  if (document.at("trustworthy").get<bool>()) return;
  const ordered_json& warnings = document.at("warnings");
  const std::string first =
      warnings.empty() ? "its own checks contradict it" : warnings.front().get<std::string>();
  throw Error(fmt::format(
      "the result is not trustworthy ({} warnings, the first: {}); outputs are kept in {}, see "
      "index.html and calibration.json there",
      warnings.size(), first, calibration.out().string()));
}

}  // namespace

void run_all(Calibration* calibration, const ChainOptions& options, std::ostream& out) {
  if (options.redo) calibration->forget(*options.redo);
  std::vector<StepRun> steps;
  for (const CalibrationStep step : kCalibrationSteps) {
    if (calibration->has(step)) steps.push_back(run_if_needed(calibration, step, out));
  }
  ordered_json trade = ordered_json::array();
  if (!options.compare_keyframes_mm.empty()) {
    trade = compare_keyframes(calibration, options.compare_keyframes_mm);
  }
  const ordered_json document = write_calibration(*calibration, steps, trade);
  for (const StepRun& run : steps) {
    const std::string name = step_name(run.step);
    const ordered_json of_step = document.value(name, ordered_json());
    out << fmt::format("{}: {}\n", name, step_numbers(run.step, of_step));
  }
  const bool trustworthy = document.at("trustworthy").get<bool>();
  const auto next = document.at("rectify").at("pack_command").get<std::string>();
  out << fmt::format("{}; see {}\n{}\n", trustworthy ? "trustworthy" : "not trustworthy",
                     escaped((calibration->out() / "index.html").string()), escaped(next));
  require_trustworthy(*calibration, document);
}

}  // namespace raywalk::calibrate
