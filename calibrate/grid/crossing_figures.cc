#include "calibrate/grid/crossing_figures.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "calibrate/grid/rail_model.h"
#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

// An angle in pixels of a panorama 4096 wide.
double pixels_at_4096(double angle_rad) { return angle_rad * 4096.0 / kTwoPi; }

// With fewer held-out matches the check is not significant.
constexpr int kFewestHeldOut = 15;
// Limits of the remaining disagreement at a crossing, beyond kSigmas of its uncertainty: half a
// pixel at W = 4096, and a fiftieth of the stations' spacing (0.5 mm of 25 mm).
constexpr double kRotationLimit_px = 0.5;
constexpr double kPositionLimit_spacings = 0.02;
constexpr double kSigmas = 4.5;
// A check whose own sigma exceeds this many limits would pass everything.
constexpr double kCoarsestCheck = 4.0;
// Largest ratio of the matches' scatter about the estimate to that about their own best fit.
constexpr double kMedianRatio = 1.5;
constexpr double kSplitSigmas = 4.0;

std::vector<CrossingMatch> held_out(const CrossingMatches& crossing) {
  std::vector<CrossingMatch> matches;
  std::copy_if(crossing.matches.begin(), crossing.matches.end(), std::back_inserter(matches),
               [](const CrossingMatch& match) { return match.held_out; });
  return matches;
}

std::vector<CrossingMatch> inliers(const std::vector<CrossingMatch>& matches,
                                   const CrossingFit& fit) {
  std::vector<CrossingMatch> kept;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (fit.inlier[i]) kept.push_back(matches[i]);
  }
  return kept;
}

double median_epipolar_rad(const std::vector<CrossingMatch>& matches, const FramePoses& poses,
                           const CrossingFit& fit) {
  if (matches.empty()) return 0.0;
  std::vector<double> errors;
  errors.reserve(matches.size());
  for (const CrossingMatch& match : matches) {
    errors.push_back(epipolar_error_rad(match, poses, fit));
  }
  return median(std::move(errors));
}

double axis_sigma(const PoseCovariance& covariance, int first) {
  return std::sqrt(covariance.diagonal().segment<3>(first).mean());
}

// In the least certain direction.
double worst_sigma(const PoseCovariance& covariance, int first) {
  const Eigen::Matrix3d block = covariance.block<3, 3>(first, first);
  return std::sqrt(std::max(0.0, block.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff()));
}

// The Mahalanobis distance of a difference from zero.
double sigmas_from_zero(const Eigen::Vector3d& difference, const PoseCovariance& covariance,
                        int first) {
  const Eigen::Matrix3d block = covariance.block<3, 3>(first, first);
  return std::sqrt(std::max(0.0, difference.dot(block.ldlt().solve(difference))));
}

struct Measured {
  Disagreement figures{};
  CrossingFit fit{};
  double own_median_px = 0.0;  // of the matches about their own best fit
};

Measured measure(const std::vector<CrossingMatch>& matches, const FramePoses& poses,
                 const GridScale& scale) {
  Measured result;
  result.fit = fit_crossing(matches, poses, fit_scale(scale));
  const std::vector<CrossingMatch> good = inliers(matches, result.fit);
  if (good.empty()) return result;
  CrossingFit as_posed = result.fit;
  as_posed.rotation_rad.setZero();
  as_posed.motion_m.setZero();
  const double angle = result.fit.rotation_rad.norm();
  result.figures = {
      .median_px = pixels_at_4096(median_epipolar_rad(good, poses, as_posed)),
      .position_mm = 1e3 * result.fit.motion_m.norm(),
      .position_sigma_mm = 1e3 * worst_sigma(result.fit.covariance, 0),
      .rotation_deg = degrees_from_radians(angle),
      .rotation_sigma_deg = degrees_from_radians(worst_sigma(result.fit.covariance, 3)),
      .rotation_px = pixels_at_4096(angle)};
  result.own_median_px = pixels_at_4096(median_epipolar_rad(good, poses, result.fit));
  return result;
}

// The change of the relative pose of the two lines' stations nearest to the crossing.
void add_correction(const CrossingMatches& matches, const FramePoses& before,
                    const FramePoses& after, CrossingFigures* figures) {
  const auto x = static_cast<size_t>(matches.frames_x.front());
  const auto z = static_cast<size_t>(matches.frames_z.front());
  const Eigen::Vector3d moved = (after[x]->position_m - after[z]->position_m) -
                                (before[x]->position_m - before[z]->position_m);
  const auto relative = [&](const FramePoses& poses) -> Eigen::Matrix3d {
    return poses[z]->world_from_camera.transpose() * poses[x]->world_from_camera;
  };
  const double angle = angle_between(relative(before), relative(after));
  figures->correction_mm = 1e3 * moved.norm();
  figures->correction_deg = degrees_from_radians(angle);
  figures->correction_px = pixels_at_4096(angle);
}

class Judgement {
 public:
  Judgement(const CaptureSet& set, CrossingFigures* figures)
      : name_(fmt::format("lines {} and {}", set.lines[static_cast<size_t>(figures->along_x)].id,
                          set.lines[static_cast<size_t>(figures->along_z)].id)),
        figures_(figures) {}

  void warn(const std::string& problem) { figures_->warnings.push_back(name_ + ": " + problem); }

 private:
  std::string name_;
  CrossingFigures* figures_;
};

