// What the simulated rig's camera makes of the room: through its lenses, past its own dolly, by its
// sensor.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "capture/simulated/rig/rig_config.h"
#include "capture/simulated/rig/simulated_camera.h"
#include "capture/simulated/virtual_room/dolly.h"
#include "capture/simulated/virtual_room/virtual_room.h"
#include "core/geometry/fisheye_lens.h"

namespace raywalk::capture {

class RigOptics {
 public:
  // The camera is `floor_m` above the floor. Works out once what is the same in every picture.
  // Throws UsageError for a lens file that cannot be read (see read_lens_file), whose camera gives
  // two files, or whose pictures have other proportions than `frame`.
  RigOptics(const RigCameraSettings& camera, PanoramaSize frame, const DollySettings& dolly,
            double floor_m, int seed);

  // Of dual-fisheye frames, in pixels of the frame; none for panoramas.
  const std::optional<DualFisheyeLayout>& lenses() const { return lenses_; }

  // BGR, CV_8UC3. The same pose and exposure give the same picture; the exposure's number chooses
  // the noise. Throws as VirtualRoom does.
  cv::Mat picture(const VirtualRoom& room, const CameraPose& pose,
                  const ExposureNow& exposure) const;

 private:
  RigCameraSettings camera_;
  PanoramaSize frame_;
  int seed_;
  std::optional<DualFisheyeLayout> lenses_;
  cv::Mat light_;  // of each pixel; empty: the same of all
  std::optional<DollyView> dolly_;
};

// How much the light drifts at a picture: a wander between -1 and 1 that takes dozens of pictures
// from one side to the other, as daylight does while a session lasts. Its turns follow from the
// seed.
double exposure_drift(std::uint64_t picture, int seed);

}  // namespace raywalk::capture
