#include "calibrate/rectify/exposure_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace raywalk::calibrate {
namespace {

using nlohmann::ordered_json;

bool is_corrected(const LightGain& gain) { return gain != LightGain{1.0, 1.0, 1.0}; }

std::size_t corrected_frames(const ExposureResult& exposure) {
  return static_cast<std::size_t>(
      std::count_if(exposure.gains.begin(), exposure.gains.end(), is_corrected));
}

std::size_t measured_frames(const ExposureResult& exposure) {
  return static_cast<std::size_t>(
      std::count(exposure.measured.begin(), exposure.measured.end(), true));
}

const char* model_text(ExposureModel model) {
  switch (model) {
    case ExposureModel::kEqual:
      return "all frames alike";
    case ExposureModel::kLines:
      return "one value per line";
    case ExposureModel::kDrift:
      return "steady drift along each line";
    case ExposureModel::kStations:
      return "one value per frame";
  }
  return "";
}

const std::string& name_of(const CaptureSet& set, int frame) {
  return set.frames[static_cast<std::size_t>(frame)].name;
}

}  // namespace

double mean_stops(const LightGain& gain) {
  return (std::log2(gain[0]) + std::log2(gain[1]) + std::log2(gain[2])) / 3.0;
}

std::string exposure_summary(const ExposureResult& exposure) {
  const std::size_t measured = measured_frames(exposure);
  if (measured == 0)
    return "no two frames show enough in common to compare exposures; none is corrected";
  const bool testable = !exposure.light[0].decision.tests.empty();
  if (!testable)
    return "too little of the scene is comparable to judge exposures; none is corrected";
  const std::size_t corrected = corrected_frames(exposure);
  if (corrected == 0) {
    return "no difference of exposure or colour exceeds its uncertainty; none is corrected";
  }
  double largest = 0.0;
  for (const LightGain& gain : exposure.gains) {
    largest = std::max(largest, std::abs(mean_stops(gain)));
  }
  return fmt::format(
      "exposures or colours differ; {} of {} frames are corrected, by at most {:.3f} stops",
      corrected, measured, largest);
}

ordered_json exposure_json(const CaptureSet& set, const ExposureResult& exposure) {
  ordered_json kinds = ordered_json::array();
  for (int kind = 0; kind < kLightKinds; ++kind) {
    const MeasuredLight& light = exposure.light[static_cast<std::size_t>(kind)];
    ordered_json tests = ordered_json::array(), halves = ordered_json::array();
    for (const ModelTest& test : light.decision.tests) {
      tests.push_back({{"model", exposure_model_name(test.model)},
                       {"model_text", model_text(test.model)},
                       {"largest_t", test.largest_t},
                       {"frame", name_of(set, test.picture)},
                       {"rejected", test.rejected}});
    }
    for (const HalvesComparison& split : light.halves) {
      halves.push_back({{"split", split.split},
                        {"difference", split.difference},
                        {"by_chance", split.by_chance}});
    }
    kinds.push_back({{"kind", light_kind_name(kind)},
                     {"model", exposure_model_name(light.decision.model)},
                     {"model_text", model_text(light.decision.model)},
                     {"spread", light.spread},
                     {"t_limit", light.decision.t_limit},
                     {"t_limit_single", light.decision.t_limit_single},
                     {"tests", tests},
                     {"halves", halves}});
  }
  return {{"summary", exposure_summary(exposure)},
          {"corrected_frames", corrected_frames(exposure)},
          {"measured_frames", measured_frames(exposure)},
          {"links", exposure.links},
          {"patches", exposure.patches},
          {"scene_parts", exposure.scene_parts},
          {"scene_parts_in_all", kSceneParts},
          {"loops", exposure.loops},
          {"loop_error", exposure.loop_error},
          {"significance", kSignificance},
          {"kinds", kinds}};
}

ordered_json frame_exposure_json(const ExposureResult& exposure, int frame) {
  const bool measured = exposure.measured[static_cast<std::size_t>(frame)];
  const auto if_measured = [measured](double value) {
    return measured ? ordered_json(value) : ordered_json(nullptr);
  };
  ordered_json kinds;
  for (int kind = 0; kind < kLightKinds; ++kind) {
    const ExposureDecision& decision = exposure.light[static_cast<std::size_t>(kind)].decision;
    kinds[light_kind_name(kind)] = {
        {"measured", if_measured(decision.measured[frame])},
        {"fitted", if_measured(decision.fitted[frame])},
        {"measured_change", if_measured(std::expm1(decision.measured[frame]))},
        {"fitted_change", if_measured(std::expm1(decision.fitted[frame]))},
        {"error", if_measured(decision.error[frame])},
        {"corrected", decision.correction[frame] != 0.0}};
  }
  return kinds;
}

}  // namespace raywalk::calibrate
