#include "build_lf/exposure/patch_ratios.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <span>

#include "build_lf/depth/pixel_directions.h"
#include "core/base/median.h"
#include "core/room/station_image.h"

namespace raywalk::build_lf {
namespace {

// A pixel of `from` as `to` would see it.
struct Projection {
  bool known = false;
  std::size_t pixel = 0;  // of `to`
  float inverse = 0.0F;   // inverse distance from `to`, 1/m
};

// The largest difference of inverse distances that counts as one surface: two pixels of parallax
// between the stations. Both maps are off by up to a pixel.
double tolerance_per_m(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m,
                       PanoramaSize size) {
  constexpr double kAgreePx = 2.0;
  constexpr double kSamePlaceM = 1e-6;
  return kAgreePx * kTwoPi / size.width / std::max((to_m - from_m).norm(), kSamePlaceM);
}

std::vector<Projection> project(const InverseDistanceMap& map, const Eigen::Vector3d& to_m) {
  const PanoramaSize size = map.size;
  const PixelDirections directions(size);
  std::vector<Projection> projections(map.inverse.size());
  const Eigen::Vector3f towards = (map.position_m - to_m).cast<float>();
  for (int theta = 0; theta < size.width; ++theta) {
    for (int phi = 0; phi < size.height; ++phi) {
      const std::size_t pixel = pixel_index(theta, phi, size);
      if (map.confidence[pixel] < kMinConfidence) continue;
      const float inverse = map.inverse[pixel];
      // The point at distance 1 / inverse, times inverse: finite for infinite distances too.
      const Eigen::Vector3f seen = directions.of(theta, phi) + inverse * towards;
      projections[pixel] = {true, pixel_of(seen, size), inverse / seen.norm()};
    }
  }
  return projections;
}

// Forgets the surfaces that another one hides from `to`: the nearest at each of its pixels stays.
void remove_hidden(double tolerance, const std::optional<InverseDistanceMap>& to_map,
                   std::vector<Projection>* projections) {
  std::vector<float> nearest(projections->size(), 0.0F);
  for (const Projection& p : *projections) {
    if (!p.known) continue;
    nearest[p.pixel] = std::max(nearest[p.pixel], p.inverse);
  }
  for (Projection& p : *projections) {
    if (!p.known) continue;
    if (nearest[p.pixel] - p.inverse > tolerance) p.known = false;
    if (!to_map) continue;
    if (to_map->confidence[p.pixel] < kMinConfidence ||
        std::fabs(to_map->inverse[p.pixel] - p.inverse) > tolerance) {
      p.known = false;
    }
  }
}

struct Sample {
  int patches = 0;  // from * kPatches + to
  std::array<float, 3> log_ratio{};
};

int patch_of(int theta, int phi, PanoramaSize size) {
  return theta * kPatchesTheta / size.width * kPatchesPhi + phi * kPatchesPhi / size.height;
}

std::vector<Sample> sample(const StationSurfaces& from, const StationSurfaces& to,
                           PanoramaSize size, const std::vector<Projection>& projections) {
  std::vector<Sample> samples;
  for (int theta = 0; theta < size.width; ++theta) {
    for (int phi = 0; phi < size.height; ++phi) {
      const Projection& p = projections[pixel_index(theta, phi, size)];
      const auto height = static_cast<std::size_t>(size.height);
      const auto to_theta = static_cast<int>(p.pixel / height);
      const auto to_phi = static_cast<int>(p.pixel % height);
      if (!p.known || from.valid.at<uchar>(theta, phi) == 0 ||
          to.valid.at<uchar>(to_theta, to_phi) == 0) {
        continue;
      }
      const auto& a = from.colours.at<cv::Vec3b>(theta, phi);
      const auto& b = to.colours.at<cv::Vec3b>(to_theta, to_phi);
      Sample& s = samples.emplace_back();
      s.patches = patch_of(theta, phi, size) * kPatches + patch_of(to_theta, to_phi, size);
      for (int c = 0; c < 3; ++c) {
        s.log_ratio[static_cast<size_t>(c)] =
            std::log(static_cast<float>(b[c]) / static_cast<float>(a[c]));
      }
    }
  }
  return samples;
}

// The median of one channel's log ratios, and its standard error.
void summarise(std::span<const Sample> samples, size_t channel, PatchRatio* ratio) {
  std::vector<double> values;
  values.reserve(samples.size());
  for (const Sample& s : samples) values.push_back(static_cast<double>(s.log_ratio[channel]));
  const double middle = median(values);
  for (double& value : values) value = std::fabs(value - middle);
  // Neighbouring pixels share their errors, some four of them.
  constexpr double kSharing = 4.0;
  // Surfaces are not quite matt and distances not quite right: more pixels do not help further.
  constexpr double kModelError = 0.01;
  const double spread = std::max(robust_sigma(std::move(values)), kModelError);
  const double count = std::max(1.0, static_cast<double>(samples.size()) / kSharing);
  ratio->log_ratio[channel] = static_cast<float>(middle);
  ratio->error[channel] = static_cast<float>(std::hypot(spread / std::sqrt(count), kModelError));
}

}  // namespace

StationSurfaces station_surfaces(const Room& room, StationIndex station, const SurfaceMaps& maps) {
  // Levels near the ends of the range no longer follow the exposure.
  constexpr double kBlack = 8.0;
  constexpr double kClipped = 247.0;
  StationSurfaces surfaces;
  surfaces.position_m = room.grid().station(station).position_m;
  const cv::Mat captured = station_image(room, station, room.panorama());
  cv::Mat measurable;
  cv::inRange(captured, cv::Scalar::all(kBlack), cv::Scalar::all(kClipped), measurable);
  const cv::Size transposed(maps.size.height, maps.size.width);
  cv::Mat share;
  cv::resize(captured, surfaces.colours, transposed, 0, 0, cv::INTER_AREA);
  cv::resize(measurable, share, transposed, 0, 0, cv::INTER_AREA);
  surfaces.valid = share == 255;
  const cv::Mat unmasked = station_validity(room, station, maps.size, 1);
  if (!unmasked.empty()) surfaces.valid &= unmasked;
  if (!maps.valid.empty()) {
    cv::resize(maps.valid.t(), share, transposed, 0, 0, cv::INTER_AREA);
    surfaces.valid &= share == 255;
  }
  if (std::ranges::binary_search(maps.stations, station)) surfaces.map = maps.read(station);
  return surfaces;
}

std::vector<PatchRatio> compare_surfaces(const StationSurfaces& from, const StationSurfaces& to) {
  const InverseDistanceMap& map = *from.map;
  std::vector<Projection> projections = project(map, to.position_m);
  remove_hidden(tolerance_per_m(map.position_m, to.position_m, map.size), to.map, &projections);
  std::vector<Sample> samples = sample(from, to, map.size, projections);
  std::stable_sort(samples.begin(), samples.end(),
                   [](const Sample& a, const Sample& b) { return a.patches < b.patches; });
  std::vector<PatchRatio> ratios;
  constexpr size_t kFewest = 8;
  for (size_t begin = 0; begin < samples.size();) {
    size_t end = begin;
    while (end < samples.size() && samples[end].patches == samples[begin].patches) ++end;
    if (end - begin >= kFewest) {
      PatchRatio& ratio = ratios.emplace_back();
      ratio.from = samples[begin].patches / kPatches;
      ratio.to = samples[begin].patches % kPatches;
      for (size_t channel = 0; channel < 3; ++channel) {
        summarise({samples.data() + begin, end - begin}, channel, &ratio);
      }
    }
    begin = end;
  }
  return ratios;
}

}  // namespace raywalk::build_lf
