// Pass 1: the distance along every ray of a view, gathered from the distance maps around it.
//
// Every point of the few maps nearest to the viewpoint is drawn into the pixel of the view that
// sees it, the nearest surface of all staying; cracks between the points are closed (3 x 3). A
// drawn point is up to half a pixel away from the pixel's centre, so the maps are then read where
// the centre's ray meets them: w <- held(r + w (P - S)) |r + w (P - S)|, one step of a fixed point,
// from the nearest map that agrees.
//
// Pixels that no map sees with sufficient confidence (kMinConfidence) take the farther of the
// surfaces above and below, because a near object occludes the background. Where most of the maps'
// pixels are unreliable, all take a smooth distance (smooth_distances.h). A view without any
// confident pixel equals the initial view.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry/eye_circle.h"
#include "core/view/column_geometry.h"
#include "core/view/map_cache.h"
#include "core/view/map_choice.h"
#include "core/view/map_lookup.h"
#include "core/view/smooth_distances.h"

namespace raywalk {

class DistanceView {
 public:
  // The room must outlive the object.
  explicit DistanceView(const Room& room) : room_(room), trusts_(room), cache_(room) {}
  DistanceView(const DistanceView&) = delete;
  DistanceView& operator=(const DistanceView&) = delete;

  // The distances of a view from one place. `maps` (nearest first, at least one) are gathered in
  // parallel. Reusing an object for the next viewpoint reuses its memory, and maps that it has read
  // before.
  void compute(std::span<const MapStation> maps, const Eigen::Vector3d& viewpoint_m);

  // The same in two steps, between which all is known but the distances: a graphics card may gather
  // these instead (core/view/gpu).
  void begin(std::span<const MapStation> maps, const EyeCircle& circle);
  void gather();
  // The first step of a view with two eyes, `left` on `circle`, `right` on its opposite. Each needs
  // the other for what lies behind its columns' eyes and must outlive it.
  static void begin_stereo(std::span<const MapStation> maps, const EyeCircle& circle,
                           DistanceView* left, DistanceView* right);
  // The maps that distances are gathered from, nearest first.
  std::span<const MapStation> maps() const { return stations_; }
  // Whether any of them is unreliable, somewhere.
  bool unreliable() const { return unreliable_; }
  // Where distances can be relied on, and smooth ones, from what is `seen` ([theta][phi], negative
  // where no map sees a surface) and from what the nearest map alone shows.
  const SmoothDistances& find_smooth(std::vector<float> seen, std::span<const float> nearest);

  // Size of the largest map.
  PanoramaSize size() const { return size_; }
  const EyeCircle& eye() const { return eye_; }
  const Latitudes& latitudes() const { return latitudes_; }
  // Inverse distances, 1/m, of a column's rows, top to bottom; all finite and >= 0.
  const float* column(int theta) const { return inverse_.data() + first(theta); }
  // Those of the other half of the great circle around the column's eye. On a circle of eyes it is
  // the opposite column of the other eye, which is at the same place there.
  const float* opposite_column(int theta) const {
    return opposite_->column((theta + size_.width / 2) % size_.width);
  }
  // How far the distances of a column can be relied on, 0 to 1 for each row; null where all are 1.
  const float* trust(int theta) const { return unreliable_ ? smooth_.trust(theta) : nullptr; }
  // surface_tolerance_of() the view.
  float surface_tolerance() const { return tolerance_; }
  // Share of pixels that no map saw.
  double unseen_share() const { return unseen_share_; }
  // The maps of the view, nearest first, to look a column up in that is seen from `eye_m`.
  std::vector<ColumnLookup> lookups(double theta_rad) const;

 private:
  std::size_t first(int theta) const {
    return static_cast<std::size_t>(theta) * static_cast<std::size_t>(size_.height);
  }
  void close_and_refine(int begin, int end);

  const Room& room_;
  EyeCircle eye_;
  const DistanceView* opposite_ = nullptr;  // the view of the other eye; from one place this one
  PanoramaSize size_;
  float tolerance_ = 0.0f;
  double unseen_share_ = 0.0;
  Latitudes latitudes_;         // of size_.height rows
  std::vector<float> inverse_;  // [theta][phi]; negative while unseen
  std::vector<float> drawn_;    // [map][theta][phi]; negative where a map sees nothing
  bool unreliable_ = false;     // smooth_ then knows where
  SmoothDistances smooth_;
  MapCache<MapTrust> trusts_;
  MapCache<SurfaceMap> cache_;
  std::vector<MapStation> stations_;                     // of the view's maps, nearest first
  std::vector<std::shared_ptr<const MapTrust>> trust_;   // of these
  std::vector<std::shared_ptr<const SurfaceMap>> maps_;  // the same, for gather()
};

}  // namespace raywalk
