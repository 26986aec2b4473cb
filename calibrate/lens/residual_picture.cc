#include "calibrate/lens/residual_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "calibrate/lens/image_circle.h"
#include "core/base/median.h"
#include "core/report/markup.h"

namespace raywalk::calibrate {
namespace {

constexpr double kSide_px = 480.0;
constexpr double kMargin_px = 16.0;
constexpr double kFooter_px = 28.0;
constexpr std::size_t kMostArrows = 2500;
// Drawn length of the median residual.
constexpr double kTypicalArrow_px = 9.0;

constexpr const char* kStyle = R"(.raywalk-residuals { --ink: #1f2933; --soft: #98a3af;
  --accent: #d55e00; }
@media screen and (prefers-color-scheme: dark) {
.raywalk-residuals { --ink: #e4e8ec; --soft: #6b7785; --accent: #f08a4b; } }
.raywalk-residuals text { font: 12px system-ui, "Segoe UI", "DejaVu Sans", sans-serif;
  fill: var(--ink); }
.raywalk-residuals .rim { fill: none; stroke: var(--soft); }
.raywalk-residuals .arrow { stroke: var(--accent); stroke-width: 1; }
.raywalk-residuals .place { fill: var(--ink); }
.raywalk-residuals .scale { stroke: var(--accent); stroke-width: 2; }
)";

std::vector<LensResidual> residuals_of(const LensFit& fit, bool back) {
  std::vector<LensResidual> all;
  std::copy_if(fit.residuals.begin(), fit.residuals.end(), std::back_inserter(all),
               [back](const LensResidual& residual) { return residual.back == back; });
  const std::size_t step = (all.size() + kMostArrows - 1) / kMostArrows;
  std::vector<LensResidual> drawn;
  for (std::size_t i = 0; i < all.size(); i += std::max<std::size_t>(step, 1)) {
    drawn.push_back(all[i]);
  }
  return drawn;
}

double median_size_px(const std::vector<LensResidual>& residuals) {
  if (residuals.empty()) return 1.0;
  std::vector<double> sizes;
  sizes.reserve(residuals.size());
  for (const LensResidual& residual : residuals) {
    sizes.push_back(std::hypot(residual.right_px, residual.down_px));
  }
  return std::max(1e-6, median(std::move(sizes)));
}

std::string px(double value) { return plain_number(value, 1); }

// Arrows start at the fitted point, marked by a dot, and end at the observed one.
std::string arrow(const LensResidual& residual, const FisheyeLens& lens, double per_px,
                  double enlarged) {
  const double middle = kMargin_px + 0.5 * kSide_px;
  const double x = middle + (residual.seen.u - lens.centre.u) * per_px;
  const double y = middle + (residual.seen.v - lens.centre.v) * per_px;
  return fmt::format(
      "<circle class=\"place\" cx=\"{0}\" cy=\"{1}\" r=\"0.8\"/><line class=\"arrow\" x1=\"{0}\" "
      "y1=\"{1}\" x2=\"{2}\" y2=\"{3}\"/>\n",
      px(x), px(y), px(x + residual.right_px * enlarged), px(y + residual.down_px * enlarged));
}

}  // namespace

std::string residual_picture(const LensFit& fit, bool back) {
  const FisheyeLens& lens = back ? fit.camera.layout.back : fit.camera.layout.front;
  const std::vector<LensResidual> residuals = residuals_of(fit, back);
  const double per_px = 0.5 * kSide_px / rim_radius_px(lens);
  const double typical_px = median_size_px(residuals);
  const double enlarged = kTypicalArrow_px / typical_px;
  const double width = kSide_px + 2.0 * kMargin_px, height = width + kFooter_px;
  std::string svg = fmt::format(
      "<svg class=\"raywalk-residuals\" xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" "
      "viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\"><title>Residuals of the {2} "
      "lens</title><style>{3}</style>\n",
      px(width), px(height), back ? "back" : "front", kStyle);
  svg += fmt::format("<circle class=\"rim\" cx=\"{0}\" cy=\"{0}\" r=\"{1}\"/>\n", px(0.5 * width),
                     px(0.5 * kSide_px));
  for (const LensResidual& residual : residuals) svg += arrow(residual, lens, per_px, enlarged);
  // The scale bar is as long as five typical residuals.
  constexpr double kScale = 5.0;
  const double y = width + 0.3 * kFooter_px;
  svg += fmt::format(
      "<line class=\"scale\" x1=\"{0}\" y1=\"{1}\" x2=\"{2}\" y2=\"{1}\"/><text x=\"{3}\" "
      "y=\"{4}\">{5} px; {6} image points</text>\n</svg>",
      px(kMargin_px), px(y), px(kMargin_px + kScale * kTypicalArrow_px),
      px(kMargin_px + kScale * kTypicalArrow_px + 8.0), px(y + 4.0),
      plain_number(kScale * typical_px, 2), residuals.size());
  return svg;
}

}  // namespace raywalk::calibrate
