// Keeps of measured gains what is beyond their errors.
//
// Gains are measured with errors of their own: surfaces are not quite matt, distances not quite
// right. Applied to pictures that agree already, they would only do harm, so what may be error
// stays 1 exactly.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "build_lf/exposure/patch_ratios.h"

namespace raywalk::build_lf {

// The log gains of one station's patches (patch_ratios.h), a column for each channel.
using PatchGains = Eigen::Matrix<double, kPatches, 3>;

// What is applied of a station's gains.
struct KeptGains {
  Eigen::RowVector3d whole{0, 0, 0};    // log gains of the whole picture
  std::optional<PatchGains> patches{};  // beyond `whole`; none: patches do not differ from it
};

// `gains` were solved from all ratios, `halves` each from one half of them, whose differences show
// how well the gains are determined. The whole picture's gain and that of its patches are judged
// apart: each is dropped below twice its error, applied whole from four times its error on, and in
// proportion between. `measured` tells the patches that have ratios; others are not judged.
KeptGains keep_significant(const PatchGains& gains, const std::array<PatchGains, 2>& halves,
                           std::span<const bool> measured);

// The log gains of one station's patches in one channel (patch_ratios.h) without spots: a patch
// that differs by more than 10 % from the median of the patches around it, 5 x 5 at the horizon
// and nearly as wide elsewhere, takes that median. What one station shows and the others do not is
// no larger than that, unless it is very near; the picture of a lens and the shadow of a cloud are,
// and a median keeps their edges.
Eigen::VectorXd without_spots(const Eigen::VectorXd& patches);

}  // namespace raywalk::build_lf
