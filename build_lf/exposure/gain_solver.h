// The local gains of a room's stations that best fit the ratios measured between their patches.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "build_lf/exposure/patch_ratios.h"
#include "build_lf/exposure/station_ratios.h"

namespace raywalk::build_lf {

// Which ratios to solve for: all, or those from the black or the white fields of a chessboard of
// patches. Two halves tell how well the gains are determined.
enum class Part { kAll, kBlack, kWhite };

// The log gains of one channel of `stations` stations, a column each of kPatches rows. Levels times
// gains agree, so that g_from - g_to is a log ratio. Minimises
//   sum over the ratios  h((g_from - g_to - log ratio) / error)
// + sum over neighbouring patches of a station  h((g - g') / 0.03)  + sum (g / 0.1)^2,
// h(r) = r^2 up to Huber's k = 1.345 and 2 k |r| - k^2 beyond, which bounds the influence of
// outliers and lets the gain jump where one lens ends and the next begins. The last term keeps the
// gains near 1 where nothing is measured; its weight is that of differences of 10 % being common.
// Patches that narrow towards the poles differ less. A `guess`, in the form of the result, saves
// time.
Eigen::MatrixXd solve_patch_gains(std::span<const PatchRatio> ratios, Part part, size_t channel,
                                  int stations, const Eigen::MatrixXd& guess = {});

// A window of a large room, whose gains are solved for by themselves: stations by their index in
// the list, increasing.
struct GainWindow {
  std::vector<int> stations;
  // [place in `stations`]: whether the gains are kept. Those of the others, around the window, are
  // only solved for because those within depend on them.
  std::vector<bool> kept;
};

// Halves the room across its longer side until no window keeps more than `most` stations; each
// station is kept by one window. A window also has the stations that its own are compared with, and
// those that these are. One window if there are at most `most` stations.
std::vector<GainWindow> gain_windows(std::span<const Eigen::Vector3d> positions_m,
                                     std::span<const WholeRatio> pairs, int most);

}  // namespace raywalk::build_lf
