// nerfstudio's transforms.json of equirectangular pictures.
//
// docs.nerf.studio/quickstart/data_conventions.html: a frame's transform_matrix takes points from
// its camera to the world. The camera has x right, y up and looks along -z; the world is
// right-handed with z up. nerfstudio/cameras/cameras.py (generate_rays,
// CameraType.EQUIRECTANGULAR): the middle of the picture looks along -z and what is right of it to
// +x, with fl_x = fl_y = h = w / 2 and the principal point in the middle.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/reconstruction/colmap_pose.h"

namespace raywalk {

struct NerfstudioFrame {
  std::string file{};  // of the picture, relative to transforms.json, with '/'
  std::string mask{};  // likewise; empty: none
  CameraPose pose{};
};

// The file's text. `points` is a PLY of points in the same world; empty: none.
std::string nerfstudio_text(const std::vector<NerfstudioFrame>& frames, PanoramaSize size,
                            const std::string& points);

// Reads the poses of such a file, in Raywalk's axes with y up. Throws Error naming file and place:
// not JSON, no frames, another camera model than EQUIRECTANGULAR, a transform_matrix that does not
// rotate and move only (mirrored or scaled, of another convention).
std::vector<NerfstudioFrame> read_nerfstudio(const std::filesystem::path& file);
std::vector<NerfstudioFrame> nerfstudio_of_text(const std::string& text, const std::string& source);

}  // namespace raywalk
