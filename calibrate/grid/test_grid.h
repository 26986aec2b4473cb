// For tests: a capture on rails that lie off the plan, with its true poses, solved poses with
// errors and matches at the crossings.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "calibrate/grid/crossing_matches.h"
#include "calibrate/grid/rail_model.h"

namespace raywalk::calibrate {

struct TestGridSettings {
  int lines_x = 2;
  int lines_z = 2;
  int stations = 41;         // of each line
  double cell_m = 1.0;       // between lines; lines reach a quarter of it beyond
  double placing_mm = 10.0;  // standard deviations
  double turn_deg = 0.8;
  double jitter_mm = 1.0;
  double jitter_deg = 0.1;
  double bow_mm = 0.0;     // of every line, across
  double twist_deg = 0.0;  // of every line, about its direction
  double solved_mm = 0.1;  // errors of the solved poses
  double solved_deg = 0.005;
  int matches = 60;          // of each pair of frames at a crossing
  double noise_deg = 0.05;   // of a bearing
  double wrong_share = 0.1;  // of the matches
};

struct TestGrid {
  CaptureSet set{};
  std::vector<RailFrame> frames{};
  std::vector<RailParameters> rails{};  // true
  FramePoses truth{};
  FramePoses solved{};
  std::vector<CrossingMatches> crossings{};
};

class TestGridMaker {
 public:
  TestGridMaker(const TestGridSettings& settings, unsigned seed)
      : settings_(settings), random_(seed) {}

  TestGrid make() {
    TestGrid grid;
    grid.set.frame = {1024, 512};
    for (int i = 0; i < settings_.lines_x; ++i) add_line(LineAxis::kX, i, &grid);
    for (int i = 0; i < settings_.lines_z; ++i) add_line(LineAxis::kZ, i, &grid);
    for (size_t line = 0; line < grid.set.lines.size(); ++line) add_truth(line, &grid);
    for (const LineCrossing& crossing : crossings_of(grid.set)) add_matches(crossing, &grid);
    return grid;
  }

  double normal(double sigma) { return sigma * normal_(random_); }
  Eigen::Vector3d normal3(double sigma) { return {normal(sigma), normal(sigma), normal(sigma)}; }

 private:
  double mm() const { return 1e-3; }

  void add_line(LineAxis axis, int number, TestGrid* grid) {
    const int lines = axis == LineAxis::kX ? settings_.lines_x : settings_.lines_z;
    const double across_m = settings_.cell_m * (number - 0.5 * (lines - 1));
    CaptureLine line{
        .id = fmt::format("{}{}", name_of(axis), number), .axis = axis, .across_m = across_m};
    const int index = static_cast<int>(grid->set.lines.size());
    for (int i = 0; i < settings_.stations; ++i) {
      const double rail_m =
          settings_.cell_m * 1.5 * (i / std::max(1.0, settings_.stations - 1.0) - 0.5);
      CaptureFrame frame{.name = fmt::format("{}_{:03}", line.id, i), .line = index};
      frame.nominal_m = axis == LineAxis::kX ? Eigen::Vector3d(rail_m, 0.0, across_m)
                                             : Eigen::Vector3d(across_m, 0.0, rail_m);
      line.frames.push_back(static_cast<int>(grid->set.frames.size()));
      grid->set.frames.push_back(std::move(frame));
    }
    grid->set.lines.push_back(std::move(line));
  }

