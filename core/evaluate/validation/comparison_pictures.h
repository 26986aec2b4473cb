// Pictures that show where a rendered view differs from its ground truth, as Fig. 12 of the paper
// does.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace raywalk {

// Factor that makes absolute differences visible: 32 levels become 128.
inline constexpr double kErrorGain = 4.0;

// |view - truth| times kErrorGain per channel, saturating; black where they agree.
cv::Mat error_of(const cv::Mat& view, const cv::Mat& truth);

// At most `width` pixels wide, for a page; averaged down, never enlarged.
cv::Mat shrunk_to(const cv::Mat& image, int width);

// A view beside its truth; all CV_8UC3 in BGR order.
struct ViewComparison {
  cv::Mat view{};
  cv::Mat error{};
};

// The comparison is made at full size and then shrunk.
ViewComparison compare(const cv::Mat& view, const cv::Mat& truth, int width);

}  // namespace raywalk
