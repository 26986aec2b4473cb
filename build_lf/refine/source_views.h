// What the captured stations see, so that a point is looked up only in photographs that show it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <list>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry/grid.h"
#include "core/room/room.h"
#include "core/view/distance_view.h"

namespace raywalk::build_lf {

// A point seen from a station, to be compared with what the station sees there.
struct SeenThere {
  // Its place in the station's panorama, pixels of its distances: u from -0.5 to below width - 0.5,
  // v from -0.5 to height - 0.5.
  float u = 0.0f, v = 0.0f;
  float inverse = 0.0f;  // 1/m, from the station
  float slack = 0.0f;    // 1/m: half a pixel of parallax between the two places
};

// A captured station and the surfaces around it.
class SourceView {
 public:
  SourceView(const Room& room, StationIndex station, DistanceView* distances);

  StationIndex station() const { return station_; }
  const Eigen::Vector3d& position_m() const { return position_m_; }
  PanoramaSize size() const { return size_; }
  // Inverse distances, 1/m, [theta][phi].
  std::span<const float> inverse() const { return inverse_; }
  std::size_t bytes() const { return inverse_.size() * sizeof(float); }
  // Whether the station sees a point: none of the four pixels around it holds anything nearer, and
  // the nearest of them holds nothing farther, as that says that the point is not there.
  bool sees(const SeenThere& point) const;

 private:
  float at(int u, int v) const {
    return inverse_[static_cast<std::size_t>(u) * static_cast<std::size_t>(size_.height) +
                    static_cast<std::size_t>(v)];
  }

  StationIndex station_;
  Eigen::Vector3d position_m_;
  PanoramaSize size_;
  float tolerance_ = 0.0f;      // relative, of inverse distances on one surface
  std::vector<float> inverse_;  // [theta][phi], 1/m
};

// Makes them and keeps those used last: neighbouring stations are made from the same ones.
class SourceViews {
 public:
  // The room must outlive the object.
  explicit SourceViews(const Room& room) : room_(room), distances_(room) {}

  std::shared_ptr<const SourceView> of(StationIndex station);

 private:
  static constexpr std::size_t kKeptBytes = std::size_t{512} << 20;

  const Room& room_;
  DistanceView distances_;
  std::list<std::shared_ptr<const SourceView>> kept_;  // used last, first
};

}  // namespace raywalk::build_lf