void judge_disagreement(const CrossingFigures& figures, const Measured& after,
                        const GridScale& scale, Judgement* judgement) {
  const double limit_mm = 1e3 * kPositionLimit_spacings * scale.spacing_m;
  const double sigma_px = pixels_at_4096(radians_from_degrees(figures.after.rotation_sigma_deg));
  const double sigma_mm = figures.after.position_sigma_mm;
  if (sigma_px > kCoarsestCheck * kRotationLimit_px || sigma_mm > kCoarsestCheck * limit_mm) {
    judgement->warn(fmt::format(
        "the held-out matches measure their difference only to {:.2g} px and {:.2g} mm, too "
        "coarsely for a check; use larger panoramas, or light and texture the scene better",
        sigma_px, sigma_mm));
  }
  const PoseCovariance& covariance = after.fit.covariance;
  if (figures.after.rotation_px > kRotationLimit_px &&
      sigmas_from_zero(after.fit.rotation_rad, covariance, 3) > kSigmas) {
    judgement->warn(fmt::format(
        "held-out matches still show a relative rotation of {:.2f} px ({:.3f} +- {:.3f} degrees); "
        "look at the overlays, then solve the poses with more keyframes",
        figures.after.rotation_px, figures.after.rotation_deg, figures.after.rotation_sigma_deg));
  }
  if (figures.after.position_mm > limit_mm &&
      sigmas_from_zero(after.fit.motion_m, covariance, 0) > kSigmas) {
    judgement->warn(fmt::format(
        "held-out matches still show a relative displacement of {:.2f} +- {:.2f} mm; look at the "
        "overlays, then solve the poses with more keyframes",
        figures.after.position_mm, figures.after.position_sigma_mm));
  }
  if (figures.after.median_px > kMedianRatio * after.own_median_px) {
    judgement->warn(fmt::format(
        "held-out matches are off their epipolar lines by {:.2f} px, by {:.2f} px when fitted "
        "freely; solve the poses with more keyframes",
        figures.after.median_px, after.own_median_px));
  }
}

void judge_split(const CrossingFigures& figures, const GridScale& scale, Judgement* judgement) {
  const double limit_mm = 1e3 * kPositionLimit_spacings * scale.spacing_m;
  const double limit_deg = kRotationLimit_px * 360.0 / 4096.0;
  const bool apart =
      figures.split_half_mm > std::max(limit_mm, kSplitSigmas * figures.split_half_expected_mm);
  const bool turned =
      figures.split_half_deg > std::max(limit_deg, kSplitSigmas * figures.split_half_expected_deg);
  if (!apart && !turned) return;
  judgement->warn(fmt::format(
      "two estimates from half of the data each differ by {:.2f} mm and {:.3f} degrees, where "
      "{:.2f} mm and {:.3f} degrees are expected; part of the data is wrong: look at the stations' "
      "residuals",
      figures.split_half_mm, figures.split_half_deg, figures.split_half_expected_mm,
      figures.split_half_expected_deg));
}

void judge(const CaptureSet& set, const Measured& after, const GridScale& scale,
           CrossingFigures* figures) {
  Judgement judgement(set, figures);
  if (figures->held_out_matches < kFewestHeldOut) {
    judgement.warn(fmt::format(
        "only {} held-out matches where they cross, {} are needed; check that both lines were "
        "captured in this room, that pictures are sharp and lit alike, and that each line lies "
        "where it was planned",
        figures->held_out_matches, kFewestHeldOut));
  } else {
    judge_disagreement(*figures, after, scale, &judgement);
  }
  judge_split(*figures, scale, &judgement);
  // Matches were searched around the start: a correction near the limit of the search is not
  // reliable.
  constexpr double kLargestTurn_deg = 0.8 * kMatchGate_deg;
  const double largest_mm = 3e3 * fit_scale(scale).motion_m;
  if (figures->correction_deg > kLargestTurn_deg || figures->correction_mm > largest_mm) {
    judgement.warn(fmt::format(
        "moved by {:.0f} mm and {:.1f} degrees relative to each other, more than the search allows "
        "({:.0f} mm, {:.0f} degrees); correct the positions of the lines in the plan",
        figures->correction_mm, figures->correction_deg, largest_mm, kLargestTurn_deg));
  }
  figures->trustworthy = figures->warnings.empty();
}

}  // namespace

CrossingFigures crossing_figures(const CaptureSet& set, const CrossingEvidence& evidence,
                                 const FramePoses& before, const FramePoses& after,
                                 const GridScale& scale) {
  const CrossingMatches& crossing = *evidence.matches;
  const std::vector<CrossingMatch> matches = held_out(crossing);
  const Measured at_start = measure(matches, before, scale);
  const Measured at_end = measure(matches, after, scale);
  CrossingFigures figures{.along_x = crossing.crossing.along_x,
                          .along_z = crossing.crossing.along_z,
                          .at = crossing.crossing.at,
                          .matches = evidence.used_matches,
                          .held_out_matches = at_end.fit.inliers,
                          .noise_px = pixels_at_4096(evidence.noise_rad),
                          .before = at_start.figures,
                          .after = at_end.figures};
  add_correction(crossing, before, after, &figures);
  figures.sigma_mm = 1e3 * axis_sigma(evidence.covariance, 0);
  const double sigma_rad = axis_sigma(evidence.covariance, 3);
  figures.sigma_deg = degrees_from_radians(sigma_rad);
  figures.sigma_px = pixels_at_4096(sigma_rad);
  figures.split_half_mm = 1e3 * evidence.split.position_m;
  figures.split_half_expected_mm = 1e3 * evidence.split.position_expected_m;
  figures.split_half_deg = degrees_from_radians(evidence.split.rotation_rad);
  figures.split_half_expected_deg = degrees_from_radians(evidence.split.rotation_expected_rad);
  judge(set, at_end, scale, &figures);
  return figures;
}

}  // namespace raywalk::calibrate
