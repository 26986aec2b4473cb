// A picture file on a surface.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "simulator/room/color.h"

namespace raywalk::capture {

class Texture {
 public:
  // Throws Error if the file cannot be read as a picture.
  explicit Texture(const std::filesystem::path& file);

  // The reflectance at `at`, where the picture lies between (0, 0), its lower left corner, and
  // (1, 1), and repeats beyond; averaged over a square of the side `footprint`.
  Color at(const Eigen::Vector2f& at, float footprint) const;

 private:
  std::vector<cv::Mat> levels_;  // CV_32FC3, BGR, linear; each half as wide as the one before
};

}  // namespace raywalk::capture
