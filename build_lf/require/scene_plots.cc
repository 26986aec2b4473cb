#include "build_lf/require/scene_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "build_lf/require/scene_facts.h"
#include "core/geometry/sphere.h"
#include "core/report/markup.h"

namespace raywalk::build_lf {
namespace {

constexpr const char* kStyle = R"(<style>
.raywalk-scene { --ink: #1f2933; --soft: #6b7785; --grid: #d5dbe1; --sky: #cfe6f5; --band: #0072b2; }
@media screen and (prefers-color-scheme: dark) {
.raywalk-scene { --ink: #e4e8ec; --soft: #98a3af; --grid: #3a434c; --sky: #25465c; --band: #4aa8e0; } }
.raywalk-scene text { font: 12px system-ui, "Segoe UI", "DejaVu Sans", sans-serif; fill: var(--ink); }
.raywalk-scene .tick { fill: var(--soft); }
.raywalk-scene .field { font-size: 9.5px; }
.raywalk-scene .ring { fill: none; stroke: var(--grid); }
.raywalk-scene .spread { fill: var(--band); fill-opacity: .18; stroke: none; }
.raywalk-scene .median { fill: none; stroke: var(--band); stroke-width: 2.2; stroke-linejoin: round; }
.raywalk-scene .sky { fill: var(--sky); }
</style>
)";

// `least_width`: a page scrolls it where there is less room.
std::string open_svg(int width, int height, int least_width, const char* title) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"raywalk-scene\" role=\"img\" "
      "width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "style=\"max-width: 100%; min-width: {2}px; height: auto\">\n<title>{3}</title>\n{4}",
      width, height, least_width, title, kStyle);
}

std::string text_at(double x, double y, const char* anchor, const std::string& text,
                    const char* css_class = "tick") {
  return fmt::format("<text class=\"{}\" x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>\n",
                     css_class, plain_number(x, 1), plain_number(y, 1), anchor,
                     escape_markup(text));
}

struct Colour {
  double red, green, blue;
};

// Nine samples of Viridis, which is perceptually uniform and safe for colour-blind readers.
constexpr std::array<Colour, 9> kScale{{{253, 231, 37},
                                        {170, 220, 50},
                                        {94, 201, 98},
                                        {39, 173, 129},
                                        {33, 145, 140},
                                        {44, 113, 142},
                                        {59, 82, 139},
                                        {71, 44, 122},
                                        {68, 1, 84}}};

// `place` in [0, 1]: 0 is near and bright, 1 far and dark.
Colour colour_at(double place) {
  const double at = std::clamp(place, 0.0, 1.0) * (kScale.size() - 1);
  const auto first = std::min(static_cast<size_t>(at), kScale.size() - 2);
  const double part = at - static_cast<double>(first);
  const Colour &a = kScale[first], &b = kScale[first + 1];
  return {a.red + part * (b.red - a.red), a.green + part * (b.green - a.green),
          a.blue + part * (b.blue - a.blue)};
}

std::string css_of(Colour colour) {
  return fmt::format("rgb({:.0f},{:.0f},{:.0f})", colour.red, colour.green, colour.blue);
}

// The range of the fields' near distances, for the colour scale.
struct NearRange {
  double min_m = 1.0, max_m = 1.0;
  // Logarithmic, as ratios of distances matter.
  double place(double metres) const {
    return max_m > min_m ? std::log(metres / min_m) / std::log(max_m / min_m) : 0.0;
  }
};

NearRange near_range(const std::vector<DirectionRange>& directions) {
  NearRange range{0.0, 0.0};
  for (const DirectionRange& field : directions) {
    if (!std::isfinite(field.near_m) || field.near_m <= 0.0) continue;
    range.min_m = range.min_m == 0.0 ? field.near_m : std::min(range.min_m, field.near_m);
    range.max_m = std::max(range.max_m, field.near_m);
  }
  return range;
}

std::string field_rect(const DirectionRange& field, const NearRange& range, double left, double top,
                       double side) {
  const double x = left + (field.longitude_deg + 180.0) / kFieldDeg * side - 0.5 * side;
  const double y = top + (90.0 - field.latitude_deg) / kFieldDeg * side - 0.5 * side;
  const std::string rect =
      fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" ", plain_number(x, 2),
                  plain_number(y, 2), plain_number(side - 1.0, 2), plain_number(side - 1.0, 2));
  if (!std::isfinite(field.near_m)) {
    return rect + "class=\"sky\"/>\n" +
           text_at(x + 0.5 * side, y + 0.5 * side + 3.0, "middle", "sky", "field");
  }
  const double place = range.place(field.near_m);
  return rect + fmt::format(
                    "fill=\"{}\"/>\n<text class=\"field\" style=\"fill: {}\" x=\"{}\" y=\"{}\" "
                    "text-anchor=\"middle\">{}</text>\n",
                    css_of(colour_at(place)), place < 0.45 ? "#10202c" : "#ffffff",
                    plain_number(x + 0.5 * side, 1), plain_number(y + 0.5 * side + 3.0, 1),
                    fixed_number(field.near_m, field.near_m < 9.95 ? 1 : 0));
}

// The fields adjacent to the horizon, averaged above and below it, by longitude.
struct HorizonPoint {
  double longitude_deg;
  double near_m, median_m, far_m;
};

std::vector<HorizonPoint> horizon_of(const DistanceFacts& distance, double largest_m) {
  std::vector<HorizonPoint> horizon;
  for (const DirectionRange& field : distance.directions) {
    if (std::abs(field.latitude_deg) > kFieldDeg) continue;
    const auto bounded = [&](double metres) { return std::min(metres, largest_m); };
    const HorizonPoint point{field.longitude_deg, bounded(field.near_m), bounded(field.median_m),
                             bounded(field.far_m)};
    const auto same = std::ranges::find(horizon, point.longitude_deg, &HorizonPoint::longitude_deg);
    if (same == horizon.end()) {
      horizon.push_back(point);
    } else {
      same->near_m = std::min(same->near_m, point.near_m);
      same->median_m = 0.5 * (same->median_m + point.median_m);
      same->far_m = std::max(same->far_m, point.far_m);
    }
  }
  std::ranges::sort(horizon, {}, &HorizonPoint::longitude_deg);
  return horizon;
}

// The step between rings: 1, 2 or 5 times a power of ten, about four rings up to `largest_m`.
double ring_step(double largest_m) {
  const double power = std::pow(10.0, std::floor(std::log10(largest_m / 4.0)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= largest_m / 4.0) return factor * power;
  }
  return 10.0 * power;
}

}  // namespace

