// The releases of COLMAP that raywalk-calibrate works with, and what differs between them.
#pragma once

#include <optional>
#include <string_view>

namespace raywalk::calibrate {

struct ColmapRelease {
  std::string_view number;            // "3.8"
  std::string_view max_error_option;  // of matches_importer: inliers of a pair, pixels
};

// Which of them a version as COLMAP prints it is of: "3.8.1" is of 3.8. None for any other.
std::optional<ColmapRelease> colmap_release_of(std::string_view version);

}  // namespace raywalk::calibrate
