#include "calibrate/stitch/masked_halves.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace raywalk::calibrate {
namespace {

// 255 where a sample reads only valid pixels; 0 elsewhere, also where the lens is not sampled.
cv::Mat valid_samples(const cv::Mat& mask, const LensSamples& lens, PanoramaSize size) {
  constexpr int kBorder = kFisheyeBorder;
  cv::Mat bordered, least;
  cv::copyMakeBorder(mask, bordered, kBorder, kBorder, kBorder, kBorder, cv::BORDER_REPLICATE);
  // Cubic interpolation between pixels 0 and 1 reads pixels -1 to 2.
  cv::erode(bordered, least, cv::Mat::ones(4, 4, CV_8UC1), {1, 1});
  cv::Mat valid(size.height, size.width, CV_8UC1, cv::Scalar(0));
  for (const SampleRun& run : lens.runs) {
    auto* row = valid.ptr<uchar>(run.row) + run.column;
    for (int i = 0; i < run.count; ++i) {
      const FisheyeSample& sample = lens.samples[run.first + static_cast<std::size_t>(i)];
      const int u = static_cast<int>(std::floor(sample.u)) + kBorder;
      const int v = static_cast<int>(std::floor(sample.v)) + kBorder;
      row[i] = least.at<uchar>(v, u) != 0 ? 255 : 0;
    }
  }
  return valid;
}

}  // namespace

cv::Mat join_masked_halves(const StitchTables& tables, const cv::Mat& mask, cv::Mat* front,
                           cv::Mat* back) {
  const cv::Mat in_front = valid_samples(mask, tables.front, tables.size);
  const cv::Mat in_back = valid_samples(mask, tables.back, tables.size);
  const cv::Mat both = tables.region == kBothLenses;
  back->copyTo(*front, both & ~in_front & in_back);
  // Equal halves are blended to themselves, so that nothing of a masked pixel reaches others.
  front->copyTo(*back, both & ~in_back);
  return in_front | in_back;
}

}  // namespace raywalk::calibrate
