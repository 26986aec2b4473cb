// A floor plan as SVG: points, lines and labels given in metres, seen from above with the front
// (+z) up, and a scale bar.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "core/geometry/sphere.h"

namespace raywalk {

// Bounding box of the points added, metres.
struct PlanBounds {
  PlanPoint min{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  PlanPoint max{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

  void add(PlanPoint point);
  double width_m() const { return max.x_m - min.x_m; }
  double depth_m() const { return max.z_m - min.z_m; }
};

// The position of a label relative to its point.
enum class LabelSide { kLeft, kRight, kAbove, kBelow };

// Content is drawn in the order it is added. CSS classes refer to the rules given to svg().
class PlanDrawing {
 public:
  // `bounds` must contain two different points; `border_px` is the margin around them. The longer
  // side is 520 px.
  PlanDrawing(const PlanBounds& bounds, double border_px);

  // Converts a length in the drawing to metres, for sizes that do not depend on the scale.
  double metres_of(double px) const { return px / px_per_m_; }

  void add_dot(std::string_view css_class, PlanPoint centre, double radius_px);
  void add_line(std::string_view css_class, PlanPoint from, PlanPoint to);
  void add_polygon(std::string_view css_class, std::span<const PlanPoint> corners);
  void add_label(std::string_view text, PlanPoint point, LabelSide side);

  // A complete <svg> element of class "raywalk-plan", valid as a file and within a page, that
  // follows the reader's light or dark mode. `rules` are CSS rules for the classes used, each
  // starting with ".raywalk-plan "; they may use the colours --ink, --soft and --accent. `notes`
  // are lines of text below the scale bar.
  std::string svg(std::string_view title, std::string_view rules,
                  std::span<const std::string> notes = {}) const;

 private:
  std::string x_px(double x_m) const;
  std::string y_px(double z_m) const;

  PlanBounds bounds_;
  double border_px_;
  double px_per_m_;
  std::string content_;
};

}  // namespace raywalk
