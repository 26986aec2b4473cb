// Poses of panoramas from those of flat faces that were cut out of them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calibrate/import/imported_poses.h"
#include "core/reconstruction/colmap_model.h"

namespace raywalk::calibrate {

// Images in this folder show this face of the panorama that has the rest of their name:
// "front/hall/007.jpg" is the front of hall/007.
struct NamedFace {
  std::string folder{};
  Eigen::Matrix3d camera_from_face = Eigen::Matrix3d::Identity();
};

// The faces of raywalk-build-lf export.
std::vector<NamedFace> exported_faces();

// Reads a table folder,yaw,pitch,roll (degrees: of the face in the panorama, as in poses.csv; roll
// may be missing). Throws Error naming table and line.
std::vector<NamedFace> read_face_table(const std::filesystem::path& table);

// One frame for each panorama that an image shows a face of: the mean of what its images say.
// Throws Error naming `model` and the image for one in no face's folder, or faces of a panorama
// that disagree by more than 5 degrees or, in position, more than half of the panoramas' spacing:
// then the table is not theirs.
std::vector<ImportedFrame> panoramas_of_faces(const std::vector<ColmapImage>& images,
                                              const std::vector<NamedFace>& faces,
                                              const std::filesystem::path& model);

}  // namespace raywalk::calibrate
