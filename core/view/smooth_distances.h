// How far the distances of a view can be relied on, and smooth distances for where they cannot.
//
// A distance is doubted where most pixels of the map around it are of low confidence: such maps are
// full of gaps and of single wrong pixels. There the median of what surrounds it is used. Where
// most are confident, a few that are not change nothing.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "core/geometry/eye_circle.h"
#include "core/room/distance_volume.h"
#include "core/view/column_geometry.h"

namespace raywalk {

// Trust in a distance map, varying smoothly over its directions.
class MapTrust {
 public:
  MapTrust(const DistanceVolume& volume, int map);
  std::size_t bytes() const { return cells_.total() * sizeof(float); }
  // Whether the map is trusted in all directions, as exact maps are.
  bool everywhere() const { return everywhere_; }
  // Raises `trust`, from 0 to 1, in rows of a column at inverse distances `inverse` of a view whose
  // eye is `to_eye` from the map's station, to that in the cells that show them.
  void find_most(double theta_rad, const Latitudes& latitudes, Offset to_eye, const float* inverse,
                 float* trust) const;

 private:
  cv::Mat1f cells_;  // of kCell x kCell pixels, [theta][phi]
  bool everywhere_ = false;
};

// A map that a view's distances come from.
struct TrustedMap {
  const MapTrust* trust = nullptr;
  Eigen::Vector3d position_m{0, 0, 0};  // of the map's station
};

// The trusted maps' view from the eyes of a view.
class SmoothDistances {
 public:
  // `inverse`: inverse distances [theta][phi] of a view of `size`, negative where no map sees a
  // surface; `maps` where they come from.
  void compute(std::span<const float> inverse, PanoramaSize size, const EyeCircle& eye,
               std::span<const TrustedMap> maps);

  // Trust in all pixels, and the smooth inverse distances.
  const cv::Mat1f& trust() const { return trust_; }
  const cv::Mat1f& inverse() const { return inverse_; }
  // Trust in the rows of a column, 0 to 1; null where all are 1.
  const float* trust(int theta) const {
    return unreliable_[static_cast<std::size_t>(theta)] == 0 ? nullptr : trust_[theta];
  }
  // Replaces a column's inverse distances (>= 0), the less they are trusted, by smooth ones.
  void smooth(int theta, std::span<float> inverse) const;

 private:
  cv::Mat1f trust_;  // [theta][phi]
  cv::Mat1f inverse_;
  std::vector<std::uint8_t> unreliable_;  // [theta]
};

}  // namespace raywalk
