#include "core/view/flat_view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"

namespace raywalk {
namespace {

// Positions in the panorama are exact at every eighth pixel and linear between them. In 16 degrees
// around a pole, where they are not, every pixel's is exact.
constexpr int kStep = 8;

struct FlatPositions {
  const PanoramaPart& part;
  PanoramaSize panorama;
  const Viewport& viewport;
  Eigen::Matrix3d world_from_camera;
  double focal_px;

  // Of a pixel, in the part; `v` beyond the part's rows is the caller's concern.
  PixelPosition at(double column, double row) const {
    const Eigen::Vector3d ray((column + 0.5 - 0.5 * viewport.width) / focal_px,
                              -(row + 0.5 - 0.5 * viewport.height) / focal_px, 1.0);
    const PixelPosition p =
        pixel_from_angles(angles_from_direction(world_from_camera * ray), panorama);
    const double u = p.u - part.first_column;
    // The part has more columns on either side than the picture shows.
    return {u < -0.5 ? u + panorama.width : u, p.v - part.rows.begin};
  }
  bool is_polar(const PixelPosition& p) const {
    const double from_pole =
        std::min(p.v + part.rows.begin, panorama.height - 1.0 - p.v - part.rows.begin);
    return from_pole < panorama.height * (16.0 / 180.0);
  }
};

// The positions of a block of pixels.
void find_positions(const FlatPositions& positions, int x, int y, cv::Mat1f u, cv::Mat1f v) {
  const double last_x = x + u.cols - 1, last_y = y + u.rows - 1;
  const std::array<PixelPosition, 4> corner{positions.at(x, y), positions.at(last_x, y),
                                            positions.at(x, last_y), positions.at(last_x, last_y)};
  const auto [least, most] = std::ranges::minmax(corner, {}, &PixelPosition::u);
  const bool exact =
      most.u - least.u > positions.panorama.width / 4.0 ||
      std::ranges::any_of(corner, [&](const auto& p) { return positions.is_polar(p); });
  const auto between = [](double a, double b, double part) { return a + (b - a) * part; };
  const double right_part = 1.0 / std::max(u.cols - 1, 1),
               down_part = 1.0 / std::max(u.rows - 1, 1);
  for (int j = 0; j < u.rows; ++j) {
    const double down = j * down_part;
    const PixelPosition left{between(corner[0].u, corner[2].u, down),
                             between(corner[0].v, corner[2].v, down)};
    const PixelPosition step{(between(corner[1].u, corner[3].u, down) - left.u) * right_part,
                             (between(corner[1].v, corner[3].v, down) - left.v) * right_part};
    for (int i = 0; i < u.cols; ++i) {
      const PixelPosition p = exact ? positions.at(x + i, y + j)
                                    : PixelPosition{left.u + i * step.u, left.v + i * step.v};
      u(j, i) = static_cast<float>(p.u);
      v(j, i) = static_cast<float>(p.v);
    }
  }
}

}  // namespace

int flat_supersampling(const Viewport& viewport, PanoramaSize panorama) {
  const double coarser = panorama.width / (kTwoPi * focal_length_px(viewport));
  const int most = kMaxViewport_px / std::max(viewport.width, viewport.height);
  return std::max(1, std::min(most, static_cast<int>(std::lround(coarser))));
}

void resample_flat(const cv::Mat& rendered, const PanoramaPart& part, PanoramaSize panorama,
                   const Viewport& viewport, Interpolation interpolation, cv::Mat* image) {
  // A margin around: all columns continue around the seam, rows repeat at the poles.
  constexpr int kMargin = 3;
  cv::Mat around;
  const bool whole = part.columns == panorama.width;
  cv::copyMakeBorder(rendered, around, 0, 0, kMargin, kMargin,
                     whole ? cv::BORDER_WRAP : cv::BORDER_REPLICATE);
  image->create(viewport.height, viewport.width, CV_8UC3);
  const FlatPositions positions{part, panorama, viewport, world_from_camera(viewport.attitude),
                                focal_length_px(viewport)};
  const int method = interpolation == Interpolation::kCubic ? cv::INTER_CUBIC : cv::INTER_LINEAR;
  parallel_for(0, (viewport.height + kStep - 1) / kStep, 4, [&](int begin, int end) {
    const cv::Range rows(begin * kStep, std::min(end * kStep, viewport.height));
    cv::Mat1f u(rows.size(), viewport.width), v(rows.size(), viewport.width);
    for (int y = 0; y < rows.size(); y += kStep) {
      for (int x = 0; x < viewport.width; x += kStep) {
        const cv::Rect block(x, y, std::min(kStep, viewport.width - x),
                             std::min(kStep, rows.size() - y));
        find_positions(positions, x, rows.start + y, u(block), v(block));
      }
    }
    u += kMargin;
    cv::remap(around, image->rowRange(rows), u, v, method, cv::BORDER_REPLICATE);
  });
}

}  // namespace raywalk
