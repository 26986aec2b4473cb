// The distance along every ray of a view, gathered from the distance maps around it.
//
// The few maps nearest to the viewpoint are projected into the view, each point into the column
// whose eye sees it (core/geometry/eye_circle.h); where several see a surface, the nearest surface
// wins, and among maps that agree on it the nearest map. Pixels that no map sees with sufficient
// confidence (kMinConfidence) take the farther of their neighbours along the great circle around
// the column's eye, because a near object hides background, and then the median of their row around
// them, so that a wrong neighbour is not drawn as a streak. Where most of the maps' pixels are of
// low confidence, all take a smooth distance (smooth_distances.h). A view without any confident
// pixel equals the initial view.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry/eye_circle.h"
#include "core/room/room.h"
#include "core/view/kept_maps.h"
#include "core/view/map_choice.h"
#include "core/view/row_table.h"
#include "core/view/smooth_distances.h"
#include "core/view/view_plan.h"

namespace raywalk {

// DistanceView::surface_tolerance() of distances `width` pixels wide.
float surface_tolerance_of_view(int width);

class DistanceView {
 public:
  // The room must outlive the object.
  explicit DistanceView(const Room& room) : kept_(room) {}
  DistanceView(const DistanceView&) = delete;
  DistanceView& operator=(const DistanceView&) = delete;

  // The distances of a view from one place. `maps` (nearest first, at least one) are gathered in
  // parallel. Reusing an object for the next viewpoint reuses its memory, and maps that it has read
  // before.
  void compute(std::span<const MapStation> maps, const Eigen::Vector3d& viewpoint_m);
  // Those of a view with two eyes, `left` on `circle`, `right` on its opposite. Each needs the
  // other for what lies behind its columns' eyes and must outlive it.
  static void compute_stereo(std::span<const MapStation> maps, const EyeCircle& circle,
                             DistanceView* left, DistanceView* right);

  // Size of the largest map.
  PanoramaSize size() const { return size_; }
  // Inverse distances, 1/m, of a column's rows, top to bottom; all finite and >= 0.
  const float* column(int theta) const {
    return omega_.data() + static_cast<size_t>(theta) * static_cast<size_t>(size_.height);
  }
  // Those of the other half of the great circle around the column's eye. On a circle of eyes it is
  // the opposite column of the other eye, which is at the same place there.
  const float* opposite_column(int theta) const {
    return opposite_->column((theta + size_.width / 2) % size_.width);
  }
  // How far the distances of a column can be relied on, 0 to 1 for each row; null where all are 1.
  const float* trust(int theta) const {
    if (doubted_.empty() || doubted_[static_cast<size_t>(theta)] == 0) return nullptr;
    return trust_.data() + static_cast<size_t>(theta) * static_cast<size_t>(size_.height);
  }
  // Neighbouring pixels are on one surface where their inverse distances differ by no more than
  // this, relative to the larger: the change across one pixel of a plane seen at 80 deg incidence.
  float surface_tolerance() const { return tolerance_; }
  // Share of pixels that no map saw.
  double unseen_share() const { return unseen_share_; }

 private:
  std::vector<std::shared_ptr<const KeptMap>> read(std::span<const MapStation> maps);
  // What the eyes of a circle see of maps_, which are those of `maps`.
  void gather(std::span<const MapStation> maps, const EyeCircle& circle);
  // Fills what none of the maps saw in the first `columns` columns, and in their opposite ones.
  void fill(DistanceView* opposite, int columns);
  // After filling.
  void smooth();
  void project_map(const KeptMap& map, const Eigen::Vector3d& offset_m, float* omega) const;
  int merge_column(std::span<const MapStation> maps, int theta);
  void refine_column(std::span<const MapStation> maps, int theta,
                     std::span<const std::int32_t> source);
  // Of the great circle down column `theta` and up the opposite one.
  void fill_unseen(int theta, DistanceView* opposite);
  void smooth_filled(int theta);
  // Whether any map is doubted; smooth_ then knows where.
  bool find_trust(std::span<const MapStation> maps);
  void smooth_doubted();

  EyeCircle eye_;
  const DistanceView* opposite_ = nullptr;  // the view of the other eye; from one place this one
  PanoramaSize size_;
  float tolerance_ = 0.0f;
  double unseen_share_ = 0.0;
  std::unique_ptr<LatitudeTable> latitudes_;  // of size_.height rows
  int latitudes_rows_ = 0;
  std::vector<float> omega_;             // [theta][phi]; negative while unseen
  std::vector<std::uint8_t> is_unseen_;  // [theta][phi]
  std::vector<int> unseen_;              // pixels of each column
  bool is_doubted_ = false;
  std::vector<float> filled_;     // omega_ before its unseen pixels are smoothed
  std::vector<float> projected_;  // [map][theta][phi]; negative where a map sees nothing
  SmoothDistances smooth_;
  std::vector<float> trust_;           // [theta][phi]; of doubted columns
  std::vector<std::uint8_t> doubted_;  // [theta]; empty where nothing is doubted
  KeptMaps kept_;
  std::vector<std::shared_ptr<const KeptMap>> maps_;  // of the view
};

}  // namespace raywalk
