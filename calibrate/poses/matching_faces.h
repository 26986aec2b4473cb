// The faces of panoramas that COLMAP finds features in.
//
// Four horizontal faces of 90 degrees look to 45, 135, -135 and -45 degrees, so that they meet at
// the camera's front, sides and back. Every face lies in one half of the panorama: if it was
// stitched from a front and a back lens, each face was seen by one of them, and the seams run along
// edges of faces.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/geometry/fisheye_lens.h"
#include "core/reconstruction/panorama_faces.h"

namespace raywalk::calibrate {

inline constexpr std::size_t kFaceCount = 4;

// The centre of a face is that of its lens; without lenses it is the origin.
using MatchingFaces = std::array<PanoramaFace, kFaceCount>;
MatchingFaces panorama_faces(const std::optional<DualFisheyeLayout>& lenses);

// The default side of a face, pixels: 1.5 times the panorama's resolution in the middle of the face
// (COLMAP finds more features then), clamped to [384, 768]: smaller faces have too few features,
// larger ones cost time and gain little.
int default_face_px(int panorama_width);

// Overlapping faces of two panoramas, indices.
using FacePair = std::pair<std::size_t, std::size_t>;

// For every face of the first camera, the face of the second with the closest viewing direction; if
// the cameras are rotated by more than 20 degrees relative to each other, all faces within 60
// degrees.
std::vector<FacePair> overlapping_faces(const MatchingFaces& faces,
                                        const Eigen::Matrix3d& world_from_first,
                                        const Eigen::Matrix3d& world_from_second);

}  // namespace raywalk::calibrate
