// The faces of panoramas that COLMAP finds features in.
//
// Four horizontal faces of 90 degrees look to 45, 135, -135 and -45 degrees, so that they meet at
// the camera's front, sides and back. Every face lies in one half of the panorama: if it was
// stitched from a front and a back lens, each face was seen by one of them, and the seams run along
// edges of faces.
#pragma once

#include <array>
#include <optional>

#include "core/geometry/fisheye_lens.h"
#include "core/reconstruction/panorama_faces.h"

namespace raywalk::calibrate {

inline constexpr int kFaceCount = 4;

// The centre of a face is that of its lens; without lenses it is the origin.
std::array<PanoramaFace, kFaceCount> panorama_faces(const std::optional<DualFisheyeLayout>& lenses);

// The default side of a face, pixels: 1.5 times the panorama's resolution in the middle of the face
// (COLMAP finds more features then), clamped to [384, 768]: smaller faces have too few features,
// larger ones cost time and gain little.
int default_face_px(int panorama_width);

}  // namespace raywalk::calibrate
