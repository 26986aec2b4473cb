// stitch.html: a sample panorama of a capture and the agreement of the lenses.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/mat.hpp>
#include <string>

namespace raywalk::calibrate {

// One frame stitched with and without correction, CV_8UC3.
struct StitchSample {
  std::string station{};
  cv::Mat panorama{};    // balanced and blended
  cv::Mat unbalanced{};  // neither balanced nor blended
};

// `document`: of stitch.json.
std::string stitch_page(const nlohmann::ordered_json& document, const StitchSample& sample);

}  // namespace raywalk::calibrate
