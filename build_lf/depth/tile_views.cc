#include "build_lf/depth/tile_views.h"

#include <algorithm>
#include <cmath>

namespace raywalk::build_lf {
namespace {

// The mean over the samples of a map pixel.
MatchingSample mean_sample(const StationPicture& picture, int theta, int phi) {
  std::array<unsigned, 4> sum{};
  bool valid = true;
  for (int du = 0; du < kSamplesPerPixel; ++du) {
    const MatchingSample* samples = picture.samples.data() +
                                    static_cast<size_t>(theta * kSamplesPerPixel + du) *
                                        static_cast<size_t>(picture.size.height) +
                                    static_cast<size_t>(phi * kSamplesPerPixel);
    for (int dv = 0; dv < kSamplesPerPixel; ++dv) {
      for (int c = 0; c < 4; ++c) {
        sum[static_cast<size_t>(c)] += static_cast<unsigned>(channel_of(samples[dv], c));
      }
      valid = valid && is_valid(samples[dv]);
    }
  }
  constexpr unsigned kSamples = kSamplesPerPixel * kSamplesPerPixel;
  for (unsigned& channel : sum) channel = (channel + kSamples / 2) / kSamples;
  return matching_sample(sum[0], sum[1], sum[2], valid ? sum[3] : kInvalidDetail);
}

}  // namespace

TileViews::TileViews(const SweepReference& reference, std::span<const SweepCandidate> candidates,
                     double reach_m, PanoramaSize map_size, PictureCache* pictures)
    : size_(map_size),
      reference_(pictures->get(reference.station)),
      across_((size_.width + kTileColumns - 1) / kTileColumns),
      down_((size_.height + kTileRows - 1) / kTileRows) {
  std::vector<Eigen::Vector3d> positions_m;
  for (const SweepCandidate& candidate : candidates) positions_m.push_back(candidate.position_m);
  const MatchingGeometry geometry{reference.position_m, reference.rail, reach_m};
  std::vector<char> used(candidates.size(), 0);
  for (int tile = 0; tile < tiles(); ++tile) {
    const PixelPosition middle{first_column(tile) + 0.5 * (columns(tile) - 1),
                               first_row(tile) + 0.5 * (rows(tile) - 1)};
    const Eigen::Vector3d direction = direction_from_angles(angles_from_pixel(middle, size_));
    tiles_.push_back(choose_matching_views(geometry, direction, positions_m));
    for (const auto& side : tiles_.back().side) {
      for (const int i : side) used[static_cast<size_t>(i)] = 1;
    }
  }
  std::vector<StationIndex> compared;
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (used[i] != 0) compared.push_back(candidates[i].station);
  }
  const std::vector<PictureCache::Made> found = pictures->get_all(compared);
  auto next = found.begin();
  views_.resize(candidates.size());
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (used[i] == 0) continue;
    views_[i] = {*next++, reference.position_m - candidates[i].position_m};
    all_valid_ = all_valid_ && views_[i].picture->all_valid;
  }
}

ReferenceTile reference_tile(const TileViews& views, int tile) {
  ReferenceTile reference;
  const StationPicture& picture = views.reference();
  for (int column = 0; column < views.columns(tile); ++column) {
    for (int row = 0; row < views.rows(tile); ++row) {
      const int theta = views.first_column(tile) + column;
      const int phi = views.first_row(tile) + row;
      const Eigen::Vector3d direction =
          direction_from_angles(angles_from_pixel({double(theta), double(phi)}, views.map_size()));
      const auto at = static_cast<size_t>(reference.count++);
      reference.x[at] = static_cast<float>(direction.x());
      reference.y[at] = static_cast<float>(direction.y());
      reference.z[at] = static_cast<float>(direction.z());
      reference.samples[at] = mean_sample(picture, theta, phi);
    }
  }
  return reference;
}

}  // namespace raywalk::build_lf
