#include "core/report/label_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace raywalk {
namespace {

constexpr double kGapPx = 6.0;
constexpr double kPointRadiusPx = 4.5;
constexpr double kAscentPx = 0.8 * kFontPx;  // of a text above its baseline
constexpr double kDescentPx = 0.2 * kFontPx;

// Whether the segment passes through the rectangle (Liang and Barsky's clipping).
bool crosses(PixelPoint a, PixelPoint b, PixelPoint low, PixelPoint high) {
  double from = 0.0, to = 1.0;
  const auto clip = [&](double start, double step, double min, double max) {
    if (step == 0.0) return start >= min && start <= max;
    const double first = (min - start) / step, second = (max - start) / step;
    from = std::max(from, std::min(first, second));
    to = std::min(to, std::max(first, second));
    return from <= to;
  };
  return clip(a.x, b.x - a.x, low.x, high.x) && clip(a.y, b.y - a.y, low.y, high.y);
}

// Around the point, the preferred place first.
std::array<TextBox, 8> candidates(PixelPoint point, double width) {
  const double above = point.y - kGapPx, below = point.y + kGapPx + kAscentPx;
  const double beside = point.y + 0.5 * (kAscentPx - kDescentPx);
  const auto on_left = [&](double baseline) {
    return TextBox{point.x - kGapPx - width, point.x - kGapPx, baseline};
  };
  const auto on_right = [&](double baseline) {
    return TextBox{point.x + kGapPx, point.x + kGapPx + width, baseline};
  };
  const auto centred = [&](double baseline) {
    return TextBox{point.x - 0.5 * width, point.x + 0.5 * width, baseline};
  };
  return {on_left(above),   on_right(below), on_right(above),      on_left(below),
          on_right(beside), on_left(beside), centred(above - 2.0), centred(below + 2.0)};
}

}  // namespace

LabelPlaces::LabelPlaces(PixelPoint top_left, PixelPoint bottom_right)
    : top_left_(top_left), bottom_right_(bottom_right) {}

void LabelPlaces::add_line(const std::vector<PixelPoint>& line) {
  for (std::size_t i = 1; i < line.size(); ++i) segments_.emplace_back(line[i - 1], line[i]);
}

std::optional<TextBox> LabelPlaces::place(PixelPoint point, const std::string& label) {
  const std::array<TextBox, 8> boxes = candidates(point, text_px(label));
  for (const bool avoid_lines : {true, false}) {
    for (const TextBox& box : boxes) {
      if (!free_of_texts_and_points(box) || (avoid_lines && !free_of_lines(box))) continue;
      taken_.push_back(box);
      return box;
    }
  }
  return std::nullopt;
}

bool LabelPlaces::free_of_texts_and_points(const TextBox& box) const {
  const double top = box.baseline - kAscentPx, bottom = box.baseline + kDescentPx;
  if (box.left < top_left_.x || box.right > bottom_right_.x || top < top_left_.y ||
      bottom > bottom_right_.y) {
    return false;
  }
  const bool on_text = std::any_of(taken_.begin(), taken_.end(),
                                   [&](const TextBox& other) { return box.overlaps(other); });
  return !on_text && std::none_of(points_.begin(), points_.end(), [&](PixelPoint point) {
    const double x = std::clamp(point.x, box.left, box.right) - point.x;
    const double y = std::clamp(point.y, top, bottom) - point.y;
    return std::hypot(x, y) < kPointRadiusPx;
  });
}

bool LabelPlaces::free_of_lines(const TextBox& box) const {
  return std::none_of(segments_.begin(), segments_.end(), [&](const auto& segment) {
    return crosses(segment.first, segment.second, {box.left, box.baseline - kAscentPx},
                   {box.right, box.baseline + kDescentPx});
  });
}

std::vector<ReferenceLabel> reference_labels(
    const std::vector<std::pair<double, std::string>>& lines, double left, double right) {
  std::vector<ReferenceLabel> labels;
  double taken_to = left;  // in the row of the previous label, by it or its line
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto& [x, text] = lines[i];
    const double width = text_px(text) + kGapPx;
    const bool fits_left = x - width >= left;
    const bool on_right = x + width <= right && (i + 1 == lines.size() || !fits_left);
    const double from = on_right ? x : x - width;
    const int row = i == 0 || from >= taken_to ? 0 : labels.back().row + 1;
    labels.push_back({x, row, on_right, text});
    taken_to = (on_right ? x + width : x) + kGapPx;
  }
  return labels;
}

}  // namespace raywalk
