// The stations that a reference is compared with, per tile of its map, and their pictures.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/matching_views.h"
#include "build_lf/depth/station_picture.h"

namespace raywalk::build_lf {

struct SweepReference {
  StationIndex station;
  Eigen::Vector3d position_m{0, 0, 0};
  Eigen::Vector3d rail{1, 0, 0};  // unit vector along its line
};

// A station that may be compared with the reference.
struct SweepCandidate {
  StationIndex station;
  Eigen::Vector3d position_m{0, 0, 0};
};

// A station's picture and the vector from it to the reference.
struct TileView {
  std::shared_ptr<const StationPicture> picture;
  Eigen::Vector3d to_reference_m{0, 0, 0};
};

class TileViews {
 public:
  // Chooses the stations of every tile (choose_matching_views) and gets their pictures.
  TileViews(const SweepReference& reference, std::span<const SweepCandidate> candidates,
            double reach_m, PanoramaSize map_size, PictureCache* pictures);

  PanoramaSize map_size() const { return size_; }
  const StationPicture& reference() const { return *reference_; }
  int tiles() const { return across_ * down_; }
  // The first pixel of a tile and how many it has.
  int first_column(int tile) const { return tile % across_ * kTileColumns; }
  int first_row(int tile) const { return tile / across_ * kTileRows; }
  int columns(int tile) const { return std::min(kTileColumns, size_.width - first_column(tile)); }
  int rows(int tile) const { return std::min(kTileRows, size_.height - first_row(tile)); }
  // Indices for view(), per side of the reference.
  const MatchingViews& of_tile(int tile) const { return tiles_[static_cast<size_t>(tile)]; }
  const TileView& view(int index) const { return views_[static_cast<size_t>(index)]; }
  // Whether no picture has an invalid sample.
  bool all_valid() const { return all_valid_; }

 private:
  PanoramaSize size_;
  std::shared_ptr<const StationPicture> reference_;
  int across_ = 0;
  int down_ = 0;
  std::vector<MatchingViews> tiles_;
  std::vector<TileView> views_;  // null picture if no tile uses it
  bool all_valid_ = true;
};

// The reference's pixels of a tile, [theta][phi].
struct ReferenceTile {
  // Unit vectors in world axes.
  std::array<float, kTilePixels> x, y, z;
  // The mean over each pixel's samples; its detail is kInvalidDetail where one of them is invalid.
  std::array<MatchingSample, kTilePixels> samples;
  int count = 0;

  ReferenceRays rays() const { return {x.data(), y.data(), z.data(), samples.data(), count}; }
};
ReferenceTile reference_tile(const TileViews& views, int tile);

}  // namespace raywalk::build_lf
