// Compares the light of the frames of a capture, all at once or in blocks of pairs of frames.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/rectify/exposure_gains.h"
#include "core/base/block.h"

namespace raywalk::calibrate {

// Indices of the frames with a pose, ascending.
std::vector<int> posed_frames(const FramePoses& poses);

class LightComparison {
 public:
  // Of all frames with a pose. `mask` is that of all frames, or empty. All must outlive it.
  LightComparison(const CaptureSet& panoramas, const FramePoses& poses, const cv::Mat& mask);

  // Pairs of frames to compare: neighbours on a line, those nearest to a crossing, and held-out
  // frames with the stations nearest to them.
  std::size_t pairs() const { return links_.size(); }
  // The patches of a range of the pairs; reads the panoramas of their frames. Throws Error for
  // files that cannot be read; Interrupted.
  std::vector<LinkPatches> compare(IndexRange range) const;
  // From the patches of all pairs, in order: the exposures (exposure_gains.h), those of held-out
  // frames relative to the stations', which they have no part in.
  ExposureResult exposures(const std::vector<LinkPatches>& links) const;

 private:
  const CaptureSet& set_;
  const FramePoses& poses_;
  const cv::Mat& mask_;
  std::vector<FrameLink> links_{};  // of stations, then of held-out frames
  std::size_t of_stations_ = 0;
};

// Exact; for files that blocks leave (number_bytes.h).
std::string bytes_of(const std::vector<LinkPatches>& links);
// Throws Error if they are not the patches of pairs of that many frames.
std::vector<LinkPatches> read_link_patches(std::string_view bytes, std::size_t frames);

}  // namespace raywalk::calibrate
