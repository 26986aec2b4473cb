#include "core/view/picture_fill.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>

#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

// Connected unknown pixels: columns [first, end) and rows of a picture. Columns may lie beyond the
// seam.
struct Patch {
  int first = 0;
  int end = 0;
  RowRun rows{};

  int size() const { return std::max(end - first, rows.end - rows.begin); }
};

struct ColumnRun {
  int column = 0;
  RowRun rows{};
};

// Sets of runs that are connected; each is named by its first run (union-find).
class Connected {
 public:
  explicit Connected(size_t runs) : parent_(runs) {
    std::iota(parent_.begin(), parent_.end(), size_t{0});
  }
  size_t name_of(size_t run) {
    while (parent_[run] != run) run = parent_[run] = parent_[parent_[run]];
    return run;
  }
  void join(size_t a, size_t b) {
    a = name_of(a);
    b = name_of(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<size_t> parent_;
};

// The first column, from which on the columns are looked at around the seam: after one that is all
// known, so that no patch crosses it, if there is one.
int first_column(const UnknownPixels& unknown) {
  if (unknown.seam == Seam::kOpen) return 0;
  const auto known = std::ranges::find_if(unknown.columns, [](const auto& c) { return c.empty(); });
  return known == unknown.columns.end() ? 0 : static_cast<int>(known - unknown.columns.begin());
}

std::vector<ColumnRun> runs_of(const UnknownPixels& unknown) {
  const int columns = static_cast<int>(unknown.columns.size());
  const int first = first_column(unknown);
  std::vector<ColumnRun> runs;
  for (int column = first; column < first + columns; ++column) {
    for (const RowRun& rows : unknown.columns[static_cast<size_t>(column % columns)]) {
      const RowRun shown = common_rows(rows, unknown.rows);
      if (!shown.empty()) runs.push_back({column, shown});
    }
  }
  return runs;
}

// The patches of runs that are ordered by column.
std::vector<Patch> patches_of(std::span<const ColumnRun> runs) {
  Connected connected(runs.size());
  size_t before = 0;  // the first run that may touch the current one
  for (size_t i = 0; i < runs.size(); ++i) {
    while (runs[before].column < runs[i].column - 1) ++before;
    for (size_t j = before; j < i; ++j) {
      const RowRun grown{runs[j].rows.begin - 1, runs[j].rows.end + 1};
      if (!common_rows(grown, runs[i].rows).empty()) connected.join(i, j);
    }
  }
  std::vector<Patch> patches(runs.size());
  for (size_t i = 0; i < runs.size(); ++i) {
    Patch& patch = patches[connected.name_of(i)];
    const ColumnRun& run = runs[i];
    if (patch.end == 0) {
      patch = {run.column, run.column + 1, run.rows};
    } else {
      patch.end = std::max(patch.end, run.column + 1);
      patch.rows = {std::min(patch.rows.begin, run.rows.begin),
                    std::max(patch.rows.end, run.rows.end)};
    }
  }
  std::erase_if(patches, [](const Patch& patch) { return patch.end == 0; });
  return patches;
}

// 1 where a pixel is known.
cv::Mat known_pixels(std::span<const ColumnRun> runs, cv::Size size) {
  cv::Mat known(size, CV_8UC1, cv::Scalar(1));
  for (const ColumnRun& run : runs) {
    known.col(run.column % size.width).rowRange(run.rows.begin, run.rows.end) = 0;
  }
  return known;
}

// A patch and what surrounds it, as far as its own size.
Patch surroundings(const Patch& patch, const UnknownPixels& unknown) {
  constexpr int kLeast = 8;
  const int margin = std::max(kLeast, patch.size());
  Patch around{patch.first - margin, patch.end + margin,
               common_rows({patch.rows.begin - margin, patch.rows.end + margin}, unknown.rows)};
  const int columns = static_cast<int>(unknown.columns.size());
  if (unknown.seam == Seam::kOpen) {
    around.first = std::max(around.first, 0);
    around.end = std::min(around.end, columns);
  } else if (around.end - around.first >= columns) {
    around.first = 0;
    around.end = columns;
  }
  return around;
}

// Copies the columns of `around` out of a picture, around its seam.
cv::Mat cut(const cv::Mat& picture, const Patch& around) {
  const int columns = picture.cols;
  cv::Mat part(around.rows.end - around.rows.begin, around.end - around.first, picture.type());
  for (int x = around.first; x < around.end;) {
    const int from = (x + columns) % columns;
    const int count = std::min(around.end - x, columns - from);
    picture(cv::Rect(from, around.rows.begin, count, part.rows))
        .copyTo(part.colRange(x - around.first, x - around.first + count));
    x += count;
  }
  return part;
}

std::vector<float> column_widths(const Patch& around, int height) {
  std::vector<float> widths;
  for (int row = around.rows.begin; row < around.rows.end; ++row) {
    const SphereAngles angles = angles_from_pixel({0.0, double(row)}, {2 * height, height});
    widths.push_back(static_cast<float>(std::cos(angles.phi_rad)));
  }
  return widths;
}

// Fills a patch. `known` is of the whole picture: other patches are not looked at, so that their
// order does not matter.
void fill_patch(const Patch& patch, const UnknownPixels& unknown, const cv::Mat& known,
                cv::Mat* picture) {
  const int columns = picture->cols;
  const Patch around = surroundings(patch, unknown);
  cv::Mat values, weights;
  cut(*picture, around).convertTo(values, CV_32F);
  cut(known, around).convertTo(weights, CV_32F);
  const bool whole = around.end - around.first == columns;
  if (!fill_unknown(values, weights, whole ? unknown.seam : Seam::kOpen,
                    column_widths(around, picture->rows))) {
    return;
  }
  cv::Mat filled;
  values.convertTo(filled, CV_8U);
  for (int x = patch.first; x < patch.end; ++x) {
    const cv::Range rows(patch.rows.begin, patch.rows.end);
    filled.col((x - around.first + columns) % columns)
        .rowRange(rows.start - around.rows.begin, rows.end - around.rows.begin)
        .copyTo(picture->col(x % columns).rowRange(rows),
                known.col(x % columns).rowRange(rows) == 0);
  }
}

// Where every column holds something unknown, patches may meet at the seam: these become one.
void join_at_seam(int columns, std::vector<Patch>* patches) {
  const auto is_left = [](const Patch& patch) { return patch.first == 0; };
  const auto is_right = [&](const Patch& patch) { return patch.end == columns; };
  if (!std::ranges::any_of(*patches, is_left) || !std::ranges::any_of(*patches, is_right)) return;
  Patch joined{0, columns, patches->front().rows};
  std::erase_if(*patches, [&](const Patch& patch) {
    if (!is_left(patch) && !is_right(patch)) return false;
    joined.rows = {std::min(joined.rows.begin, patch.rows.begin),
                   std::max(joined.rows.end, patch.rows.end)};
    return true;
  });
  patches->push_back(joined);
}

}  // namespace

void fill_picture(const UnknownPixels& unknown, cv::Mat* picture) {
  const std::vector<ColumnRun> runs = runs_of(unknown);
  if (runs.empty()) return;
  const cv::Mat known = known_pixels(runs, picture->size());
  std::vector<Patch> patches = patches_of(runs);
  if (unknown.seam == Seam::kJoined) join_at_seam(picture->cols, &patches);
  for (const Patch& patch : patches) fill_patch(patch, unknown, known, picture);
}

bool is_unknown_at_border(const UnknownPixels& unknown, int size_px) {
  const int columns = static_cast<int>(unknown.columns.size());
  return std::ranges::any_of(patches_of(runs_of(unknown)), [&](const Patch& patch) {
    const bool beside = unknown.seam == Seam::kOpen && (patch.first == 0 || patch.end == columns);
    const bool above = unknown.rows.begin > 0 && patch.rows.begin == unknown.rows.begin;
    const bool below = unknown.rows.end < unknown.height && patch.rows.end == unknown.rows.end;
    return patch.size() >= size_px && (beside || above || below);
  });
}

}  // namespace raywalk
