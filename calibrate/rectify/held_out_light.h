// The light of held-out frames, relative to that of the rectified stations.
#pragma once

#include <span>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/rectify/exposure_gains.h"

namespace raywalk::calibrate {

// Every held-out frame with a pose, with the four stations nearest to it.
std::vector<FrameLink> held_out_links(const CaptureSet& set, const FramePoses& poses);

// Adds to `stations`, the result of the stations alone, the held-out frames that follow them, up to
// `frames` in all. A held-out frame is corrected if it differs significantly from the mean of the
// corrected stations; nothing of the stations changes. `links` are those of the stations and
// held_out_links; `lines` and `centre_m` as for measure_exposures.
void add_held_out_light(std::span<const LinkPatches> links, int frames,
                        std::span<const PictureLine> lines, const Eigen::Vector3d& centre_m,
                        ExposureResult* stations);

}  // namespace raywalk::calibrate
