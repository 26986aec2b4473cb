#include "core/view/picture_fill.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace raywalk {
namespace {

// The boxes around connected unread pixels, but for those within the outline of others.
std::vector<cv::Rect> patches_of(const cv::Mat1b& unread) {
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(unread, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  std::vector<cv::Rect> patches(outlines.size());
  std::ranges::transform(outlines, patches.begin(),
                         [](const auto& outline) { return cv::boundingRect(outline); });
  return patches;
}

// A picture turned so that column `first` comes first; the same one where that is so already.
cv::Mat turned(const cv::Mat& picture, int first) {
  if (first % picture.cols == 0) return picture;
  cv::Mat result;
  cv::hconcat(picture.colRange(first, picture.cols), picture.colRange(0, first), result);
  return result;
}

// Patches are filled apart: each is surrounded by what was read, not by other patches.
void fill_patches(const cv::Mat1b& unread, Seam seam, ShownRows shown, cv::Mat* picture) {
  for (const cv::Rect& patch : patches_of(unread)) {
    // What surrounds a long patch is beside it, as near as it is narrow.
    const int margin = std::min(patch.width, patch.height);
    const cv::Rect wider = patch - cv::Point(margin, margin) + cv::Size(2 * margin, 2 * margin);
    const cv::Rect around = wider & cv::Rect({0, 0}, picture->size());
    const ShownRows rows{shown.first + around.y, shown.panorama_height};
    const Seam sides = around.width == picture->cols ? seam : Seam::kOpen;
    cv::Mat values;
    (*picture)(around).convertTo(values, CV_32F);
    if (!fill_unknown(unread(around), sides, rows, &values)) continue;
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
  const auto read = std::find(columns.begin(), columns.end(), std::uint8_t{0}) - columns.begin();
  const int first = seam == Seam::kJoined ? static_cast<int>(read) : 0;
  cv::Mat filled = turned(*picture, first);
  fill_patches(turned(unread, first), seam, rows, &filled);
  turned(filled, picture->cols - first).copyTo(*picture);
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
