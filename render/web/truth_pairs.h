// Captured panoramas between the lines, each with the engine's view of the same place, for the
// page's comparison.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "core/view/view_options.h"

namespace raywalk::render {

struct TruthPair {
  Eigen::Vector3d position_m{0, 0, 0};
  std::string picture{};  // the file, relative to the export: "truth/000.jpg"
  std::string engine{};
};

// Writes the panoramas of a frame list (columns file,x,y,z) that lie in a cell, at most 12 spread
// over the list, to `folder`/truth, and the engine's views from the same height (initial ones: that
// of the lines): `options` as of the room's views, as wide as the panoramas captured. Wider truths
// are scaled down. Throws Error as read_frame_list() and read_panorama() do, and if none lies in a
// cell.
std::vector<TruthPair> write_truth_pairs(const Room& room, ViewOptions options,
                                         const std::filesystem::path& list,
                                         const std::filesystem::path& folder);

}  // namespace raywalk::render
