#include "build_lf/depth/flow_depth.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <optional>

#include "core/base/parallel.h"
#include "core/panorama/transposed_border.h"
#include "core/room/station_image.h"

namespace raywalk::build_lf {
namespace {

// Grey images with equalised exposure and a border for content that moves in.
class FlowImages {
 public:
  FlowImages(const Room& room, PanoramaSize size, const GainFields& gains)
      : room_(room), size_(size), gains_(gains), border_px_(size.height / kBorderShare) {}

  cv::Mat grey(StationIndex station) const {
    cv::Mat image = station_image(room_, station, size_);
    apply_gains(gain_field(gains_, station), &image);
    cv::cvtColor(image, image, cv::COLOR_RGB2GRAY);
    return with_border(image, border_px_);
  }

  // The optical flow from `from` to `to`, in pixels, CV_32FC2: x along phi, y along theta. Includes
  // the border, where displaced pixels may be looked up.
  static cv::Mat flow(const cv::Mat& from, const cv::Mat& to) {
    cv::Mat displacement;
    cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_MEDIUM)->calc(from, to, displacement);
    return displacement;
  }
  int border_px() const { return border_px_; }

 private:
  // With a baseline of a quarter of the reach (half a cell's side), a surface at a twelfth of the
  // side moves by less than the border.
  static constexpr int kBorderShare = 4;
  const Room& room_;
  PanoramaSize size_;
  const GainFields& gains_;
  int border_px_;
};

// The estimate for one pixel from one neighbour.
struct Sighting {
  float inverse = 0.0f;  // 1/m
  float weight = 0.0f;   // inverse variance of inverse per pixel^2 of flow error; 0: invalid
  float agrees = 0.0f;   // agreement() of forward and backward flow
  friend bool operator==(const Sighting&, const Sighting&) = default;
};

// A pixel is valid if an error of one pixel in the flow changes inverse by less than kMaxErrorShare
// / reach, and if forward and backward flow agree within kMaxReturn_px.
constexpr double kMaxErrorShare = 0.25;
constexpr double kMaxReturn_px = 2.0;

// 1 for no difference, 1/2 at half a pixel (Cauchy weight).
double agreement(double apart_px) {
  constexpr double kHalf_px = 0.5;
  return 1.0 / (1.0 + (apart_px / kHalf_px) * (apart_px / kHalf_px));
}

// The point P = u / inverse (u: its direction from the reference, t: the vector to the other
// station) is seen from there along P - t, that is along u - inverse t. If it is seen in direction
// w, then w x (u - inverse t) = 0, whose least-squares solution is
//   inverse = (w x u).(w x t) / |w x t|^2,
// clamped to 0, as nothing lies beyond infinity.
double triangulate(const Eigen::Vector3d& u, const Eigen::Vector3d& w, const Eigen::Vector3d& t) {
  const Eigen::Vector3d wt = w.cross(t);
  const double squared = wt.squaredNorm();
  if (squared <= std::numeric_limits<double>::min()) return 0.0;
  return std::max(0.0, w.cross(u).dot(wt) / squared);
}

// Forward and backward flow between the reference and a neighbour.
class Neighbour {
 public:
  Neighbour(const cv::Mat& there, const cv::Mat& back, int border_px,
            const Eigen::Vector3d& baseline_m, PanoramaSize size)
      : there_(there), back_(back), border_px_(border_px), baseline_m_(baseline_m), size_(size) {}

