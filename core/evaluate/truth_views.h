// Ground truth of a room: panoramas captured between the lines, and scores of views against them as
// rows of the reports' JSON.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/evaluate/fsim.h"
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
  std::filesystem::path mask_file{};       // picture, 0 = not compared; empty: all pixels count
  std::filesystem::path distances_file{};  // true distance map; empty: not known
  // Plan distance to the nearest line that serves the view; vertical parallax grows with it.
  double line_distance_m = 0.0;
  bool own_exposure = false;  // not that of the room: views take it before they are compared
};

// With its pictures: captured between the lines, or by a station that was held out, which has no
// files (held_out.h).
struct TrueView : ListedTruth {
  cv::Mat image{};      // CV_8UC3 in BGR order, width = 2 * height
  cv::Mat mask{};       // CV_8UC1 of the same size, 0 = not compared; empty: all is
  cv::Mat distances{};  // CV_16UC1 in millimetres; empty: not known
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

// What FSIM compares, once for all scores of a view. Throws Error as they do.
FeatureSimilarity features_of(const cv::Mat& view, const TrueView& truth);

// {"psnr_db": over RGB, "ws_psnr_db": the same weighted by solid angle, "ssim", "fsim": on luma};
// PSNRs are at most kMaxPsnrDb. Masked pixels are ignored: the PSNRs skip them; for SSIM and FSIM,
// which compare neighbourhoods, the truth there is replaced by the view. Throws Error as the
// metrics do (sizes differ, not CV_8UC3, nothing but masked pixels).
nlohmann::ordered_json scores_of(const cv::Mat& view, const TrueView& truth,
                                 const FeatureSimilarity& features);

// The view, each colour times one factor that makes it as bright as its truth where that has an
// exposure of its own; else the view itself. The factor is the median ratio of the levels of
// unmasked pixels that are neither dark nor clipped in both, so that what is displaced or wrong in
// the view hardly counts.
cv::Mat exposed_as(const TrueView& truth, const cv::Mat& view);

// The true image, with the view's own pixels where it is masked.
cv::Mat truth_completed_by(const cv::Mat& view, const TrueView& truth);

// Scores of the quarters of a view that face each of the lines around it: Fig. 13 of the paper
// plots them over the distance from the line. A view between four lines is near one and far from
// another, so its score as a whole does not belong to one distance. The quarter of the panorama
// that faces a side is rendered from that side's line (up to the corners), at one distance straight
// ahead: one view gives up to four points.
//
// A list of {"line_distance_m": from the viewpoint straight ahead to the line, "psnr_db", "ssim",
// "fsim"}, one for every side that a line serves and that is not masked completely. FSIM is
// averaged over the quarter from features of the whole panorama, whose columns wrap around. Images
// are at least 32 pixels wide.
nlohmann::ordered_json quarter_scores_of(const Grid& grid, const cv::Mat& view,
                                         const TrueView& truth, const FeatureSimilarity& features);

// The 90 degrees around longitude `theta_rad` of a panorama: a quarter of its columns, rounded
// down.
cv::Mat quarter_of(const cv::Mat& panorama, double theta_rad);

// Mean of a key over the rows where it is known; null where it is in none.
nlohmann::ordered_json mean_of(std::span<const nlohmann::ordered_json> rows,
                               const std::string& key);

}  // namespace raywalk
