#include "build_lf/pack/listed_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/image_file.h"
#include "core/geometry/listed_axes.h"
#include "core/panorama/panorama_rotation.h"

namespace raywalk::build_lf {
namespace {

constexpr PanoramaSize kLook{256, 128};
// Steps between stations over the distance of a surface that are tried: 0 to a half.
constexpr int kSteps = 20;
constexpr double kLargestStep = 0.5;
// Another direction has to explain this much more than the listed one. True directions leave 0.4 to
// 0.65 of the difference in rendered and photographed rooms and streets, wrong ones 0.74 to 0.93.
constexpr double kClearly = 0.8;

Eigen::Vector3d direction(int index) {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  axis[index < 2 ? 0 : 2] = index % 2 == 0 ? 1.0 : -1.0;
  return axis;
}

// Where the second picture shows what the first one shows at each pixel, after a step along the
// direction over the distance of the surface; for cv::remap.
cv::Mat moved_pixels(const Eigen::Vector3d& along, double step) {
  cv::Mat map(kLook.height, kLook.width, CV_32FC2);
  for (int v = 0; v < kLook.height; ++v) {
    for (int u = 0; u < kLook.width; ++u) {
      const Eigen::Vector3d seen = direction_from_angles(
          angles_from_pixel({static_cast<double>(u), static_cast<double>(v)}, kLook));
      const PixelPosition at = pixel_from_angles(angles_from_direction(seen - step * along), kLook);
      map.at<cv::Vec2f>(v, u) = {static_cast<float>(at.u), static_cast<float>(at.v)};
    }
  }
  return map;
}

const std::vector<cv::Mat>& all_moved_pixels() {
  static const std::vector<cv::Mat> maps = [] {
    std::vector<cv::Mat> made;
    made.reserve(std::size_t{kDirections} * kSteps);
    for (int i = 0; i < kDirections; ++i) {
      for (int step = 1; step <= kSteps; ++step) {
        made.push_back(moved_pixels(direction(i), kLargestStep * step / kSteps));
      }
    }
    return made;
  }();
  return maps;
}

// Detail, without exposure: levels against their surroundings.
cv::Mat detail_of(const cv::Mat& panorama) {
  constexpr double kSurroundings_px = 6.0;
  cv::Mat small, grey, detail, mean;
  cv::resize(panorama, small, {kLook.width, kLook.height}, 0.0, 0.0, cv::INTER_AREA);
  cv::cvtColor(small, grey, cv::COLOR_BGR2GRAY);
  grey.convertTo(detail, CV_32F);
  cv::GaussianBlur(detail, mean, {}, kSurroundings_px);
  return detail - mean;
}

// Levels around each pixel; of what is not the same surface at most some, so that outlines and
// people do not outweigh the rest.
cv::Mat difference_of(const cv::Mat& a, const cv::Mat& b) {
  constexpr double kMost_levels = 30.0;
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  cv::min(difference, kMost_levels, difference);
  cv::blur(difference, difference, {7, 7});
  return difference;
}

double mean_over_sphere(const cv::Mat& values) {
  double sum = 0.0, weights = 0.0;
  for (int v = 0; v < values.rows; ++v) {
    const double weight = std::cos(angles_from_pixel({0.0, static_cast<double>(v)}, kLook).phi_rad);
    sum += weight * cv::mean(values.row(v))[0];
    weights += weight;
  }
  return sum / weights;
}

DirectionCosts costs_of_details(const cv::Mat& first, const cv::Mat& second) {
  constexpr double kLeast_levels = 0.1;
  const cv::Mat unmoved = difference_of(first, second);
  const double whole = mean_over_sphere(unmoved);
  DirectionCosts costs{};
  costs.fill(1.0);
  if (whole < kLeast_levels) return costs;
  cv::Mat moved;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    cv::Mat best = unmoved.clone();
    for (std::size_t step = 0; step < kSteps; ++step) {
      cv::remap(second, moved, all_moved_pixels()[i * kSteps + step], cv::noArray(),
                cv::INTER_LINEAR, cv::BORDER_WRAP);
      cv::min(best, difference_of(first, moved), best);
    }
    costs.at(i) = mean_over_sphere(best) / whole;
  }
  return costs;
}

cv::Mat detail_of(const StationSource& source) {
  cv::Mat panorama = read_panorama(source.panorama);
  cv::resize(panorama, panorama, {2 * kLook.width, 2 * kLook.height}, 0.0, 0.0, cv::INTER_AREA);
  if (source.attitude) panorama = rotate_panorama(panorama, world_from_camera(*source.attitude));
  return detail_of(panorama);
}

// The axis along which the line's pictures move from its first towards its last station: that of
// the list unless another one is clearly better.
std::string axis_of_motion(const Line& line, const std::vector<StationSource>& sources) {
  const std::size_t from = sources.size() / 3;
  const cv::Mat first = detail_of(sources[from]);
  // Near and far surfaces move well between neighbours and between stations farther apart.
  DirectionCosts sum{};
  for (const std::size_t apart : {1, 2, 4, 8}) {
    if (from + apart >= sources.size()) break;
    throw_if_interrupted();
    const DirectionCosts costs = costs_of_details(first, detail_of(sources[from + apart]));
    for (std::size_t i = 0; i < sum.size(); ++i) sum.at(i) += costs.at(i);
  }
  const std::size_t listed = line.axis == LineAxis::kX ? 0 : 2;
  const auto best = static_cast<std::size_t>(std::ranges::min_element(sum) - sum.begin());
  const bool differs = sum.at(best) < kClearly * sum.at(listed);
  return nearest_axis(direction(static_cast<int>(differs ? best : listed)));
}

}  // namespace

