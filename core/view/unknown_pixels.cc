#include "core/view/unknown_pixels.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/parallel.h"
#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

// Means of 2 x 2 pixels.
cv::Mat halved(const cv::Mat& picture) {
  cv::Mat even, half;
  cv::copyMakeBorder(picture, even, 0, picture.rows % 2, 0, picture.cols % 2, cv::BORDER_REPLICATE);
  cv::resize(even, half, even.size() / 2, 0, 0, cv::INTER_AREA);
  return half;
}

// With one more pixel on every side.
cv::Mat framed(const cv::Mat& picture, Seam seam) {
  cv::Mat wide, high;
  cv::copyMakeBorder(picture, wide, 0, 0, 1, 1,
                     seam == Seam::kJoined ? cv::BORDER_WRAP : cv::BORDER_REPLICATE);
  cv::copyMakeBorder(wide, high, 1, 1, 0, 0, cv::BORDER_REPLICATE);
  return high;
}

// Interpolates a coarse picture at the pixels of one about twice its size.
cv::Mat doubled(const cv::Mat& coarse, cv::Size size, Seam seam) {
  cv::Mat fine;
  cv::resize(framed(coarse, seam), fine, {}, 2.0, 2.0, cv::INTER_LINEAR);
  return fine(cv::Rect({2, 2}, size));
}

// The share of the neighbours at a pixel's sides in what surrounds it: neighbours count by the
// inverse squares of their distances, and columns are the narrower the nearer the poles.
cv::Mat shares_of_sides(cv::Size size, ShownRows rows) {
  cv::Mat shares(size, CV_32F);
  const PanoramaSize panorama{2 * rows.panorama_height, rows.panorama_height};
  for (int row = 0; row < size.height; ++row) {
    const SphereAngles angles = angles_from_pixel({0.0, double(rows.first + row)}, panorama);
    shares.row(row) = 1.0 / (1.0 + std::pow(std::cos(angles.phi_rad), 2));
  }
  return shares;
}

cv::Mat means_around(const cv::Mat& picture, const cv::Mat& of_sides, Seam seam) {
  const cv::Mat wide = framed(picture, seam);
  const cv::Rect inside({1, 1}, picture.size());
  cv::Mat beside, above;
  cv::filter2D(wide, beside, -1, cv::Matx13f(0.5f, 0.0f, 0.5f));
  cv::filter2D(wide, above, -1, cv::Matx31f(0.5f, 0.0f, 0.5f));
  return above(inside) + (beside(inside) - above(inside)).mul(of_sides);
}

// Fills a picture of one channel; `values` are 0 where `known` is 0, which else is 1.
cv::Mat filled(const cv::Mat& values, const cv::Mat& known, const cv::Mat& of_sides, Seam seam) {
  constexpr int kRelaxations = 4;
  if (values.total() == 1) return values;
  // A coarse pixel is the mean of the known ones of its four, and known if there is one.
  const cv::Mat share = halved(known);
  const cv::Mat divisor = cv::max(share, 0.25);
  const cv::Mat coarse = filled(halved(values) / divisor, share / divisor, halved(of_sides), seam);
  const cv::Mat unknown = 1.0 - known;
  cv::Mat picture = values + doubled(coarse, values.size(), seam).mul(unknown);
  for (int i = 0; i < kRelaxations; ++i) {
    picture = values + means_around(picture, of_sides, seam).mul(unknown);
  }
  return picture;
}

}  // namespace

bool fill_unknown(const cv::Mat1b& unknown, Seam seam, ShownRows rows, cv::Mat* values) {
  const cv::Mat1f known = cv::Mat1f(unknown == 0) / 255.0;
  if (cv::countNonZero(known) == 0) return false;
  const cv::Mat of_sides = shares_of_sides(known.size(), rows);
  std::vector<cv::Mat> channels;
  cv::split(*values, channels);
  parallel_for(0, values->channels(), 1, [&](int begin, int) {
    cv::Mat& channel = channels[static_cast<size_t>(begin)];
    channel.setTo(0.0, unknown);
    channel = filled(channel, known, of_sides, seam);
  });
  cv::merge(channels, *values);
  return true;
}

}  // namespace raywalk
