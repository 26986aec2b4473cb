#include "calibrate/rectify/exposure_gains.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/panorama/gain_graph.h"
#include "core/panorama/panorama_rotation.h"
#include "core/panorama/srgb.h"
#include "core/panorama/transposed_border.h"

namespace raywalk::calibrate {
namespace {

// Pictures are rotated at this width, twice that of the comparison, as interpolation blurs.
constexpr int kTurnedWidth = 2 * kComparisonWidth;
// Prior sigma of a camera's exposure changes; weak relative to any link.
constexpr double kPriorLog = 0.5;

// Position of a frame's pose in the x-z plane.
Eigen::Vector2d plan_position(const FramePoses& poses, int frame) {
  const Eigen::Vector3d& at = poses[static_cast<std::size_t>(frame)]->position_m;
  return {at.x(), at.z()};
}

std::vector<int> posed_frames(const CaptureLine& line, const FramePoses& poses) {
  std::vector<int> frames;
  for (const int frame : line.frames) {
    if (poses[static_cast<std::size_t>(frame)]) frames.push_back(frame);
  }
  return frames;
}

std::vector<int> nearest_two(const CaptureLine& line, const FramePoses& poses, PlanPoint at) {
  std::vector<int> frames = posed_frames(line, poses);
  const Eigen::Vector2d place(at.x_m, at.z_m);
  const std::size_t count = std::min<std::size_t>(2, frames.size());
  std::partial_sort(frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count),
                    frames.end(), [&](int a, int b) {
                      return (plan_position(poses, a) - place).norm() <
                             (plan_position(poses, b) - place).norm();
                    });
  frames.resize(count);
  return frames;
}

cv::Mat shrunk_to_width(const cv::Mat& picture, int width) {
  if (picture.cols <= width) return picture;
  cv::Mat shrunk;
  cv::resize(picture, shrunk, {width, width / 2}, 0.0, 0.0, cv::INTER_AREA);
  return shrunk;
}

// The mask grown by half a window of the flow. A reduced pixel is masked if any of its source
// pixels is.
cv::Mat reduced_validity(const cv::Mat& mask, const Eigen::Matrix3d& world_from_camera) {
  const cv::Mat turned = rotate_mask(shrunk_to_width(mask, kTurnedWidth) == 255, world_from_camera);
  const cv::Mat reduced = shrunk_to_width(turned, kComparisonWidth) == 255;
  constexpr int kMargin = kFlowWindow / 2 + 1;
  const cv::Mat bordered = with_border(reduced.t(), kMargin);
  cv::Mat clear;
  cv::erode(bordered, clear, cv::Mat::ones(2 * kMargin + 1, 2 * kMargin + 1, CV_8UC1));
  return without_border(clear, kMargin).clone();
}

}  // namespace

std::vector<FrameLink> links_of(const CaptureSet& set, const FramePoses& poses) {
  std::vector<FrameLink> links;
  for (const CaptureLine& line : set.lines) {
    const std::vector<int> frames = posed_frames(line, poses);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      for (std::size_t j = i + 1; j < std::min(i + 3, frames.size()); ++j) {
        links.push_back({frames[i], frames[j]});
      }
    }
  }
  for (const LineCrossing& crossing : crossings_of(set)) {
    const auto near = [&](int line) {
      return nearest_two(set.lines[static_cast<std::size_t>(line)], poses, crossing.at);
    };
    const std::vector<int> along_z = near(crossing.along_z);
    for (const int from : near(crossing.along_x)) {
      for (const int to : along_z) links.push_back({from, to});
    }
  }
  return links;
}

ComparedPicture picture_to_compare(const cv::Mat& panorama, const cv::Mat& mask,
                                   const Eigen::Matrix3d& world_from_camera) {
  const cv::Mat turned =
      rotate_panorama(shrunk_to_width(panorama, kTurnedWidth), world_from_camera);
  cv::Mat colours;
  cv::cvtColor(shrunk_to_width(turned, kComparisonWidth), colours, cv::COLOR_BGR2RGB);
  ComparedPicture picture{.colours = colours.t()};
  if (!mask.empty()) picture.valid = reduced_validity(mask, world_from_camera);
  return picture;
}

std::vector<LightGain> solve_gains(int frames, std::span<const ComparedLink> links) {
  std::vector<LightGain> gains(static_cast<std::size_t>(frames), LightGain{1.0, 1.0, 1.0});
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<GainEquation> equations;
    for (const auto& [link, colours] : links) {
      if (!colours.comparable) continue;
      equations.push_back({.from = link.from,
                           .to = link.to,
                           .difference = colours.log_ratio[c],
                           .error = colours.log_ratio_error[c]});
    }
    const Eigen::VectorXd log_gain = solve_gain_graph(equations, frames, kPriorLog);
    for (std::size_t i = 0; i < gains.size(); ++i) {
      gains[i][c] = std::exp(log_gain[static_cast<Eigen::Index>(i)]);
    }
  }
  return gains;
}

LevelsUnderGain::LevelsUnderGain(const LightGain& gain) {
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < table_[c].size(); ++i) {
      const double level = static_cast<double>(i) / kStepsPerLevel;
      table_[c][i] =
          static_cast<float>(srgb_level_from_linear(gain[c] * linear_from_srgb_level(level)));
    }
  }
}

cv::Vec3f LevelsUnderGain::operator()(const cv::Vec3f& levels) const {
  cv::Vec3f changed;
  for (int c = 0; c < 3; ++c) {
    const auto& table = table_[static_cast<std::size_t>(2 - c)];
    const float at = std::clamp(levels[c], 0.0f, 255.0f) * kStepsPerLevel;
    const auto below = static_cast<std::size_t>(at);
    const float share = at - static_cast<float>(below);
    changed[c] = table[below] + share * (table[below + 1] - table[below]);
  }
  return changed;
}

}  // namespace raywalk::calibrate