  Sighting at(int theta, int phi, const Eigen::Vector3d& u) const {
    const auto moved = there_.at<cv::Vec2f>(border_px_ + theta, border_px_ + phi);
    const double to_phi = phi + moved[0];
    const double to_theta = theta + moved[1];
    const Eigen::Vector3d w = direction_from_angles(angles_from_pixel({to_theta, to_phi}, size_));
    const double pixel_rad = kTwoPi / size_.width;
    const double parallax_m = u.cross(baseline_m_).norm();  // radians per 1/m
    const double return_px = return_error(to_theta, to_phi, moved, std::hypot(u.x(), u.z()));
    const double agrees = agreement(return_px);
    const bool trusted = return_px < kMaxReturn_px;
    return {static_cast<float>(triangulate(u, w, baseline_m_)),
            trusted ? static_cast<float>(agrees * std::pow(parallax_m / pixel_rad, 2)) : 0.0f,
            static_cast<float>(agrees)};
  }

 private:
  // Forward-backward error of the flow, in pixels at the equator.
  double return_error(double to_theta, double to_phi, const cv::Vec2f& moved,
                      double cos_phi) const {
    const int row = static_cast<int>(std::lround(to_theta)) + border_px_;
    const int col = static_cast<int>(std::lround(to_phi)) + border_px_;
    if (row < 0 || row >= back_.rows || col < 0 || col >= back_.cols) {
      return std::numeric_limits<double>::infinity();
    }
    const auto returned = back_.at<cv::Vec2f>(row, col) + moved;
    return std::hypot(returned[0], cos_phi * returned[1]);
  }

  cv::Mat there_;
  cv::Mat back_;
  int border_px_;
  Eigen::Vector3d baseline_m_;
  PanoramaSize size_;
};

// The station on one side (+1 or -1) whose distance has the ratio closest to 1 to `baseline_m`.
std::optional<int> neighbour_on(const Line& line, int station, int side, double baseline_m) {
  std::optional<int> best;
  double least = std::numeric_limits<double>::infinity();
  const double here_m = line.stations[static_cast<size_t>(station)].along_m;
  for (int i = station + side; i >= 0 && i < static_cast<int>(line.stations.size()); i += side) {
    const double distance_m = std::fabs(line.stations[static_cast<size_t>(i)].along_m - here_m);
    const double error = std::fabs(std::log(distance_m / baseline_m));
    if (error < least) {
      least = error;
      best = i;
    }
  }
  return best;
}

std::vector<Neighbour> follow(const FlowImages& images, const Line& line, StationIndex station,
                              double reach_m, PanoramaSize size) {
  constexpr double kBaselineShare = 0.25;
  std::vector<int> others;
  for (const int side : {-1, 1}) {
    const auto other = neighbour_on(line, station.station, side, kBaselineShare * reach_m);
    if (other) others.push_back(*other);
  }
  const cv::Mat reference = images.grey(station);
  const Eigen::Vector3d& here_m = line.stations[static_cast<size_t>(station.station)].position_m;
  std::vector<Neighbour> neighbours;
  for (const int other : others) {
    const cv::Mat seen = images.grey({station.line, other});
    const Eigen::Vector3d baseline_m =
        line.stations[static_cast<size_t>(other)].position_m - here_m;
    neighbours.emplace_back(FlowImages::flow(reference, seen), FlowImages::flow(seen, reference),
                            images.border_px(), baseline_m, size);
  }
  return neighbours;
}

// The weighted mean of the valid sightings if they agree within kMaxReturn_px, otherwise the best
// one (the point may be occluded on one side). Both sides rarely have the same error, so their
// agreement is the best measure of confidence; with one side only it counts as 0.5.
Sighting combine(const std::vector<Sighting>& sightings) {
  Sighting best;
  for (const Sighting& sighting : sightings) {
    if (sighting.weight > best.weight) best = sighting;
  }
  if (best.weight <= 0.0f) return best;
  Sighting mean{best.inverse * best.weight, best.weight, best.agrees};
  double sides_agree = 0.5;
  for (const Sighting& sighting : sightings) {
    if (sighting.weight <= 0.0f || sighting == best) continue;
    const double apart_px = std::fabs(sighting.inverse - best.inverse) * std::sqrt(sighting.weight);
    sides_agree = agreement(apart_px);
    if (apart_px > kMaxReturn_px) continue;
    mean.inverse += sighting.weight * sighting.inverse;
    mean.weight += sighting.weight;
  }
  mean.inverse /= mean.weight;
  mean.agrees *= static_cast<float>(sides_agree);
  return mean;
}

// Fills unknown pixels of a row (all columns at one phi) with the farther of the nearest known ones
// on either side, across the seam. False if the row has no known pixel.
bool fill_row(int phi, InverseDistanceMap* map) {
  const int width = map->size.width;
  const auto index = [&](int theta) {
    return pixel_index((theta + width) % width, phi, map->size);
  };
  std::vector<int> known;
  for (int theta = 0; theta < width; ++theta) {
    if (map->confidence[index(theta)] > 0) known.push_back(theta);
  }
  if (known.empty()) return false;
  for (size_t i = 0; i < known.size(); ++i) {
    const int left = known[i];
    const int right = i + 1 < known.size() ? known[i + 1] : known.front() + width;
    const float farther = std::min(map->inverse[index(left)], map->inverse[index(right)]);
    for (int theta = left + 1; theta < right; ++theta) map->inverse[index(theta)] = farther;
  }
  return true;
}

// Fills every row; rows without known pixels are copied from the nearest filled row. A map without
// any known pixel stays infinitely far.
void fill_unknown(InverseDistanceMap* map) {
  std::vector<int> filled;
  std::vector<int> empty;
  for (int phi = 0; phi < map->size.height; ++phi) {
    (fill_row(phi, map) ? filled : empty).push_back(phi);
  }
  for (const int phi : empty) {
    const auto nearest = std::min_element(filled.begin(), filled.end(), [&](int a, int b) {
      return std::abs(a - phi) < std::abs(b - phi);
    });
    if (nearest == filled.end()) return;
    for (int theta = 0; theta < map->size.width; ++theta) {
      map->inverse[pixel_index(theta, phi, map->size)] =
          map->inverse[pixel_index(theta, *nearest, map->size)];
    }
  }
}

}  // namespace