DirectionCosts costs_of_travel(const cv::Mat& first, const cv::Mat& second) {
  return costs_of_details(detail_of(first), detail_of(second));
}

void require_listed_motion(const PackPlan& plan, const std::string& list) {
  if (plan.panorama.width < kLook.width) return;
  const std::vector<Line>& lines = plan.grid.lines;
  std::vector<std::string> moves(lines.size());
  Progress progress("looking at", std::ssize(lines), "lines", Progress::Shown::kIfLong);
  all_moved_pixels();
  parallel_for(0, static_cast<int>(lines.size()), 1, [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      if (plan.sources[i].size() > 1) moves[i] = axis_of_motion(lines[i], plan.sources[i]);
      progress.advance();
    }
  });
  // What all lines along an axis have in common; "" where there is none, or they differ.
  const auto common = [&](LineAxis axis) {
    std::string move;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (lines[i].axis != axis || moves[i].empty()) continue;
      if (!move.empty() && move != moves[i]) return std::string();
      move = moves[i];
    }
    return move;
  };
  const std::string x = common(LineAxis::kX), z = common(LineAxis::kZ);
  if (const std::string fault = likely_fault_of_axes(x, z); !fault.empty()) {
    const auto found = [](const std::string& move, const char* listed) {
      return move.empty() ? ""
                          : fmt::format(", what is listed along {} moves along {}", listed, move);
    };
    throw Error(
        fmt::format("{}: by the pictures{}{}: {}", list, found(x, "x"), found(z, "z"), fault));
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string listed = lines[i].axis == LineAxis::kX ? "x" : "z";
    if (moves[i].empty() || moves[i] == listed) continue;
    throw Error(
        fmt::format("{}: by the pictures, line {} ({} to {}) moves along {} where {} is listed{}",
                    list, lines[i].id, lines[i].stations.front().file,
                    lines[i].stations.back().file, moves[i], listed,
                    moves[i] == "-" + listed
                        ? ": its stations are listed in reverse order; correct the positions"
                        : "; correct its positions"));
  }
}

}  // namespace raywalk::build_lf
