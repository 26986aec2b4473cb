// stitch.html: what the panoramas of a capture look like and how well their halves agree.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "calibrate/stitch/stitch_record.h"

namespace raywalk::calibrate {

// One frame, stitched in two ways, CV_8UC3.
struct StitchSample {
  std::string station{};
  cv::Mat panorama{};    // as it is
  cv::Mat unbalanced{};  // neither balanced nor blended
};

std::string stitch_page(const StitchRecord& record, const StitchSample& sample);

}  // namespace raywalk::calibrate
