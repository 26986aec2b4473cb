#include "core/view/flat_view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"
#include "core/geometry/fast_math.h"
#include "core/view/vector_clones.h"

namespace raywalk {
namespace {

// A row of a picture: the ray of its first pixel in world axes, the step to the next one, and what
// turns angles into positions in the part that is rendered.
struct FlatRow {
  Eigen::Vector3f ray, step;
  float px_per_rad;
  float middle_u, middle_v;  // of longitude and latitude 0
  float width;               // of the panorama
};

RAYWALK_VECTOR_CLONES void find_positions(FlatRow row, int columns, float* u, float* v) {
  const float x0 = row.ray.x(), y0 = row.ray.y(), z0 = row.ray.z();
  const float dx = row.step.x(), dy = row.step.y(), dz = row.step.z();
  RAYWALK_INDEPENDENT
  for (int i = 0; i < columns; ++i) {
    const auto at = static_cast<float>(i);
    const float x = x0 + at * dx, y = y0 + at * dy, z = z0 + at * dz;
    const float column = row.middle_u + fast_atan2(x, z) * row.px_per_rad;
    // The part has more columns on either side than the picture shows.
    u[i] = column + (column < -0.5f ? row.width : 0.0f);
    v[i] = row.middle_v - fast_atan2(y, std::sqrt(x * x + z * z)) * row.px_per_rad;
  }
}

}  // namespace

int flat_supersampling(const Viewport& viewport, PanoramaSize panorama) {
  const double coarser = panorama.width / (kTwoPi * focal_length_px(viewport));
  const int most = kMaxViewport_px / std::max(viewport.width, viewport.height);
  return std::max(1, std::min(most, static_cast<int>(std::lround(coarser))));
}

FlatRays flat_rays(const Viewport& viewport) {
  const Eigen::Matrix3d turn = world_from_camera(viewport.attitude);
  const double focal_px = focal_length_px(viewport);
  const Eigen::Vector3d first((0.5 - 0.5 * viewport.width) / focal_px,
                              (0.5 * viewport.height - 0.5) / focal_px, 1.0);
  return {turn * first, turn.col(0) / focal_px, -turn.col(1) / focal_px};
}

void resample_flat(const cv::Mat& rendered, const PanoramaPart& part, PanoramaSize panorama,
                   const Viewport& viewport, Interpolation interpolation, cv::Mat* image) {
  // All columns continue around the seam; rows repeat at the poles.
  const bool whole = part.columns == panorama.width;
  const int margin = whole ? 3 : 0;
  cv::Mat around = rendered;
  if (whole) cv::copyMakeBorder(rendered, around, 0, 0, margin, margin, cv::BORDER_WRAP);
  image->create(viewport.height, viewport.width, CV_8UC3);
  const FlatRays rays = flat_rays(viewport);
  const int method = interpolation == Interpolation::kCubic ? cv::INTER_CUBIC : cv::INTER_LINEAR;
  constexpr int kRows = 16;  // at once
  parallel_for(0, viewport.height, kRows, [&](int begin, int end) {
    cv::Mat1f u(end - begin, viewport.width), v(end - begin, viewport.width);
    for (int y = begin; y < end; ++y) {
      const FlatRow row{
          .ray = (rays.first + y * rays.down).cast<float>(),
          .step = rays.right.cast<float>(),
          .px_per_rad = static_cast<float>(panorama.width / kTwoPi),
          .middle_u = static_cast<float>(0.5 * panorama.width - 0.5 - part.first_column),
          .middle_v = static_cast<float>(0.5 * panorama.height - 0.5 - part.rows.begin),
          .width = static_cast<float>(panorama.width)};
      find_positions(row, viewport.width, u[y - begin], v[y - begin]);
    }
    u += margin;
    cv::remap(around, image->rowRange(begin, end), u, v, method, cv::BORDER_REPLICATE);
  });
}

}  // namespace raywalk
