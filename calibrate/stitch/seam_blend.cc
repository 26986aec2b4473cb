#include "calibrate/stitch/seam_blend.h"

#include <algorithm>
#include <cmath>
#include <opencv2/stitching/detail/blenders.hpp>

#include "core/panorama/panorama_sampler.h"

namespace raywalk::calibrate {
namespace {

constexpr int kMostBands = 6;
constexpr int kSmallestTile_px = 128;

// The coarsest band changes over 2^bands pixels.
int bands_for(double blend_px) {
  return std::clamp(static_cast<int>(std::log2(std::max(blend_px, 1.0))), 1, kMostBands);
}

// The tiles that contain pixels of both lenses.
std::vector<cv::Rect> seam_tiles(const cv::Mat& region, int side) {
  std::vector<cv::Rect> tiles;
  const cv::Rect whole({0, 0}, region.size());
  for (int v = 0; v < region.rows; v += side) {
    for (int u = 0; u < region.cols; u += side) {
      const cv::Rect tile = cv::Rect(u, v, side, side) & whole;
      const cv::Mat both = region(tile) == kBothLenses;
      if (cv::countNonZero(both) > 0) tiles.push_back(tile);
    }
  }
  return tiles;
}

}  // namespace

SeamBlend::SeamBlend(const StitchTables& tables, const StitcherOptions& options)
    : method_(options.blend), region_(tables.region), front_weight_(tables.front_weight) {
  if (method_ != BlendMethod::kMultiBand) return;
  bands_ = bands_for(options.blend_deg / 360.0 * tables.size.width);
  reach_px_ = 2 << bands_;
  tiles_ = seam_tiles(region_, std::max(kSmallestTile_px, 4 * reach_px_));
}

// Away from the seam both pictures passed to the blender are the same, so it returns them
// unchanged, and a tile needs only the border that its coarsest band reads.
cv::Mat SeamBlend::multi_band(const cv::Mat& front, const cv::Mat& back,
                              const cv::Rect& tile) const {
  const cv::Size size(tile.width + 2 * reach_px_, tile.height + 2 * reach_px_);
  cv::Mat pictures[2] = {cv::Mat(size, CV_16SC3), cv::Mat(size, CV_16SC3)};
  cv::Mat masks[2] = {cv::Mat(size, CV_8UC1), cv::Mat(size, CV_8UC1)};
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const cv::Point at =
          wrapped_pixel(tile.x - reach_px_ + u, tile.y - reach_px_ + v, region_.size());
      const unsigned char region = region_.at<unsigned char>(at);
      pictures[0].at<cv::Vec3s>(v, u) = (region == kBackOnly ? back : front).at<cv::Vec3s>(at);
      pictures[1].at<cv::Vec3s>(v, u) = (region == kFrontOnly ? front : back).at<cv::Vec3s>(at);
      const bool in_front = front_weight_.at<float>(at) >= 0.5F;
      masks[0].at<unsigned char>(v, u) = in_front ? 255 : 0;
      masks[1].at<unsigned char>(v, u) = in_front ? 0 : 255;
    }
  }
  cv::detail::MultiBandBlender blender(false, bands_, CV_32F);
  blender.prepare(cv::Rect({0, 0}, size));
  for (int lens = 0; lens < 2; ++lens) blender.feed(pictures[lens], masks[lens], {0, 0});
  cv::Mat blended, mask;
  blender.blend(blended, mask);
  return blended(cv::Rect(reach_px_, reach_px_, tile.width, tile.height));
}

// Tiles read beyond their borders, so none is written before all have been read.
void SeamBlend::blend_bands(cv::Mat* front, const cv::Mat& back) const {
  std::vector<cv::Mat> blended;
  blended.reserve(tiles_.size());
  for (const cv::Rect& tile : tiles_) blended.push_back(multi_band(*front, back, tile));
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    blended[i].copyTo((*front)(tiles_[i]), region_(tiles_[i]) == kBothLenses);
  }
}

void SeamBlend::feather(cv::Mat* front, const cv::Mat& back) const {
  for (int v = 0; v < region_.rows; ++v) {
    const auto* region = region_.ptr<unsigned char>(v);
    const auto* weight = front_weight_.ptr<float>(v);
    auto* levels = front->ptr<cv::Vec3s>(v);
    const auto* back_levels = back.ptr<cv::Vec3s>(v);
    for (int u = 0; u < region_.cols; ++u) {
      if (region[u] != kBothLenses) continue;
      levels[u] = weight[u] * levels[u] + (1.0F - weight[u]) * back_levels[u];
    }
  }
}

void SeamBlend::blend(cv::Mat* front, const cv::Mat& back) const {
  back.copyTo(*front, region_ == kBackOnly);
  if (method_ == BlendMethod::kFeather) {
    feather(front, back);
  } else {
    blend_bands(front, back);
  }
}

}  // namespace raywalk::calibrate
