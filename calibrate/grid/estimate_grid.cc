#include "calibrate/grid/estimate_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "calibrate/grid/crossing_matches.h"
#include "calibrate/grid/grid_warnings.h"
#include "calibrate/grid/held_out_poses.h"
#include "calibrate/grid/joint_estimate.h"
#include "calibrate/grid/prepared_rails.h"
#include "calibrate/grid/split_estimates.h"
#include "calibrate/poses/align_poses.h"
#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

// Names the held-out frames without a pose. `held_out` are their poses, in order.
void add_note(const CaptureSet& set, const FramePoses& held_out, GridMethod method,
              GridResult* result) {
  std::string names;
  for (std::size_t i = 0; i < held_out.size(); ++i) {
    if (held_out[i]) continue;
    names += (names.empty() ? "" : ", ") + set.frames[set.stations() + i].name;
  }
  if (names.empty()) return;
  result->notes.push_back(fmt::format(
      "held-out frames without a pose, left out of gt.csv: {}{}", names,
      method == GridMethod::kRotation ? " (--method rotation solves none of them)" : ""));
}

using P = RailParameter;

// Number of inlier matches from which a crossing connects two lines.
constexpr int kMinConnectingMatches = 15;

std::vector<CrossingMatch> used_half(const CrossingMatches& crossing) {
  std::vector<CrossingMatch> matches;
  std::copy_if(crossing.matches.begin(), crossing.matches.end(), std::back_inserter(matches),
               [](const CrossingMatch& match) { return !match.held_out; });
  return matches;
}

std::vector<FittedCrossing> fit_crossings(const std::vector<CrossingMatches>& crossings,
                                          const FramePoses& poses, const GridScale& scale) {
  std::vector<FittedCrossing> fitted;
  for (const CrossingMatches& crossing : crossings) {
    const std::vector<CrossingMatch> matches = used_half(crossing);
    fitted.push_back({crossing.crossing, fit_crossing(matches, poses, fit_scale(scale))});
  }
  return fitted;
}

std::vector<FittedCrossing> connecting(std::vector<FittedCrossing> fitted) {
  std::erase_if(fitted,
                [](const FittedCrossing& one) { return one.fit.inliers < kMinConnectingMatches; });
  return fitted;
}

std::vector<MatchObservations> observations_of(const std::vector<CrossingMatches>& crossings,
                                               const std::vector<FittedCrossing>& fitted) {
  std::vector<MatchObservations> observations;
  for (size_t i = 0; i < crossings.size(); ++i) {
    const CrossingFit& fit = fitted[i].fit;
    MatchObservations one{.noise_rad = fit.noise_rad, .depth = fit.depth};
    const std::vector<CrossingMatch> matches = used_half(crossings[i]);
    for (size_t j = 0; j < matches.size() && fit.inliers >= kMinConnectingMatches; ++j) {
      if (fit.inlier[j]) one.matches.push_back(matches[j]);
    }
    observations.push_back(std::move(one));
  }
  return observations;
}

// Moves lines without solved poses to agree with the crossings.
void move_unsolved(const std::vector<FittedCrossing>& fitted, PreparedRails* prepared) {
  std::vector<LineMotion> motions;
  std::vector<bool> may_move;
  for (size_t line = 0; line < prepared->rails.size(); ++line) {
    const RailParameters& p = prepared->rails[line].parameters;
    motions.push_back({{p[P::kRotation], p[P::kRotation + 1], p[P::kRotation + 2]},
                       {p[P::kOffset], p[P::kOffset + 1], p[P::kOffset + 2]}});
    may_move.push_back(!prepared->fits[line].has_value());
  }
  align_at_crossings(connecting(fitted), may_move, &motions);
  for (size_t line = 0; line < prepared->rails.size(); ++line) {
    if (!may_move[line]) continue;
    RailParameters& p = prepared->rails[line].parameters;
    std::copy_n(motions[line].rotation_rad.data(), 3, p.begin() + P::kRotation);
    std::copy_n(motions[line].offset_m.data(), 3, p.begin() + P::kOffset);
  }
}

