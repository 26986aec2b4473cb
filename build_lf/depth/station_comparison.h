// One station's picture compared with what other stations say about surfaces and their colours.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "build_lf/depth/contradictions.h"
#include "build_lf/depth/pixel_directions.h"
#include "build_lf/depth/station_colours.h"

namespace raywalk::build_lf {

// What a station tells about colours and surfaces, all of one size, [theta][phi], without gaps
// between the columns.
struct StationEvidence {
  StationIndex station;
  Eigen::Vector3d position_m{0, 0, 0};
  std::vector<float> omega;  // inverse distances, 1/m; negative: not known. Empty: no map
  cv::Mat colour;            // CV_8UC3 after the gains
  cv::Mat least, most;       // of the pixels around; 0 and 255 where dark or clipped
  cv::Mat valid;             // CV_8UC1, 0 = masked; empty: all valid

  // Of a pixel by its index (pixel_index).
  bool shows(std::size_t pixel) const { return valid.empty() || valid.ptr<uchar>()[pixel] != 0; }
  const cv::Vec3b& colour_of(std::size_t pixel) const { return colour.ptr<cv::Vec3b>()[pixel]; }
  ColourRange range(std::size_t pixel) const {
    return {least.ptr<cv::Vec3b>()[pixel], most.ptr<cv::Vec3b>()[pixel]};
  }
};

// Evidence without a map. `size` is that of the panoramas or smaller.
StationEvidence evidence_without_map(const Room& room, StationIndex station, PanoramaSize size,
                                     const GainField& gains);

// The stations with maps, made on demand; the least recently used are dropped. Can be used by
// several threads at once.
class EvidenceCache {
 public:
  // The arguments must outlive the cache.
  EvidenceCache(const Room& room, const DepthPlan& plan, PanoramaSize size,
                const std::vector<std::vector<GainField>>& gains, const FinalMap& final_map);
  // Of plan.maps[which].
  std::shared_ptr<const StationEvidence> get(int which);
  PanoramaSize size() const { return size_; }

 private:
  const Room& room_;
  const DepthPlan& plan_;
  PanoramaSize size_;
  const std::vector<std::vector<GainField>>& gains_;
  const FinalMap& final_map_;
  std::mutex mutex_;
  std::list<std::pair<int, std::shared_ptr<const StationEvidence>>> kept_;  // latest first
};

// Stations to compare one with.
inline constexpr std::size_t kMostNeighbours = 12;

// A pixel is contradicted where neighbours agree on a surface and its colour, but the station shows
// another colour than on any of their surfaces (contradictions.h).
class StationComparison {
 public:
  // `own` must outlive the object; the neighbours, at most kMostNeighbours, have maps. All evidence
  // is of `size`. Inverse distances that differ by `tolerance_per_m`, 1/m, are one surface.
  StationComparison(const StationEvidence& own,
                    std::vector<std::shared_ptr<const StationEvidence>> neighbours,
                    PanoramaSize size, float tolerance_per_m);

  // CV_32FC1, [theta][phi]: grey levels by which each pixel lies outside what the others show; 0
  // also where what is contradicted is no wider than two pixels.
  cv::Mat gaps() const;

  // The inverse distance, 1/m, of the nearest surface that enough others agree on at a pixel;
  // negative: they do not tell, or the pixel is masked.
  float surface_behind(int theta, int phi) const;

  // Beyond what noise explains.
  GapLimits limits() const;

 private:
  using Colours = std::array<std::uint8_t, kMostNeighbours>;

  // Neighbours that see one surface: their colours.
  struct Witnesses {
    int count = 0;
    std::array<Colours, 3> colour{};
    std::array<ColourRange, kMostNeighbours> range;
  };

  // Each neighbour's confident surfaces as they are seen from here, the nearest one per pixel.
  void project_surfaces();
  float tolerance_at(float omega) const { return tolerance_ + slant_ * omega; }

  // Inverse distances.
  class Surfaces {
   public:
    void add(float omega) { omega_[count_++] = omega; }
    void sort_nearest_first() { std::sort(begin(), end(), std::greater()); }
    float* begin() { return omega_.data(); }
    float* end() { return omega_.data() + count_; }

   private:
    std::array<float, kMostNeighbours + 1> omega_{};
    size_t count_ = 0;
  };

  // The surfaces that at least two neighbours see in a direction, nearest first, and the station's
  // own distance.
  Surfaces hypotheses(size_t pixel) const;
  // With `by_maps` only those whose maps agree.
  Witnesses witnesses_of(const Eigen::Vector3f& direction, float omega, bool by_maps) const;
  static cv::Vec3b median_of(const Witnesses& witnesses);

  // How far the station's colour is outside what those show who see the surface; none if they are
  // too few or disagree.
  std::optional<float> gap_from(const Witnesses& witnesses, const ColourRange& own) const;

  // Whether most others show the same colour where the station's own distance says, though their
  // maps miss the surface: a thin or shining thing, but none that moved.
  bool shown_by_others(const Eigen::Vector3f& direction, float omega, const ColourRange& own) const;

  // Grey levels by which a pixel lies outside what the others show of every surface they see there.
  float gap(int theta, int phi) const;

  // The median difference between the station's colours and those of the others, grey levels.
  float measure_noise() const;

  const StationEvidence& own_;
  std::vector<std::shared_ptr<const StationEvidence>> neighbours_;
  PanoramaSize size_;
  PixelDirections directions_;
  float tolerance_;                           // 1/m
  float slant_;                               // share of the inverse distance
  std::vector<Eigen::Vector3f> offsets_;      // from each neighbour to this station, metres
  std::vector<std::vector<float>> surfaces_;  // inverse distances from here; negative: none seen
  float noise_ = 0.0f;                        // grey levels
};

}  // namespace raywalk::build_lf
