// Factors that bring the colours of a station to those of the others.
#pragma once

#include <opencv2/core/mat.hpp>

namespace raywalk {

// Factors of 8-bit levels: red, green, blue.
using ColourGain = cv::Vec3f;

// Gains over a station's sphere of directions. A station's lenses differ in exposure, and clouds
// pass over a part of the sky: one factor for the whole picture is not enough.
struct GainField {
  ColourGain whole{1.0F, 1.0F, 1.0F};
  // Further factors, CV_32FC3 [theta][phi], at the middles of equal patches of the panorama and
  // linear in between. Empty: 1 everywhere.
  cv::Mat local{};
};

// Multiplies a transposed panorama (row = theta, column = phi), CV_8UC3, by its gains.
void apply_gains(const GainField& gains, cv::Mat* colours);

}  // namespace raywalk