std::string direction_map_svg(const DistanceFacts& distance) {
  constexpr double kLeft = 40.0, kTop = 12.0, kSide = 25.0;
  constexpr int kWidth = 660, kHeight = 390, kLeastWidth = 600;
  const NearRange range = near_range(distance.directions);
  std::string svg =
      open_svg(kWidth, kHeight, kLeastWidth, "Nearest surface in every direction, metres");
  for (const DirectionRange& field : distance.directions) {
    svg += field_rect(field, range, kLeft, kTop, kSide);
  }
  const double bottom = kTop + 180.0 / kFieldDeg * kSide;
  constexpr std::array<const char*, 5> kNames{"back", "left", "front", "right", "back"};
  for (int i = 0; i < 5; ++i) {
    svg += text_at(kLeft + i * 90.0 / kFieldDeg * kSide, bottom + 16.0, "middle",
                   kNames[static_cast<size_t>(i)]);
  }
  for (int latitude_deg = -90; latitude_deg <= 90; latitude_deg += 45) {
    svg += text_at(kLeft - 6.0, kTop + (90.0 - latitude_deg) / kFieldDeg * kSide + 4.0, "end",
                   fmt::format("{}", latitude_deg));
  }
  constexpr int kSteps = 48;
  const double key_top = bottom + 32.0;
  for (int i = 0; i < kSteps; ++i) {
    svg += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"5.2\" height=\"10\" fill=\"{}\"/>\n",
                       plain_number(kLeft + 5.0 * i, 1), plain_number(key_top, 1),
                       css_of(colour_at((i + 0.5) / kSteps)));
  }
  svg += text_at(kLeft, key_top + 26.0, "start", plain_number(range.min_m, 2) + " m");
  svg += text_at(kLeft + 5.0 * kSteps, key_top + 26.0, "end", plain_number(range.max_m, 2) + " m");
  return svg + "</svg>\n";
}

std::string horizon_svg(const DistanceFacts& distance) {
  constexpr int kSize = 420;
  constexpr double kCentre = 0.5 * kSize, kRadius = 176.0;
  const double finite_far_m =
      std::isfinite(distance.far_m) ? distance.far_m : 2.0 * distance.median_m;
  const double largest_m = std::isfinite(finite_far_m) && finite_far_m > 0.0 ? finite_far_m : 1.0;
  const std::vector<HorizonPoint> horizon = horizon_of(distance, largest_m);
  const auto place = [&](double longitude_deg, double metres) {
    const double theta_rad = radians_from_degrees(longitude_deg);
    const double radius = kRadius * metres / largest_m;
    return fmt::format("{},{}", plain_number(kCentre + radius * std::sin(theta_rad), 1),
                       plain_number(kCentre - radius * std::cos(theta_rad), 1));
  };
  const auto outline = [&](double HorizonPoint::*distance_m) {
    std::string path;
    for (const HorizonPoint& point : horizon) {
      path += (path.empty() ? "M" : "L") + place(point.longitude_deg, point.*distance_m);
    }
    return path + "Z";
  };
  std::string svg = open_svg(kSize, kSize, kSize / 2, "Distances around the horizon");
  const double step_m = ring_step(largest_m);
  const int rings = static_cast<int>(largest_m / step_m + 1e-6);
  for (int ring = 1; ring <= rings; ++ring) {
    const double ring_m = ring * step_m;
    const double radius = kRadius * ring_m / largest_m;
    svg += fmt::format("<circle class=\"ring\" cx=\"{0}\" cy=\"{0}\" r=\"{1}\"/>\n",
                       plain_number(kCentre, 1), plain_number(radius, 1));
    svg += text_at(kCentre + 0.7071 * radius + 3.0, kCentre - 0.7071 * radius - 3.0, "start",
                   plain_number(ring_m, 2) + " m");
  }
  if (!horizon.empty()) {
    svg += fmt::format("<path class=\"spread\" fill-rule=\"evenodd\" d=\"{}{}\"/>\n",
                       outline(&HorizonPoint::far_m), outline(&HorizonPoint::near_m));
    svg += fmt::format("<path class=\"median\" d=\"{}\"/>\n", outline(&HorizonPoint::median_m));
  }
  svg += text_at(kCentre, 16.0, "middle", "front (+z)");
  svg += text_at(kCentre, kSize - 8.0, "middle", "back");
  svg += text_at(kSize - 4.0, kCentre + 4.0, "end", "right");
  svg += text_at(4.0, kCentre + 4.0, "start", "left");
  return svg + "</svg>\n";
}

}  // namespace raywalk::build_lf
