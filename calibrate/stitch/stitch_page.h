// stitch.html: a sample panorama of a capture and the agreement of the lenses.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "calibrate/stitch/stitch_record.h"

namespace raywalk::calibrate {

// One frame stitched with and without correction, CV_8UC3.
struct StitchSample {
  std::string station{};
  cv::Mat panorama{};    // balanced and blended
  cv::Mat unbalanced{};  // neither balanced nor blended
};

std::string stitch_page(const StitchRecord& record, const StitchSample& sample);

}  // namespace raywalk::calibrate
