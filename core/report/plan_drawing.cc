#include "core/report/plan_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/report/markup.h"

namespace raywalk {
namespace {

constexpr double kLongest_px = 520.0;
constexpr double kCaption_px = 22.0;
constexpr double kNote_px = 18.0;
constexpr double kLabelGap_px = 6.0;
constexpr double kTextHeight_px = 10.0;

constexpr std::string_view kPlanStyle = R"(.raywalk-plan { --ink: #1f2933; --soft: #6b7785;
  --accent: #d55e00; }
@media screen and (prefers-color-scheme: dark) {
.raywalk-plan { --ink: #e4e8ec; --soft: #98a3af; --accent: #f08a4b; } }
.raywalk-plan text { font: 14px system-ui, "Segoe UI", "DejaVu Sans", sans-serif;
  fill: var(--soft); }
.raywalk-plan .scale { stroke: var(--ink); stroke-width: 2; }
)";

// 1, 2 or 5 times a power of ten.
double round_length(double about_m) {
  const double power = std::pow(10.0, std::floor(std::log10(about_m)));
  return about_m >= 5.0 * power ? 5.0 * power : about_m >= 2.0 * power ? 2.0 * power : power;
}

}  // namespace

void PlanBounds::add(PlanPoint point) {
  min = {std::min(min.x_m, point.x_m), std::min(min.z_m, point.z_m)};
  max = {std::max(max.x_m, point.x_m), std::max(max.z_m, point.z_m)};
}

PlanDrawing::PlanDrawing(const PlanBounds& bounds, double border_px)
    : bounds_(bounds),
      border_px_(border_px),
      px_per_m_(kLongest_px / std::max(bounds.width_m(), bounds.depth_m())) {}

void PlanDrawing::add_dot(std::string_view css_class, PlanPoint centre, double radius_px) {
  content_ += fmt::format("<circle class=\"{}\" cx=\"{}\" cy=\"{}\" r=\"{}\"/>\n", css_class,
                          x_px(centre.x_m), y_px(centre.z_m), plain_number(radius_px, 1));
}

void PlanDrawing::add_line(std::string_view css_class, PlanPoint from, PlanPoint to) {
  content_ += fmt::format("<line class=\"{}\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>\n",
                          css_class, x_px(from.x_m), y_px(from.z_m), x_px(to.x_m), y_px(to.z_m));
}

void PlanDrawing::add_polygon(std::string_view css_class, std::span<const PlanPoint> corners) {
  std::string points;
  for (const PlanPoint& corner : corners) {
    points += fmt::format("{}{},{}", points.empty() ? "" : " ", x_px(corner.x_m), y_px(corner.z_m));
  }
  content_ += fmt::format("<polygon class=\"{}\" points=\"{}\"/>\n", css_class, points);
}

void PlanDrawing::add_label(std::string_view text, PlanPoint point, LabelSide side) {
  const bool beside = side == LabelSide::kLeft || side == LabelSide::kRight;
  const char* anchor = side == LabelSide::kLeft ? "end" : beside ? "start" : "middle";
  const double right_px = side == LabelSide::kLeft    ? -kLabelGap_px
                          : side == LabelSide::kRight ? kLabelGap_px
                                                      : 0.0;
  const double down_px = side == LabelSide::kAbove   ? -kLabelGap_px
                         : side == LabelSide::kBelow ? kLabelGap_px + kTextHeight_px
                                                     : 0.5 * kTextHeight_px;
  content_ += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>\n",
                          x_px(point.x_m + metres_of(right_px)),
                          y_px(point.z_m - metres_of(down_px)), anchor, escape_markup(text));
}

std::string PlanDrawing::svg(std::string_view title, std::string_view rules,
                             std::span<const std::string> notes) const {
  const double width_px =
      2.0 * border_px_ + std::max(px_per_m_ * bounds_.width_m(), 0.5 * kLongest_px);
  const double plan_px = 2.0 * border_px_ + px_per_m_ * bounds_.depth_m() + kCaption_px;
  const double height_px = plan_px + kNote_px * static_cast<double>(notes.size());
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"raywalk-plan\" role=\"img\" "
      "width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "style=\"max-width: 100%; height: auto\">\n<title>{2}</title>\n<style>\n",
      width_px, height_px, escape_markup(title));
  svg += kPlanStyle;
  svg += rules;
  svg += "</style>\n";
  svg += content_;
  const double bar_m = round_length(metres_of(0.25 * kLongest_px));
  const double bar_end_px = border_px_ + px_per_m_ * bar_m;
  svg += fmt::format(
      "<line class=\"scale\" x1=\"{0}\" y1=\"{1:.0f}\" x2=\"{2}\" y2=\"{1:.0f}\"/>\n"
      "<text x=\"{3}\" y=\"{4:.0f}\">{5} m; front (+z) is up</text>\n",
      plain_number(border_px_, 1), plan_px - 12.0, plain_number(bar_end_px, 1),
      plain_number(bar_end_px + 8.0, 1), plan_px - 8.0, plain_number(bar_m, 3));
  for (std::size_t i = 0; i < notes.size(); ++i) {
    svg +=
        fmt::format("<text x=\"{}\" y=\"{:.0f}\">{}</text>\n", plain_number(border_px_, 1),
                    plan_px - 8.0 + kNote_px * static_cast<double>(i + 1), escape_markup(notes[i]));
  }
  return svg + "</svg>\n";
}

std::string PlanDrawing::x_px(double x_m) const {
  return plain_number(border_px_ + px_per_m_ * (x_m - bounds_.min.x_m), 1);
}

std::string PlanDrawing::y_px(double z_m) const {
  return plain_number(border_px_ + px_per_m_ * (bounds_.max.z_m - z_m), 1);
}

}  // namespace raywalk
