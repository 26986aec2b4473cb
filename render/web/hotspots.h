// Points in a room that the page explains: a text and, where given, a link.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace raywalk::render {

struct Hotspot {
  Eigen::Vector3d position_m{0, 0, 0};
  std::string text{};
  std::string link{};  // empty: none
};

// Reads a JSON list of {"x_m", "y_m", "z_m", "text", "link"}; only the link may be missing. Throws
// Error naming file and entry: an unknown or missing key, another type, a position that is not
// finite or farther than 10^6 m, an empty text, a link that is neither http, https nor a relative
// path.
std::vector<Hotspot> read_hotspots(const std::filesystem::path& file);

}  // namespace raywalk::render
