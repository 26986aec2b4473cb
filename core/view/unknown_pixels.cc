#include "core/view/unknown_pixels.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#include "core/base/parallel.h"

namespace raywalk {
namespace {

constexpr int kRowsPerTask = 16;

// The picture at one scale.
struct Level {
  cv::Mat values;
  cv::Mat weights;
  std::vector<float> column_widths;  // of the rows
};

// Calls body(row) for all rows of a picture, on several threads.
template <typename Body>
void for_each_row(const cv::Mat& picture, const Body& body) {
  parallel_for(0, picture.rows, kRowsPerTask, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) body(row);
  });
}

// The index of a column beyond the border.
int column_at(int column, int columns, Seam seam) {
  if (seam == Seam::kOpen) return std::clamp(column, 0, columns - 1);
  return column < 0 ? column + columns : (column >= columns ? column - columns : column);
}

// Averages 2 x 2 pixels by weight. A coarse pixel is known as soon as one of its pixels is.
Level coarser(const Level& fine) {
  const int channels = fine.values.channels();
  Level coarse;
  const cv::Size size((fine.values.cols + 1) / 2, (fine.values.rows + 1) / 2);
  coarse.values.create(size, fine.values.type());
  coarse.weights.create(size, CV_32FC1);
  coarse.column_widths.resize(static_cast<size_t>(size.height));
  for_each_row(coarse.values, [&](int row) {
    const int upper = 2 * row;
    const int lower = std::min(upper + 1, fine.values.rows - 1);
    coarse.column_widths[static_cast<size_t>(row)] =
        0.5f * (fine.column_widths[static_cast<size_t>(upper)] +
                fine.column_widths[static_cast<size_t>(lower)]);
    auto* out = coarse.values.ptr<float>(row);
    auto* weight_out = coarse.weights.ptr<float>(row);
    for (int column = 0; column < size.width; ++column, out += channels) {
      float total = 0.0f;
      std::fill_n(out, channels, 0.0f);
      for (int y = upper; y < std::min(upper + 2, fine.values.rows); ++y) {
        for (int x = 2 * column; x < std::min(2 * column + 2, fine.values.cols); ++x) {
          const float weight = fine.weights.at<float>(y, x);
          if (weight <= 0.0f) continue;
          const float* in = fine.values.ptr<float>(y) + channels * x;
          for (int c = 0; c < channels; ++c) out[c] += weight * in[c];
          total += weight;
        }
      }
      for (int c = 0; c < channels && total > 0.0f; ++c) out[c] /= total;
      weight_out[column] = std::min(1.0f, total);
    }
  });
  return coarse;
}

// Interpolates the coarser picture, bilinearly, at the pixels that are not quite known.
void interpolate(const Level& fine, const cv::Mat& coarse, Seam seam, cv::Mat* around) {
  const int channels = coarse.channels();
  for_each_row(fine.values, [&](int row) {
    const float* upper = coarse.ptr<float>(row / 2);
    const int next_row = row % 2 == 0 ? row / 2 - 1 : row / 2 + 1;
    const float* beside = coarse.ptr<float>(std::clamp(next_row, 0, coarse.rows - 1));
    const float* weight = fine.weights.ptr<float>(row);
    auto* out = around->ptr<float>(row);
    for (int column = 0; column < fine.values.cols; ++column, out += channels) {
      if (weight[column] >= 1.0f) continue;
      const int near = channels * (column / 2);
      const int next_column = column % 2 == 0 ? column / 2 - 1 : column / 2 + 1;
      const int far = channels * column_at(next_column, coarse.cols, seam);
      for (int c = 0; c < channels; ++c) {
        out[c] = (9.0f * upper[near + c] + 3.0f * (upper[far + c] + beside[near + c]) +
                  beside[far + c]) /
                 16.0f;
      }
    }
  });
}

// Known pixels and their surroundings, by weight.
void mix(const Level& level, const cv::Mat& around, cv::Mat* mixed) {
  const int channels = around.channels();
  for_each_row(around, [&](int row) {
    const float* weight = level.weights.ptr<float>(row);
    const float* known = level.values.ptr<float>(row);
    const float* unknown = around.ptr<float>(row);
    auto* out = mixed->ptr<float>(row);
    for (int i = 0; i < channels * around.cols; ++i) {
      const float w = weight[i / channels];
      out[i] =
          w >= 1.0f ? known[i] : (w <= 0.0f ? unknown[i] : w * known[i] + (1.0f - w) * unknown[i]);
    }
  });
}

// One step of relaxation: what surrounds a pixel is the mean of its four neighbours, weighted by
// the inverse squares of their distances.
void relax(const Level& level, const cv::Mat& mixed, Seam seam, cv::Mat* around) {
  const int channels = mixed.channels();
  for_each_row(mixed, [&](int row) {
    const float* weight = level.weights.ptr<float>(row);
    const float width = level.column_widths[static_cast<size_t>(row)];
    const float across = 0.5f / (1.0f + width * width);
    const float along = 0.5f - across;
    const float* above = mixed.ptr<float>(std::max(row - 1, 0));
    const float* here = mixed.ptr<float>(row);
    const float* below = mixed.ptr<float>(std::min(row + 1, mixed.rows - 1));
    auto* out = around->ptr<float>(row);
    for (int column = 0; column < mixed.cols; ++column, out += channels) {
      if (weight[column] >= 1.0f) continue;
      const int at = channels * column;
      const int left = channels * column_at(column - 1, mixed.cols, seam);
      const int right = channels * column_at(column + 1, mixed.cols, seam);
      for (int c = 0; c < channels; ++c) {
        out[c] =
            across * (here[left + c] + here[right + c]) + along * (above[at + c] + below[at + c]);
      }
    }
  });
}

// Fills a level from the filled next coarser one.
cv::Mat filled(const Level& level, const cv::Mat& coarse, Seam seam) {
  constexpr int kRelaxations = 4;
  cv::Mat around(level.values.size(), level.values.type());
  cv::Mat mixed(level.values.size(), level.values.type());
  interpolate(level, coarse, seam, &around);
  mix(level, around, &mixed);
  for (int i = 0; i < kRelaxations; ++i) {
    relax(level, mixed, seam, &around);
    mix(level, around, &mixed);
  }
  return mixed;
}

bool all_known(const cv::Mat& weights) {
  double least = 0.0;
  cv::minMaxLoc(weights, &least);
  return least >= 1.0;
}

}  // namespace

bool fill_unknown(cv::Mat& values, const cv::Mat& weights, Seam seam,
                  std::span<const float> column_widths) {
  std::vector<Level> levels(1);
  levels[0].values = values;
  levels[0].weights = weights;
  levels[0].column_widths.assign(column_widths.begin(), column_widths.end());
  if (column_widths.empty()) levels[0].column_widths.assign(static_cast<size_t>(values.rows), 1.0f);
  while (!all_known(levels.back().weights) && levels.back().values.total() > 1) {
    levels.push_back(coarser(levels.back()));
  }
  const bool known = cv::countNonZero(levels.back().weights) > 0;
  if (!known || levels.size() == 1) return known;
  cv::Mat picture = levels.back().values;
  for (size_t i = levels.size() - 1; i-- > 0;) picture = filled(levels[i], picture, seam);
  picture.copyTo(values);
  return true;
}

}  // namespace raywalk
