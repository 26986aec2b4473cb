// Ground truth of a room: panoramas captured between the lines.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/room/room.h"

namespace raywalk {

// A true view as listed.
struct ListedTruth {
  std::string name{};            // the file's stem
  std::filesystem::path file{};  // of the picture
  PlanPoint viewpoint{};
  // y, where it is off the height of the lines. Initial views are rendered at that of the lines.
  std::optional<double> height_m{};
  Eigen::Matrix3d world_from_camera = Eigen::Matrix3d::Identity();  // of picture, mask, distances
  int width = 0;                                                    // of the picture, pixels
  std::filesystem::path mask{};       // picture, 0 = not compared; empty: all pixels count
  std::filesystem::path distances{};  // true distance map; empty: not known
  // Plan distance to the nearest line that serves the view; vertical parallax grows with it.
  double line_distance_m = 0.0;
};

// A viewpoint and its true image: captured between the lines, or a station that was held out
// (held_out_views.h).
struct TrueView {
  std::string name{};
  PlanPoint viewpoint{};
  std::optional<double> height_m{};  // as ListedTruth has it
  cv::Mat image{};                   // CV_8UC3 in BGR order, width = 2 * height
  cv::Mat mask{};                    // CV_8UC1 of the same size, 0 = not compared; empty: all is
  cv::Mat distances{};               // CV_16UC1 in millimetres; empty: not known
};

// Reads columns file,x,y,z (metres; files relative to the list) and, where given, yaw,pitch,roll
// (degrees, of a picture that is not in world axes, as of its mask and distances), mask (an 8-bit
// grey picture of the same size, 0 = not compared, for example a dolly in view; may be empty) and
// distance (a true distance map of the same size; may be empty), and checks every picture's header.
// A truth at another height than the lines causes a warning, since initial views are at theirs.
// Throws Error with file and line: no views, a missing or unsuitable picture (not 2:1, width not a
// multiple of 4 or under 32), mask (of another size, all 0) or distance map (of another size), two
// views of one stem, a viewpoint the room cannot be rendered from.
std::vector<ListedTruth> read_truth(const std::filesystem::path& list, const Room& room);

// Reads its files, rotated to world axes. Throws Error as above.
TrueView read_view(const ListedTruth& truth);

// Indices of at most `most` truths, nearest first, spread over the distance from the line, with the
// nearest and the farthest among them.
std::vector<std::size_t> spread_over_distance(std::span<const ListedTruth> truths,
                                              std::size_t most);

}  // namespace raywalk
