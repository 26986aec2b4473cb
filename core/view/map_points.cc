#include "core/view/map_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/geometry/panorama_pixels.h"

namespace raywalk {
namespace {

// The means of 2 x 2 pixels of the middle two of four columns; negative where not all of the 4 x 4
// pixels around are on one surface. `nearest` and `farthest` are scratch, one a row.
RAYWALK_VECTOR_CLONES void average_surfaces(std::array<const float*, 4> columns, int rows,
                                            float tolerance, float* nearest, float* farthest,
                                            float* mean) {
  const auto larger = [](float a, float b) { return a > b ? a : b; };
  const auto smaller = [](float a, float b) { return a > b ? b : a; };
  const float *const a = columns[0], *const b = columns[1], *const c = columns[2],
                     *const d = columns[3];
  for (int row = 0; row < rows; ++row) {
    nearest[row] = larger(larger(a[row], b[row]), larger(c[row], d[row]));
    farthest[row] = smaller(smaller(a[row], b[row]), smaller(c[row], d[row]));
  }
  mean[0] = mean[rows / 2 - 1] = -1.0f;
  for (int i = 1; i < rows / 2 - 1; ++i) {
    const float* const near = nearest + 2 * i - 1;
    const float* const far = farthest + 2 * i - 1;
    const float most = larger(larger(near[0], near[1]), larger(near[2], near[3]));
    const float least = smaller(smaller(far[0], far[1]), smaller(far[2], far[3]));
    const float sum = b[2 * i] + b[2 * i + 1] + c[2 * i] + c[2 * i + 1];
    mean[i] = least >= 0.0f && most - least <= tolerance * most ? 0.25f * sum : -1.0f;
  }
}

struct DrawnColumn {
  const float *sin_phi, *cos_phi, *inverse;
  int points;
  float half;       // of a point, in pixels of the view, from the map's station
  Offset from_eye;  // of the map's station, in the column's frame
  float radius_m;   // of the circle of eyes
  float u;          // the column's place in the view, from its left border
};

// The points of a column in the view.
struct DrawnPoints {
  void resize(std::size_t points) {
    for (auto* values : {&pixel, &across, &down}) values->resize(points);
    inverse.resize(points);
  }
  std::vector<std::int32_t> pixel;
  std::vector<std::int32_t> across, down;  // pixels on either side that a point covers too
  std::vector<float> inverse;
};

// Pixels that a point covers beside its own, if `half` lie from its middle to its end: what is
// closed afterwards need not be drawn.
RAYWALK_INLINE std::int32_t covered(float half, float most) {
  return half < 1.5f ? 0 : static_cast<std::int32_t>(half < most ? half : most);
}

// A point is seen in the column whose eye sees it: the ray touches the circle of eyes, so that it
// is turned by asin(radius / plan distance) against the direction from the centre, and the plan
// distance from the eye is the other leg (core/geometry/eye_circle.h).
RAYWALK_VECTOR_CLONES void project(DrawnColumn column, PanoramaSize view, std::int32_t* pixel,
                                   std::int32_t* across, std::int32_t* down, float* inverse) {
  const auto width = static_cast<float>(view.width);
  const float per_turn = width / static_cast<float>(kTwoPi);
  const float per_phi = static_cast<float>(view.height) / static_cast<float>(kPi);
  const float *const sin_phi = column.sin_phi, *const cos_phi = column.cos_phi;
  RAYWALK_INDEPENDENT
  for (int i = 0; i < column.points; ++i) {
    const float w = column.inverse[i];
    const float ahead = cos_phi[i] + w * column.from_eye.ahead;
    const float aside = w * column.from_eye.aside;
    const float up = sin_phi[i] + w * column.from_eye.up;
    const float radius = w * column.radius_m;
    const float leg = ahead * ahead + aside * aside - radius * radius;
    const float plan = std::sqrt(leg > 0.0f ? leg : 0.0f);
    // The sum of atan2(aside, ahead) and atan2(radius, plan).
    const float turn = fast_atan2(aside * plan + ahead * radius, ahead * plan - aside * radius);
    const float length = std::sqrt(plan * plan + up * up) + 1e-30f;
    float u = column.u + turn * per_turn;
    u += u < 0.0f ? width : 0.0f;
    u -= u >= width ? width : 0.0f;
    const float v = (static_cast<float>(kHalfPi) - fast_atan2(up, plan)) * per_phi;
    const int x = u < 0.0f ? 0 : static_cast<int>(u), y = v < 0.0f ? 0 : static_cast<int>(v);
    pixel[i] = (x > view.width - 1 ? view.width - 1 : x) * view.height +
               (y > view.height - 1 ? view.height - 1 : y);
    across[i] = covered(column.half * cos_phi[i] / (plan + 1e-6f), width / 16.0f);
    down[i] = covered(column.half / length, 8.0f);
    // What is inside the circle no eye sees.
    inverse[i] = leg >= 0.0f ? w / length : -1.0f;
  }
}

// Draws the points of a column, the nearest surface staying.
void draw_points(const DrawnPoints& points, PanoramaSize view, float* image) {
  for (std::size_t i = 0; i < points.pixel.size(); ++i) {
    const float inverse = points.inverse[i];
    const int across = points.across[i], down = points.down[i];
    float& middle = image[points.pixel[i]];
    middle = std::max(middle, inverse);
    if ((across | down) == 0 || inverse < 0.0f) continue;
    const int u = points.pixel[i] / view.height, v = points.pixel[i] % view.height;
    for (int x = u - across; x <= u + across; ++x) {
      float* const pixels = image + wrapped_column(x, view.width) * view.height;
      for (int y = std::max(0, v - down); y <= std::min(view.height - 1, v + down); ++y) {
        pixels[y] = std::max(pixels[y], inverse);
      }
    }
  }
}

}  // namespace

MapPoints::MapPoints(std::span<const float> of_map, PanoramaSize of_size) : size(of_size) {
  const auto rows = static_cast<std::size_t>(size.height);
  const bool halves = size.width % 2 == 0 && size.height % 2 == 0;
  const float tolerance = surface_tolerance_of(size.width);
  const Latitudes latitudes(size.height), between(size.height / 2);
  const auto column = [&](int theta) {
    return of_map.data() + static_cast<std::size_t>(wrapped_column(theta, size.width)) * rows;
  };
  std::vector<float> nearest(rows), farthest(rows), single(rows), mean(rows / 2 + 1, -1.0f);
  for (int theta = 0; theta < size.width; ++theta) {
    if (halves && theta % 2 == 0) {
      average_surfaces({column(theta - 1), column(theta), column(theta + 1), column(theta + 2)},
                       size.height, tolerance, nearest.data(), farthest.data(), mean.data());
      add_column(theta + 0.5, 2, std::span(mean).first(rows / 2), between);
    }
    for (std::size_t row = 0; row < rows; ++row) {
      single[row] = mean[row / 2] < 0.0f ? column(theta)[row] : -1.0f;
    }
    add_column(theta, 1, single, latitudes);
  }
}

void MapPoints::draw(const Eigen::Vector3d& map_m, const EyeCircle& eye, PanoramaSize view,
                     float* image) const {
  const float scale = static_cast<float>(view.width) / static_cast<float>(size.width);
  DrawnPoints points;
  for (const Column& of_map : columns) {
    const std::size_t from = of_map.begin;
    const DrawnColumn column{
        .sin_phi = sin_phi.data() + from,
        .cos_phi = cos_phi.data() + from,
        .inverse = inverse.data() + from,
        .points = static_cast<int>(of_map.end - from),
        .half = 0.5f * static_cast<float>(of_map.pixels) * scale,
        .from_eye = offset_in_column(map_m - eye.centre_m, theta_of_column(of_map.u, size.width)),
        .radius_m = static_cast<float>(eye.radius_m),
        .u = (static_cast<float>(of_map.u) + 0.5f) * scale};
    points.resize(of_map.end - from);
    project(column, view, points.pixel.data(), points.across.data(), points.down.data(),
            points.inverse.data());
    draw_points(points, view, image);
  }
}

void MapPoints::add_column(double u, int pixels, std::span<const float> inverse_of_rows,
                           const Latitudes& latitudes) {
  const std::size_t begin = inverse.size();
  for (std::size_t row = 0; row < inverse_of_rows.size(); ++row) {
    if (inverse_of_rows[row] < 0.0f) continue;
    sin_phi.push_back(latitudes.sin_phi[row]);
    cos_phi.push_back(latitudes.cos_phi[row]);
    inverse.push_back(inverse_of_rows[row]);
  }
  columns.push_back({u, pixels, begin, inverse.size()});
}

}  // namespace raywalk
