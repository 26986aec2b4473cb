// What a picture says of itself to other programs.
#pragma once

#include <opencv2/core/types.hpp>
#include <string>

#include "render/view/view_frame.h"

namespace raywalk::render {

// Where and how a view was rendered.
struct ViewDescription {
  double x_m = 0.0;  // the viewpoint, in the room's frame
  double y_m = 0.0;
  double z_m = 0.0;
  ViewFrame frame{};  // what it shows: a panorama, or a flat picture of fov_deg
};

// The file `picture`, a JPEG, PNG, WebP or TIFF as OpenCV encodes it, with metadata added; its
// pixels stay as they are.
// - Panoramas: Photo Sphere metadata (XMP "GPano", https://developers.google.com/streetview/
//   spherical-metadata), the whole sphere in `size`. North of PoseHeadingDegrees is the room's +z,
//   the heading grows towards +x; PosePitchDegrees and PoseRollDegrees are the attitude's.
// - Flat pictures: EXIF's FocalLength on a sensor 36 mm wide, which FocalPlaneXResolution says too,
//   and FocalLengthIn35mmFilm.
// - Panoramas for two eyes: Stereo ("top-bottom") and EyesApart_mm of kRaywalkNamespace; GPano
// knows
//   one panorama per picture, and viewers would show both as one.
// - All: position and attitude as X_m, Y_m, Z_m, YawDeg, PitchDeg and RollDeg of the XMP namespace
//   kRaywalkNamespace, as GPano has no place for a position.
std::string with_metadata(const std::string& picture, cv::Size size, const ViewDescription& view);

inline constexpr const char* kRaywalkNamespace = "urn:raywalk:view:1#";

}  // namespace raywalk::render
