// The masks of single frames, which a frame list names in its column mask. A mask is CV_8UC1 of the
// frame's size, in the camera's axes: 0 masked, 255 valid. A frame without one that has an alpha
// channel is its own mask.
#pragma once

#include <opencv2/core/mat.hpp>

#include "calibrate/base/capture_set.h"

namespace raywalk::calibrate {

// Reads every mask once. Throws Error naming row and file of a mask that is missing, damaged, not
// 8-bit grey, not of the frames' size, or that leaves no pixel; warns where some frames have masks
// and others have none.
void require_usable_masks(const CaptureSet& set);

bool any_masks(const CaptureSet& set);

// The frame's own mask, 0 or 255; empty if it has none. `size` is that of its picture. Throws as
// require_usable_masks.
cv::Mat own_mask(const CaptureFrame& frame, PanoramaSize size);

// The frame's own mask joined with one common to all frames (may be empty); empty if there is
// neither. Throws Error naming the frame if the two together leave no pixel.
cv::Mat joint_mask(const CaptureSet& set, int frame, const cv::Mat& common);

struct MaskFigures {
  int frames = 0;      // with a mask of their own
  double share = 0.0;  // masked of these frames by joint_mask, mean
};
// Of a set of panoramas.
MaskFigures mask_figures(const CaptureSet& panoramas, const cv::Mat& common);

}  // namespace raywalk::calibrate
