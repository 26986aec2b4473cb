#include "calibrate/lens/lens_report.h"

#include <nlohmann/json.hpp>

#include "calibrate/lens/lens_values.h"

namespace raywalk::calibrate {
namespace {

using nlohmann::ordered_json;

ordered_json values_json(const std::vector<LensValue>& values) {
  ordered_json json = ordered_json::object();
  for (const LensValue& value : values) {
    json[value.key] = {{"start", value.start}, {"fitted", value.fitted}, {"sigma", nullptr}};
    if (value.sigma > 0.0) json[value.key]["sigma"] = value.sigma;
  }
  return json;
}

ordered_json lens_values_json(const std::vector<LensValue>& values, const LensUncertainty& sigma) {
  ordered_json json = values_json(values);
  json["imaging_sigma_px"] = {{"middle", sigma.middle_px}, {"rim", sigma.rim_px}};
  return json;
}

ordered_json rings_json(const std::vector<ResidualRing>& rings) {
  ordered_json json = ordered_json::array();
  for (const ResidualRing& ring : rings) {
    json.push_back({{"lens", ring.back ? "back" : "front"},
                    {"off_axis_deg", degrees_from_radians(ring.off_axis_rad)},
                    {"count", ring.count},
                    {"rms_px", ring.rms_px},
                    {"radial_px", ring.radial_px}});
  }
  return json;
}

}  // namespace

ordered_json lens_document(const LensFit& fit) {
  return {{"format", "raywalk-lens"},
          {"format_version", 1},
          {"method", fit.method},
          {"trustworthy", fit.trustworthy()},
          {"warnings", fit.warnings},
          {"residual_px", fit.residual_px},
          {"worst_imaging_sigma_px", fit.sigma.worst_px()},
          {"pictures", fit.pictures},
          {"points", fit.points},
          {"overlap_points", fit.overlap_points},
          {"observations", fit.observations},
          {"dropped_observations", fit.dropped_observations},
          {"dropped_still", fit.dropped_still},
          {"back_pose_fitted", fit.back_pose_fitted},
          {"picture",
           {{"width_px", fit.camera.picture.width},
            {"height_px", fit.camera.picture.height},
            {"two_files", fit.camera.two_files}}},
          {"front", lens_values_json(front_values(fit), fit.sigma.front)},
          {"back", lens_values_json(back_values(fit), fit.sigma.back)},
          {"baseline_mm", values_json(baseline_values(fit))},
          {"residuals_over_angle", rings_json(residual_rings(fit))}};
}

}  // namespace raywalk::calibrate
