// Finds free places for the labels of a plot: of its points, and of its reference lines.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/report/text_box.h"

namespace raywalk {

// A point of a drawing, pixels.
struct PixelPoint {
  double x = 0.0;
  double y = 0.0;
};

// Labels beside points: never on another label or point, and not on a line where there is a choice.
class LabelPlaces {
 public:
  // Labels stay within this rectangle, pixels.
  LabelPlaces(PixelPoint top_left, PixelPoint bottom_right);

  void add_point(PixelPoint point) { points_.push_back(point); }
  void add_line(const std::vector<PixelPoint>& line);

  // The place of a label beside `point`, taken from then on; none if there is no room.
  std::optional<TextBox> place(PixelPoint point, const std::string& label);

 private:
  bool free_of_texts_and_points(const TextBox& box) const;
  bool free_of_lines(const TextBox& box) const;

  PixelPoint top_left_;
  PixelPoint bottom_right_;
  std::vector<PixelPoint> points_;
  std::vector<std::pair<PixelPoint, PixelPoint>> segments_;
  std::vector<TextBox> taken_;
};

// The label of a reference line, above the plot.
struct ReferenceLabel {
  double x = 0.0;     // of the line, pixels
  int row = 0;        // from the plot upwards
  bool right = true;  // of the line
  std::string text{};
};

// Labels for lines, sorted by their x, between the plot's sides: the rightmost line has its label
// on the right, the others on the left if there is room, and none lies on another label or line.
std::vector<ReferenceLabel> reference_labels(
    const std::vector<std::pair<double, std::string>>& lines, double left, double right);

}  // namespace raywalk