// Tightens the priors of lines without solved poses: their direction and twist are known only as
// well as a rail is placed and built. With weaker priors a station's scatter would rotate them.
void hold_unsolved(const std::vector<FittedCrossing>& fitted, PreparedRails* prepared) {
  constexpr double kPlacingTurn_rad = radians_from_degrees(1.0);
  std::vector<int> connections(prepared->rails.size(), 0);
  for (const FittedCrossing& one : connecting(fitted)) {
    ++connections[static_cast<size_t>(one.crossing.along_x)];
    ++connections[static_cast<size_t>(one.crossing.along_z)];
  }
  for (size_t line = 0; line < prepared->rails.size(); ++line) {
    if (prepared->fits[line]) continue;
    RailStart& rail = prepared->rails[line];
    rail.direction_prior_rad = kPlacingTurn_rad;
    rail.twist_prior_rad = kPlacingTurn_rad;
    std::fill_n(rail.kept.begin() + P::kTwist, 3, connections[line] >= 2);
  }
}

struct Estimation {
  PreparedRails prepared{};
  SolvedLineError solved_error{};
  std::vector<MatchObservations> observations{};
  JointEstimate joint{};
};

Estimation estimate(const CaptureSet& set, const FramePoses& solved, const FramePoses& start,
                    const std::vector<CrossingMatches>& crossings, const GridScale& scale) {
  Estimation estimation{.prepared = prepare_rails(set, solved, start, scale)};
  PreparedRails& prepared = estimation.prepared;
  constexpr int kRounds = 2;
  Progress progress("estimating the lines", 1 + 2 * kRounds, "rounds");
  const auto fit_now = [&] {
    auto fits =
        fit_crossings(crossings, poses_on_rails(set, prepared.rails, prepared.solved), scale);
    progress.advance();
    return fits;
  };
  std::vector<FittedCrossing> fitted = fit_now();
  // Each crossing of a line gives its own motion. Their least-squares solution is a better start
  // for the next fits.
  for (int round = 0; round < kRounds; ++round) {
    move_unsolved(fitted, &prepared);
    fitted = fit_now();
  }
  hold_unsolved(fitted, &prepared);
  estimation.solved_error = common_error(connecting(fitted), prepared);
  std::vector<RelatedFrames> pairs;
  pairs.reserve(crossings.size());
  for (const CrossingMatches& crossing : crossings) {
    pairs.push_back({crossing.frames_x.front(), crossing.frames_z.front()});
  }
  // In the second round each station at a crossing is at its estimated pose, so the scatter of the
  // matches is their own noise.
  FramePoses poses = poses_on_rails(set, prepared.rails, prepared.solved);
  for (int round = 0; round < kRounds; ++round) {
    if (round > 0) fitted = fit_crossings(crossings, poses, scale);
    estimation.observations = observations_of(crossings, fitted);
    estimation.joint =
        estimate_jointly(set,
                         {prepared.rails, poses, prepared.solved, estimation.observations,
                          estimation.solved_error, fit_scale(scale).scene_m},
                         pairs);
    poses = estimation.joint.poses;
    progress.advance();
  }
  return estimation;
}

SplitDifference split_at(const CrossingMatches& crossing, const std::vector<HalfFits>& halves,
                         const FramePoses& poses, const GridScale& scale) {
  const HalfFits& x = halves[static_cast<size_t>(crossing.crossing.along_x)];
  const HalfFits& z = halves[static_cast<size_t>(crossing.crossing.along_z)];
  return x.enough && z.enough ? split_by_stations(x, z, crossing.crossing.at)
                              : split_by_matches(crossing, poses, fit_scale(scale));
}

void add_crossings(const CaptureSet& set, const Estimation& estimation, const FramePoses& start,
                   const std::vector<CrossingMatches>& crossings, const GridScale& scale,
                   GridResult* result) {
  std::vector<HalfFits> halves;
  for (size_t line = 0; line < set.lines.size(); ++line) {
    halves.push_back(fit_halves(estimation.prepared.rails[line].frame,
                                estimation.prepared.samples[line], scale.spacing_m));
  }
  for (size_t i = 0; i < crossings.size(); ++i) {
    const CrossingEvidence evidence{
        .matches = &crossings[i],
        .used_matches = static_cast<int>(estimation.observations[i].matches.size()),
        .noise_rad = estimation.observations[i].noise_rad,
        .covariance = estimation.joint.pair_covariance[i],
        .split = split_at(crossings[i], halves, result->poses, scale)};
    result->crossings.push_back(crossing_figures(set, evidence, start, result->poses, scale));
  }
}

