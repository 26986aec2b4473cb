#include "core/view/picture_fill.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

// The connected unread pixels, as the boxes around them.
std::vector<cv::Rect> patches_of(const cv::Mat1b& unread) {
  cv::Mat1i labels, stats;
  cv::Mat centroids;
  const int count = cv::connectedComponentsWithStats(unread, labels, stats, centroids, 8, CV_32S);
  std::vector<cv::Rect> patches;
  for (int i = 1; i < count; ++i) {  // 0 is what was read
    patches.emplace_back(stats(i, cv::CC_STAT_LEFT), stats(i, cv::CC_STAT_TOP),
                         stats(i, cv::CC_STAT_WIDTH), stats(i, cv::CC_STAT_HEIGHT));
  }
  return patches;
}

// The widths of pixels relative to their heights.
std::vector<float> column_widths(cv::Range rows, ShownRows shown) {
  std::vector<float> widths;
  for (int row = rows.start; row < rows.end; ++row) {
    const SphereAngles angles = angles_from_pixel(
        {0.0, double(shown.first + row)}, {2 * shown.panorama_height, shown.panorama_height});
    widths.push_back(static_cast<float>(std::cos(angles.phi_rad)));
  }
  return widths;
}

// A picture turned so that column `first` comes first.
cv::Mat turned(const cv::Mat& picture, int first) {
  cv::Mat result;
  cv::hconcat(picture.colRange(first, picture.cols), picture.colRange(0, first), result);
  return result;
}

// Other patches are not read, so that their order does not matter.
void fill_patches(const cv::Mat1b& unread, Seam seam, ShownRows shown, cv::Mat* picture) {
  constexpr int kLeast = 8;
  const cv::Mat before = picture->clone();
  for (const cv::Rect& patch : patches_of(unread)) {
    const int margin = std::max({kLeast, patch.width, patch.height});
    const cv::Rect around = cv::Rect(patch.x - margin, patch.y - margin, patch.width + 2 * margin,
                                     patch.height + 2 * margin) &
                            cv::Rect(0, 0, picture->cols, picture->rows);
    cv::Mat values, weights;
    before(around).convertTo(values, CV_32F);
    cv::Mat(unread(around) == 0).convertTo(weights, CV_32F, 1.0 / 255.0);
    const bool whole = around.width == picture->cols;
    if (!fill_unknown(values, weights, whole ? seam : Seam::kOpen,
                      column_widths({around.y, around.br().y}, shown))) {
      continue;
    }
    cv::Mat filled;
    values(patch - around.tl()).convertTo(filled, CV_8U);
    filled.copyTo((*picture)(patch), unread(patch));
  }
}

}  // namespace

void fill_picture(const cv::Mat1b& unread, Seam seam, ShownRows rows, cv::Mat* picture) {
  cv::Mat1b columns;
  cv::reduce(unread, columns, 0, cv::REDUCE_MAX);
  // No patch crosses the seam of a picture that begins with a column of which all was read. Where
  // every column holds something unread, patches may meet at the seam and are filled apart.
  const auto known = std::find(columns.begin(), columns.end(), std::uint8_t{0});
  const auto first = static_cast<int>(known - columns.begin());
  if (seam == Seam::kOpen || first == 0 || first == picture->cols) {
    fill_patches(unread, seam, rows, picture);
    return;
  }
  cv::Mat turned_picture = turned(*picture, first);
  fill_patches(turned(unread, first), seam, rows, &turned_picture);
  turned(turned_picture, picture->cols - first).copyTo(*picture);
}

bool is_unread_at_border(const cv::Mat1b& unread, Seam seam, ShownRows rows, int size_px) {
  return std::ranges::any_of(patches_of(unread), [&](const cv::Rect& patch) {
    const bool at_side = seam == Seam::kOpen && (patch.x == 0 || patch.br().x == unread.cols);
    const bool at_top = patch.y == 0 && rows.first > 0;
    const bool at_bottom =
        patch.br().y == unread.rows && rows.first + unread.rows < rows.panorama_height;
    return (at_side || at_top || at_bottom) && std::max(patch.width, patch.height) >= size_px;
  });
}

}  // namespace raywalk
