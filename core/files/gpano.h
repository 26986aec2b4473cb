// What a panorama states of itself in XMP "GPano" (Photo Sphere XMP Metadata,
// https://developers.google.com/streetview/spherical-metadata).
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace raywalk {

// Of the camera, as its sensors have it.
struct StatedAttitude {
  double pitch_deg = 0.0;
  double roll_deg = 0.0;
};
// PosePitchDegrees and PoseRollDegrees of an image file, or of as much of its beginning as holds
// them; empty if it states neither.
std::optional<StatedAttitude> stated_attitude(std::span<const std::byte> file);

// Whether its cropped area is smaller than its full panorama.
bool is_stated_as_cropped(std::span<const std::byte> file);

}  // namespace raywalk