bool connects(const CrossingFigures& crossing, int line) {
  return (crossing.along_x == line || crossing.along_z == line) &&
         crossing.matches >= kMinConnectingMatches &&
         crossing.held_out_matches >= kMinConnectingMatches;
}

LineFit line_of(const CaptureSet& set, int line, const Estimation& estimation,
                const std::vector<CrossingFigures>& crossings) {
  const auto index = static_cast<size_t>(line);
  const PreparedRails& prepared = estimation.prepared;
  const RailStart& rail = prepared.rails[index];
  LineFit fit{.line = line,
              .id = set.lines[index].id,
              .stations = static_cast<int>(set.lines[index].frames.size()),
              .solved_stations = static_cast<int>(prepared.samples[index].size()),
              .rejected_frames = prepared.rejected[index]};
  fit.connected =
      std::any_of(crossings.begin(), crossings.end(),
                  [&](const CrossingFigures& crossing) { return connects(crossing, line); });
  describe_rail(rail.frame, estimation.joint.rails[index], estimation.joint.rail_covariance[index],
                &fit);
  fit.jitter_along_mm = 1e3 * rail.jitter.along_m;
  fit.jitter_mm = 1e3 * rail.jitter.across_m;
  fit.jitter_deg = degrees_from_radians(rail.jitter.rotation_rad);
  if (prepared.fits[index]) {
    fit.position_models = prepared.fits[index]->position_models;
    fit.rotation_models = prepared.fits[index]->rotation_models;
  }
  return fit;
}

bool any_pose(const FramePoses& poses) {
  return std::any_of(poses.begin(), poses.end(), [](const auto& pose) { return pose.has_value(); });
}

}  // namespace

GridResult estimate_grid(const CaptureSet& panoramas, const FramePoses& solved,
                         const GridOptions& options) {
  const CaptureSet stations = stations_only(panoramas);
  // A station without an initial pose starts at its nominal pose.
  FramePoses start = nominal_poses(stations);
  for (size_t i = 0; i < std::min(start.size(), options.start.size()); ++i) {
    if (options.start[i]) start[i] = options.start[i];
  }
  const std::vector<CrossingMatches> crossings =
      find_crossing_matches(stations, start, options.mask, options.lenses);
  const auto count = std::min(solved.size(), stations.frames.size());
  GridResult result = estimate_from_matches(
      stations, options.method,
      {solved.begin(), solved.begin() + static_cast<std::ptrdiff_t>(count)}, start, crossings);
  // A pose that no picture was asked for would be no truth.
  const FramePoses held_out = options.method == GridMethod::kPoses
                                  ? held_out_poses(panoramas, solved, result)
                                  : FramePoses(panoramas.frames.size() - stations.frames.size());
  add_note(panoramas, held_out, options.method, &result);
  result.poses.insert(result.poses.end(), held_out.begin(), held_out.end());
  make_directories(options.out);
  write_file_atomically(options.out / "grid.json", json_text(grid_document(panoramas, result)));
  return result;
}

GridResult estimate_from_matches(const CaptureSet& set, GridMethod method, const FramePoses& solved,
                                 const FramePoses& start,
                                 const std::vector<CrossingMatches>& crossings) {
  GridResult result{.method = method};
  FramePoses in_world(set.frames.size());
  if (method == GridMethod::kPoses) {
    if (!any_pose(solved)) {
      throw Error(
          "no frame has a solved pose: run raywalk-calibrate poses first, or use --method "
          "rotation");
    }
    const PoseAlignment alignment = align_poses(set, solved, nominal_poses(set));
    result.scale = alignment.scale;
    in_world = aligned(solved, alignment);
  } else if (crossings.empty()) {
    throw Error(
        "no two lines cross, but --method rotation needs crossings: use --method poses, or capture "
        "a line that crosses the others");
  }
  const GridScale scale = grid_scale(set);
  const Estimation estimation = estimate(set, in_world, start, crossings, scale);
  result.poses = estimation.joint.poses;
  result.solved_line_error_mm = 1e3 * estimation.solved_error.position_m;
  result.solved_line_error_deg = degrees_from_radians(estimation.solved_error.rotation_rad);
  add_crossings(set, estimation, start, crossings, scale, &result);
  for (size_t line = 0; line < set.lines.size(); ++line) {
    result.lines.push_back(line_of(set, static_cast<int>(line), estimation, result.crossings));
  }
  add_warnings(set, scale, &result);
  return result;
}

}  // namespace raywalk::calibrate
