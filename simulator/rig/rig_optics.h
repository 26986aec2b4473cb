// Image formation of the simulated rig's camera: lenses, vignetting, dolly and sensor.
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/geometry/fisheye_lens.h"
#include "simulator/rig/rig_config.h"
#include "simulator/rig/simulated_camera.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::simulator {

class RigOptics {
 public:
  // The camera is `floor_m` above the floor. Precomputes what is the same in every picture. Throws
  // UsageError if the lens file cannot be read (see read_lens_file), is of a camera with two files
  // per shot, or has another aspect ratio than `frame`.
  RigOptics(const RigCameraSettings& camera, PanoramaSize frame, const DollySettings& dolly,
            double floor_m, int seed);

  // The lenses of dual-fisheye frames, in pixels of the frame; empty for panoramas.
  const std::optional<DualFisheyeLayout>& lenses() const { return lenses_; }

  // What the lenses show of room and dolly: BGR, CV_8UC3. Throws as VirtualRoom does.
  cv::Mat scene(const VirtualRoom& room, const CameraPose& pose) const;
  // The picture taken of a scene, likewise. Deterministic: the noise is keyed by the exposure's
  // number.
  cv::Mat picture(const cv::Mat& scene, const ExposureNow& exposure) const;

 private:
  RigCameraSettings camera_;
  int seed_;
  std::optional<DualFisheyeLayout> lenses_;
  cv::Mat light_;  // relative illumination of each pixel; empty: 1 everywhere
  std::unique_ptr<const PixelRays> rays_;
  Facets dolly_;  // empty: not visible
};

// A plate under the camera, a pole, a square platform on four wheels on the floor, and a short
// piece of rail, in the camera's frame (RenderOptions::carried). The floor is `floor_m` below the
// camera; all sizes are proportional to it. Throws Error unless it is positive.
Facets make_dolly(const DollySettings& dolly, double floor_m);

// Slow drift of the light at a picture, between -1 and 1, with a period of dozens of pictures, as
// daylight changes during a session. Determined by the seed.
double exposure_drift(std::uint64_t picture, int seed);

}  // namespace raywalk::simulator
