#include "build_lf/require/recreated_view.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/panorama_pixels.h"

namespace raywalk::build_lf {
namespace {

constexpr double kMaxDb = 100.0;

// Bilinearly interpolated red, green and blue.
Eigen::Vector3d color_at(const StationView& view, PixelPosition pixel) {
  const PixelsAround around = pixels_around(pixel, view.rays->panorama());
  Eigen::Vector3d color(0, 0, 0);
  for (size_t i = 0; i < 2; ++i) {
    const auto column = view.rays->column(view.station, around.column[i]);
    for (size_t j = 0; j < 2; ++j) {
      const std::uint8_t* rgb = column.data() + 3 * static_cast<size_t>(around.row[j]);
      color += around.weight(i, j) * Eigen::Vector3d(rgb[0], rgb[1], rgb[2]);
    }
  }
  return color;
}

// Whether all four surrounding pixels are valid.
bool is_valid(const StationView& view, PixelPosition pixel) {
  const PixelsAround around = pixels_around(pixel, view.rays->panorama());
  for (const int theta : around.column) {
    const RowRun rows = view.rays->valid_rows(view.station, theta);
    if (around.row[0] < rows.begin || around.row[1] >= rows.end) return false;
  }
  return true;
}

struct Sighting {
  Eigen::Vector3d color{0, 0, 0};
  bool masked = false;
  bool visible = false;  // and not masked
};

// The point of `truth` in `direction`, seen from another station.
Sighting sight(const StationView& from, const StationView& truth, const Eigen::Vector3d& direction,
               float omega) {
  const SeenPoint seen = seen_from(direction, omega, truth.position_m - from.position_m);
  const float nearest = from.omega->sample(pixel_from_angles(seen.angles, from.omega->size()));
  // One pixel of this map, and one of the map it was projected from.
  const float tolerance = 2.0f * from.omega->surface_tolerance();
  const PixelPosition pixel = pixel_from_angles(seen.angles, from.rays->panorama());
  const bool masked = !is_valid(from, pixel);
  return {color_at(from, pixel), masked, !masked && nearest <= seen.omega * (1.0f + tolerance)};
}

// Weight of the second sighting: if only one is visible (or else only one unmasked) it is used
// alone; otherwise both are blended by nearness.
double share_of_second(const Sighting& first, const Sighting& second, double fraction) {
  if (first.visible != second.visible) return second.visible ? 1.0 : 0.0;
  if (first.masked != second.masked) return first.masked ? 1.0 : 0.0;
  return fraction;
}

double squared_distance(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  // Colours are compared as rounded 8-bit values.
  const auto rounded = [](double level) { return std::round(level); };
  return (a.unaryExpr(rounded) - b.unaryExpr(rounded)).squaredNorm();
}

// Sum of squared differences between a pixel and those displaced by the angle of `tolerance_px`
// rows; towards a pole that angle spans more columns.
double displacement_error(const StationView& view, PixelPosition pixel, double tolerance_px,
                          double cos_phi) {
  const Eigen::Vector3d color = color_at(view, pixel);
  const double columns =
      tolerance_px / std::max(cos_phi, tolerance_px / view.rays->panorama().width);
  return squared_distance(color, color_at(view, {pixel.u + columns, pixel.v})) +
         squared_distance(color, color_at(view, {pixel.u, pixel.v + tolerance_px}));
}

}  // namespace

double psnr_db(double mean_squared_error) {
  return std::min(kMaxDb, 10.0 * std::log10(255.0 * 255.0 / mean_squared_error));
}

RecreationScore score_recreation(const StationView& truth, const StationView& left,
                                 const StationView& right, double tolerance_px, int width) {
  const PanoramaSize size = truth.rays->panorama();
  const int stride = std::max(1, static_cast<int>(std::lround(double(size.width) / width)));
  const double to_left = (truth.position_m - left.position_m).norm();
  const double to_right = (truth.position_m - right.position_m).norm();
  const double fraction = to_left / (to_left + to_right);
  double with = 0.0, without = 0.0, displaced = 0.0, hidden = 0.0, solid_angle = 0.0;
  std::int64_t pixels = 0;
  for (int theta = stride / 2; theta < size.width; theta += stride) {
    for (int row = stride / 2; row < size.height; row += stride) {
      const PixelPosition pixel{static_cast<double>(theta), static_cast<double>(row)};
      if (!is_valid(truth, pixel)) continue;
      const SphereAngles angles = angles_from_pixel(pixel, size);
      const Eigen::Vector3d direction = direction_from_angles(angles);
      const float omega =
          std::max(0.0f, truth.omega->sample(pixel_from_angles(angles, truth.omega->size())));
      const Sighting a = sight(left, truth, direction, omega);
      const Sighting b = sight(right, truth, direction, omega);
      const double part = std::cos(angles.phi_rad);
      solid_angle += part;
      if (!a.visible && !b.visible) hidden += part;
      // Masked in both stations, so not comparable; a view would show it from another line.
      if (a.masked && b.masked) continue;
      const double share_of_b = share_of_second(a, b, fraction);
      const Eigen::Vector3d captured = color_at(truth, pixel);
      with += squared_distance(a.color + share_of_b * (b.color - a.color), captured);
      const Eigen::Vector3d first = color_at(left, pixel), second = color_at(right, pixel);
      without += squared_distance(first + fraction * (second - first), captured);
      displaced += 0.5 * displacement_error(truth, pixel, tolerance_px, part);
      ++pixels;
    }
  }
  if (pixels == 0) return {kMaxDb, kMaxDb, kMaxDb, 1.0};
  const double samples = 3.0 * static_cast<double>(pixels);
  return {psnr_db(with / samples), psnr_db(without / samples), psnr_db(displaced / samples),
          hidden / solid_angle};
}

}  // namespace raywalk::build_lf
