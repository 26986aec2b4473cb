#include "calibrate/stitch/seam_blend.h"

#include <algorithm>
#include <cmath>
#include <opencv2/stitching/detail/blenders.hpp>
#include <utility>
#include <vector>

#include "core/panorama/panorama_sampler.h"

namespace raywalk::calibrate {
namespace {

constexpr int kMostBands = 6;
constexpr int kSmallestTile_px = 128;

// The coarsest band changes over 2^bands pixels.
int bands_for(double blend_px) {
  return std::clamp(static_cast<int>(std::log2(std::max(blend_px, 1.0))), 1, kMostBands);
}

// Blends a tile whose coarsest band reads `reach_px` beyond it. Away from the seam both pictures
// passed to the blender are the same, so it returns them unchanged.
cv::Mat blended_tile(const StitchTables& tables, int bands, int reach_px, const cv::Rect& tile,
                     const cv::Mat& front, const cv::Mat& back) {
  const cv::Size size(tile.width + 2 * reach_px, tile.height + 2 * reach_px);
  cv::Mat pictures[2] = {cv::Mat(size, CV_16SC3), cv::Mat(size, CV_16SC3)};
  cv::Mat masks[2] = {cv::Mat(size, CV_8UC1), cv::Mat(size, CV_8UC1)};
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const cv::Point at =
          wrapped_pixel(tile.x - reach_px + u, tile.y - reach_px + v, tables.region.size());
      const unsigned char region = tables.region.at<unsigned char>(at);
      pictures[0].at<cv::Vec3s>(v, u) = (region == kBackOnly ? back : front).at<cv::Vec3s>(at);
      pictures[1].at<cv::Vec3s>(v, u) = (region == kFrontOnly ? front : back).at<cv::Vec3s>(at);
      const bool in_front = tables.front_weight.at<float>(at) >= 0.5F;
      masks[0].at<unsigned char>(v, u) = in_front ? 255 : 0;
      masks[1].at<unsigned char>(v, u) = in_front ? 0 : 255;
    }
  }
  cv::detail::MultiBandBlender blender(false, bands, CV_32F);
  blender.prepare(cv::Rect({0, 0}, size));
  for (int lens = 0; lens < 2; ++lens) blender.feed(pictures[lens], masks[lens], {0, 0});
  cv::Mat blended, mask;
  blender.blend(blended, mask);
  return blended(cv::Rect(reach_px, reach_px, tile.width, tile.height));
}

void blend_bands(const StitchTables& tables, double blend_deg, const cv::Mat& back,
                 cv::Mat* front) {
  const cv::Mat& region = tables.region;
  const int bands = bands_for(blend_deg / 360.0 * tables.size.width);
  const int reach_px = 2 << bands;
  const int side = std::max(kSmallestTile_px, 4 * reach_px);
  const cv::Rect whole({0, 0}, region.size());
  // Tiles read beyond their borders, so none is written before all have been read.
  std::vector<std::pair<cv::Rect, cv::Mat>> blended;
  for (int v = 0; v < region.rows; v += side) {
    for (int u = 0; u < region.cols; u += side) {
      const cv::Rect tile = cv::Rect(u, v, side, side) & whole;
      const cv::Mat both = region(tile) == kBothLenses;
      if (cv::countNonZero(both) == 0) continue;
      blended.emplace_back(tile, blended_tile(tables, bands, reach_px, tile, *front, back));
    }
  }
  for (const auto& [tile, levels] : blended) {
    levels.copyTo((*front)(tile), region(tile) == kBothLenses);
  }
}

void feather(const StitchTables& tables, const cv::Mat& back, cv::Mat* front) {
  for (int v = 0; v < front->rows; ++v) {
    const auto* region = tables.region.ptr<unsigned char>(v);
    const auto* weight = tables.front_weight.ptr<float>(v);
    auto* levels = front->ptr<cv::Vec3s>(v);
    const auto* back_levels = back.ptr<cv::Vec3s>(v);
    for (int u = 0; u < front->cols; ++u) {
      if (region[u] != kBothLenses) continue;
      levels[u] = weight[u] * levels[u] + (1.0F - weight[u]) * back_levels[u];
    }
  }
}

}  // namespace

void blend_seam(const StitchTables& tables, const StitcherOptions& options, const cv::Mat& back,
                cv::Mat* front) {
  back.copyTo(*front, tables.region == kBackOnly);
  if (options.blend == BlendMethod::kFeather) {
    feather(tables, back, front);
  } else {
    blend_bands(tables, options.blend_deg, back, front);
  }
}

}  // namespace raywalk::calibrate
