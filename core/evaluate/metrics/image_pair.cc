#include "core/evaluate/metrics/image_pair.h"

#include <algorithm>
#include <string>

#include "core/base/error.h"

namespace raywalk {
namespace {

std::string size_text(const cv::Mat& image) {
  return std::to_string(image.cols) + "x" + std::to_string(image.rows);
}

}  // namespace

void require_image_pair(const cv::Mat& a, const cv::Mat& b, int min_side) {
  for (const cv::Mat* image : {&a, &b}) {
    if (image->dims != 2 || image->empty()) {
      throw Error("cannot compare images: one of them is empty; give two 8-bit colour images");
    }
    if (image->type() != CV_8UC3) {
      throw Error("cannot compare images: type is " + cv::typeToString(image->type()) +
                  "; give 8-bit colour images with 3 channels");
    }
  }
  if (a.size() != b.size()) {
    throw Error("cannot compare images of different sizes, " + size_text(a) + " and " +
                size_text(b) + "; give both at the same size");
  }
  if (std::min(a.cols, a.rows) < min_side) {
    throw Error("cannot compare images of " + size_text(a) + "; this metric needs at least " +
                std::to_string(min_side) + "x" + std::to_string(min_side));
  }
}

}  // namespace raywalk
