// Completion of distance maps: where a pixel does not decide, its surroundings of like colour do.
#pragma once

#include <opencv2/core/mat.hpp>

#include "build_lf/depth/inverse_distance_map.h"

namespace raywalk::build_lf {

// Gives pixels whose confidence is below kMinConfidence a value from confident pixels around them,
// of like colour, that lie on one surface; others, and pixels without such surroundings, stay as
// they are. `colours` is the station's panorama, transposed (row = theta, column = phi), CV_8UC3,
// of the map's size; `valid` is empty or 0 where the colours are not the scene's: such pixels stay
// as they are and tell nothing about others. A difference of `tolerance_per_m`, 1/m, still counts
// as the same surface.
//
// On a plane n . X = d a ray of unit direction u meets X = u / omega, so omega = n . u / d: linear
// in the direction. A plane is fitted to the surroundings by iteratively reweighted least squares
// (Huber, Robust Statistics, 1981; weights of Geman and McClure), beginning with their median. If
// the surroundings lie all around, and enough of them are confident and agree, the new confidence
// is at least kMinConfidence and at most half of 255; it grows with their number and the share that
// agrees. If they are few, or lie on one side, as at the outline of a thing, the plane is a guess:
// the confidence stays as low as it was.
void complete_map(const cv::Mat& colours, const cv::Mat& valid, double tolerance_per_m,
                  InverseDistanceMap* map);

}  // namespace raywalk::build_lf