InverseDistanceMap flow_map(const Room& room, StationIndex station, double reach_m,
                            PanoramaSize map_size, const GainFields& gains) {
  const Line& line = room.grid().lines[static_cast<size_t>(station.line)];
  const FlowImages images(room, map_size, gains);
  const std::vector<Neighbour> neighbours = follow(images, line, station, reach_m, map_size);
  const size_t pixels = static_cast<size_t>(map_size.width) * static_cast<size_t>(map_size.height);
  InverseDistanceMap map{station, line.stations[static_cast<size_t>(station.station)].position_m,
                         map_size, std::vector<float>(pixels, 0.0f),
                         std::vector<std::uint8_t>(pixels, 0)};
  const double least_weight = std::pow(reach_m / kMaxErrorShare, 2);
  parallel_for(0, map_size.width, 16, [&](int begin, int end) {
    std::vector<Sighting> sightings(neighbours.size());
    for (int theta = begin; theta < end; ++theta) {
      for (int phi = 0; phi < map_size.height; ++phi) {
        const Eigen::Vector3d u =
            direction_from_angles(angles_from_pixel({double(theta), double(phi)}, map_size));
        for (size_t i = 0; i < neighbours.size(); ++i)
          sightings[i] = neighbours[i].at(theta, phi, u);
        const Sighting seen = combine(sightings);
        if (seen.weight < least_weight) continue;
        const size_t pixel = pixel_index(theta, phi, map_size);
        map.inverse[pixel] = seen.inverse;
        // 1 minus the error of inverse relative to the largest valid one.
        const double precise = 1.0 - std::sqrt(least_weight / seen.weight);
        map.confidence[pixel] =
            static_cast<std::uint8_t>(std::clamp(255.0 * seen.agrees * precise, 1.0, 255.0));
      }
    }
  });
  fill_unknown(&map);
  return map;
}

}  // namespace raywalk::build_lf
