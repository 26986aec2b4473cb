#include "tests/bench/plain_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "core/geometry/grid.h"

namespace raywalk::bench {
namespace {

constexpr float kDistance_m = 2.0f;
constexpr auto kPiOfFloat = static_cast<float>(kPi);

struct NearStation {
  const std::uint8_t* rays = nullptr;  // rgb, [theta][phi]
  cv::Vec3f from_eye_m{};              // x, y, z
  float weight = 0.0f;
};

// The two stations around the place where a plan direction crosses the cell's border.
std::array<NearStation, 2> stations_around(const Room& room, PlanPoint eye, double theta_rad) {
  const double dx = std::sin(theta_rad), dz = std::cos(theta_rad);
  double nearest_m = std::numeric_limits<double>::infinity(), along_m = 0.0;
  int crossed = 0;
  for (const int index : room.grid().cells.front().line) {
    const Line& line = room.grid().lines[static_cast<std::size_t>(index)];
    const double x = line.origin.x_m - eye.x_m, z = line.origin.z_m - eye.z_m;
    const double across = dx * line.direction.z_m - dz * line.direction.x_m;
    const double ahead_m = (x * line.direction.z_m - z * line.direction.x_m) / across;
    if (!(ahead_m > 0.0 && ahead_m < nearest_m)) continue;
    nearest_m = ahead_m;
    along_m = (x * dz - z * dx) / across;
    crossed = index;
  }
  const std::vector<Station>& all = room.grid().lines[static_cast<std::size_t>(crossed)].stations;
  const auto after = std::upper_bound(all.begin() + 1, all.end() - 1, along_m,
                                      [](double m, const Station& s) { return m < s.along_m; });
  const double gap_m = after->along_m - (after - 1)->along_m;
  const double part = std::clamp((along_m - (after - 1)->along_m) / gap_m, 0.0, 1.0);
  std::array<NearStation, 2> two;
  for (int i = 0; i < 2; ++i) {
    const auto station = after - 1 + i;
    const Eigen::Vector3d& at = station->position_m;
    NearStation& near = two[static_cast<std::size_t>(i)];
    near.rays = room.volume(crossed).rays(static_cast<int>(station - all.begin()));
    near.from_eye_m = {static_cast<float>(at.x() - eye.x_m), 0.0f,
                       static_cast<float>(at.z() - eye.z_m)};
    near.weight = static_cast<float>(i == 0 ? 1.0 - part : part);
  }
  return two;
}

cv::Vec3f sample(const NearStation& station, PanoramaSize size, const cv::Vec3f& point_m) {
  const cv::Vec3f to = point_m - station.from_eye_m;
  const auto width = static_cast<float>(size.width), height = static_cast<float>(size.height);
  const float across_m = std::sqrt(to[0] * to[0] + to[2] * to[2]);
  const float u = (std::atan2(to[0], to[2]) / (2.0f * kPiOfFloat) + 0.5f) * width - 0.5f + width;
  const float v = std::clamp((0.5f - std::atan2(to[1], across_m) / kPiOfFloat) * height - 0.5f,
                             0.0f, height - 1.001f);
  const int left = static_cast<int>(u), upper = static_cast<int>(v);
  const float part_u = u - static_cast<float>(left), part_v = v - static_cast<float>(upper);
  cv::Vec3f sum;
  for (int i = 0; i < 2; ++i) {
    const std::uint8_t* const pixel =
        station.rays +
        3 * (static_cast<std::ptrdiff_t>((left + i) % size.width) * size.height + upper);
    const float weight = i == 0 ? 1.0f - part_u : part_u;
    for (int c = 0; c < 3; ++c) {
      const auto above = static_cast<float>(pixel[c]), below = static_cast<float>(pixel[3 + c]);
      sum[c] += weight * (above + part_v * (below - above));
    }
  }
  return sum;
}

}  // namespace

void render_plainly(const Room& room, PlanPoint viewpoint, cv::Mat3b& to) {
  const PanoramaSize size = room.panorama();
  to.create(size.width, size.height);
  parallel_for(0, size.width, 16, [&](int begin, int end) {
    for (int u = begin; u < end; ++u) {
      const double theta_rad = (u + 0.5) / size.width * kTwoPi - kPi;
      const auto stations = stations_around(room, viewpoint, theta_rad);
      const auto dx = static_cast<float>(std::sin(theta_rad));
      const auto dz = static_cast<float>(std::cos(theta_rad));
      for (int v = 0; v < size.height; ++v) {
        const float phi_rad =
            (0.5f - (static_cast<float>(v) + 0.5f) / static_cast<float>(size.height)) * kPiOfFloat;
        const float across = std::cos(phi_rad);
        const cv::Vec3f point_m =
            kDistance_m * cv::Vec3f(across * dx, std::sin(phi_rad), across * dz);
        cv::Vec3f rgb;
        for (const NearStation& station : stations) {
          rgb += station.weight * sample(station, size, point_m);
        }
        to(u, v) = rgb;
      }
    }
  });
}

}  // namespace raywalk::bench
