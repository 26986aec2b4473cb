// The poses of the images of a COLMAP model, of any camera and any version of COLMAP.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/reconstruction/colmap_pose.h"

namespace raywalk {

struct ColmapImagePose {
  std::string name{};  // relative to COLMAP's folder of images, with '/'
  ColmapPose pose{};
};

// From images.bin, or images.txt where there is none. Throws Error naming the file, and the line of
// a text, if there is none of the two, it is damaged, has no image, or one twice.
std::vector<ColmapImagePose> read_colmap_images(const std::filesystem::path& directory);

// The same of the contents of images.bin and images.txt; `source` names them in errors.
std::vector<ColmapImagePose> colmap_images_of_bytes(std::string bytes, const std::string& source);
std::vector<ColmapImagePose> colmap_images_of_text(const std::string& text,
                                                   const std::string& source);

// Whether the first camera of a model is EQUIRECTANGULAR, which COLMAP 4.1 and newer have: its
// images are then panoramas, with the axes of a face that looks ahead. Throws Error naming
// cameras.bin if it is damaged.
bool images_are_panoramas(const std::filesystem::path& directory);

}  // namespace raywalk