  void add_truth(size_t line, TestGrid* grid) {
    using P = RailParameter;
    const RailFrame frame = rail_frame(grid->set, static_cast<int>(line));
    RailParameters rail{};
    const double turn = radians_from_degrees(settings_.turn_deg);
    for (size_t i = 0; i < 3; ++i) {
      rail[P::kOffset + i] = normal(mm() * settings_.placing_mm);
      rail[P::kRotation + i] = normal(turn);
    }
    rail[P::kHeading] = normal(turn);
    rail[P::kTilt] = normal(turn);
    rail[P::kBow] = mm() * settings_.bow_mm;
    rail[P::kTwist + (frame.axis == LineAxis::kX ? 0 : 2)] =
        radians_from_degrees(settings_.twist_deg);
    for (const int index : grid->set.lines[line].frames) {
      const double rail_m = grid->set.rail_m(index);
      FramePose pose{
          .position_m =
              rail_position(frame, rail.data(), rail_m) + normal3(mm() * settings_.jitter_mm),
          .world_from_camera = matrix_of(normal3(radians_from_degrees(settings_.jitter_deg))) *
                               matrix_of(rail_rotation(frame, rail.data(), rail_m)),
          .origin = PoseOrigin::kSolved};
      grid->truth.emplace_back(pose);
      pose.position_m += normal3(mm() * settings_.solved_mm);
      pose.world_from_camera =
          matrix_of(normal3(radians_from_degrees(settings_.solved_deg))) * pose.world_from_camera;
      pose.position_sigma_mm = settings_.solved_mm;
      pose.rotation_sigma_deg = settings_.solved_deg;
      grid->solved.emplace_back(pose);
    }
    grid->frames.push_back(frame);
    grid->rails.push_back(rail);
  }

  Eigen::Vector3d direction() {
    Eigen::Vector3d any = normal3(1.0);
    while (any.norm() < 1e-3) any = normal3(1.0);
    return any.normalized();
  }

  Eigen::Vector3d seen(const FramePose& pose, const Eigen::Vector3d& point) {
    const Eigen::Vector3d exact = pose.world_from_camera.transpose() * (point - pose.position_m);
    return (exact.normalized() + normal3(radians_from_degrees(settings_.noise_deg))).normalized();
  }

  void add_matches(const LineCrossing& crossing, TestGrid* grid) {
    CrossingMatches matches{crossing,
                            nearest_frames(grid->set, crossing.along_x, crossing.at),
                            nearest_frames(grid->set, crossing.along_z, crossing.at),
                            {}};
    std::uniform_real_distribution<double> share(0.0, 1.0);
    // Points of a room around the grid, each seen by all frames of the crossing.
    for (int i = 0; i < settings_.matches; ++i) {
      const double distance_m = settings_.cell_m * (0.8 + 3.0 * share(random_));
      const Eigen::Vector3d point =
          Eigen::Vector3d(crossing.at.x_m, 0.0, crossing.at.z_m) + distance_m * direction();
      for (const int x : matches.frames_x) {
        for (const int z : matches.frames_z) {
          CrossingMatch match{.frame_x = x, .frame_z = z};
          match.ray_x.bearing = seen(*grid->truth[static_cast<size_t>(x)], point);
          match.ray_z.bearing = share(random_) < settings_.wrong_share
                                    ? direction()
                                    : seen(*grid->truth[static_cast<size_t>(z)], point);
          match.held_out = i % 2 == 0;
          matches.matches.push_back(match);
        }
      }
    }
    grid->crossings.push_back(std::move(matches));
  }

  TestGridSettings settings_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_{0.0, 1.0};
};

// The error of two frames' relative pose.
struct RelativeError {
  double position_mm = 0.0;
  double rotation_deg = 0.0;
};
inline RelativeError relative_error(const FramePoses& poses, const FramePoses& truth, int a,
                                    int b) {
  const auto at = [](const FramePoses& from, int frame) -> const FramePose& {
    return *from[static_cast<size_t>(frame)];
  };
  const auto relative_rotation = [&](const FramePoses& from) -> Eigen::Matrix3d {
    return at(from, a).world_from_camera.transpose() * at(from, b).world_from_camera;
  };
  // In the axes of the first camera, which cancels the common motion of all lines.
  const auto relative_position = [&](const FramePoses& from) -> Eigen::Vector3d {
    return at(from, a).world_from_camera.transpose() *
           (at(from, b).position_m - at(from, a).position_m);
  };
  return {1e3 * (relative_position(poses) - relative_position(truth)).norm(),
          degrees_from_radians(angle_between(relative_rotation(poses), relative_rotation(truth)))};
}

}  // namespace raywalk::calibrate
