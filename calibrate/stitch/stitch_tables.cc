#include "calibrate/stitch/stitch_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace raywalk::calibrate {
namespace {

// Cubics read two pixels further, and the outermost pixel of an image circle is dim.
constexpr double kRim_px = 3.0;
constexpr int kRowsAtOnce = 16;

// The blend across the seam, radians.
struct SeamRamp {
  double rim_rad = 0.0;    // of the overlap that is not used, on each side
  double half_rad = 0.0;   // half the width of the ramp
  double reach_rad = 0.0;  // from the seam to where both lenses are read

  // Half the difference of the margins is the angle from the seam; half their sum is the half
  // width of the overlap.
  unsigned char region_of(const std::optional<LensImage>& in_front,
                          const std::optional<LensImage>& in_back, float* front_weight) const {
    *front_weight = in_front ? 1.0F : 0.0F;
    if (!in_back) return kFrontOnly;
    if (!in_front) return kBackOnly;
    const double from_seam = 0.5 * (in_front->margin_rad - in_back->margin_rad);
    const double overlap = 0.5 * (in_front->margin_rad + in_back->margin_rad) - rim_rad;
    const double ramp = std::min(half_rad, overlap);
    *front_weight =
        static_cast<float>(ramp > 0.0 ? std::clamp(0.5 + 0.5 * from_seam / ramp, 0.0, 1.0)
                                      : (from_seam >= 0.0 ? 1.0 : 0.0));
    if (std::abs(from_seam) < std::min(reach_rad, overlap)) return kBothLenses;
    return from_seam >= 0.0 ? kFrontOnly : kBackOnly;
  }
};

void set(const LensImage& image, int row, int column, LensSamples* of) {
  of->positions.at<cv::Vec2f>(row, column) = {static_cast<float>(image.pixel.u),
                                              static_cast<float>(image.pixel.v)};
  of->roots.at<float>(row, column) = static_cast<float>(image.root);
}

// Pixels extend half a pixel beyond their centres.
bool is_within(PixelPosition pixel, PanoramaSize picture) {
  return pixel.u >= -0.5 && pixel.v >= -0.5 && pixel.u <= picture.width - 0.5 &&
         pixel.v <= picture.height - 0.5;
}

}  // namespace

LensView::LensView(const DualFisheyeCamera& camera, bool back, double distance_m)
    : camera_(camera),
      lens_(back ? camera.layout.back : camera.layout.front),
      lens_from_camera_(Eigen::Matrix3d::Identity()),
      position_m_(back ? camera.layout.back_position_m : camera.layout.front_position_m),
      distance_m_(distance_m) {
  if (back) lens_from_camera_ = world_from_camera(camera.layout.back_attitude).transpose();
}

std::optional<LensImage> LensView::look(const Eigen::Vector3d& direction) const {
  const Eigen::Vector3d seen =
      lens_from_camera_ *
      (std::isinf(distance_m_) ? direction : distance_m_ * direction - position_m_);
  const auto pixel = project(lens_, seen);
  if (!pixel || !is_within(*pixel, camera_.picture)) return std::nullopt;
  const double angle = std::atan2(std::hypot(seen.x(), seen.y()), seen.z());
  LensImage image{*pixel, lens_.largest_angle_rad - angle};
  const bool falls_off = camera_.falloff_2 != 0.0 || camera_.falloff_4 != 0.0;
  if (falls_off) image.root = root_of_light(light_share(camera_, angle));
  return image;
}

StitchTables make_stitch_tables(const DualFisheyeCamera& camera, PanoramaSize size,
                                const StitcherOptions& options,
                                const Eigen::Matrix3d& world_from_camera) {
  StitchTables tables;
  tables.size = size;
  tables.region.create(size.height, size.width, CV_8UC1);
  tables.front_weight.create(size.height, size.width, CV_32FC1);
  for (LensSamples* lens : {&tables.front, &tables.back}) {
    lens->positions = cv::Mat::zeros(size.height, size.width, CV_32FC2);
    lens->roots = cv::Mat::ones(size.height, size.width, CV_32FC1);
  }
  const LensView front(camera, false, options.seam_distance_m);
  const LensView back(camera, true, options.seam_distance_m);
  const double half_rad = radians_from_degrees(0.5 * options.blend_deg);
  const SeamRamp ramp{
      .rim_rad = kRim_px / std::min(front.lens().focal_px, back.lens().focal_px),
      .half_rad = half_rad,
      // The coarse bands of multi-band blending extend half a ramp beyond the ramp on each side.
      .reach_rad = options.blend == BlendMethod::kFeather ? half_rad : 2.0 * half_rad};
  const Eigen::Matrix3d camera_from_world = world_from_camera.transpose();
  const Eigen::Vector3d upwards = camera_from_world.col(1);
  std::vector<Eigen::Vector3d> horizon;  // by column: its direction at the horizon
  horizon.reserve(static_cast<std::size_t>(size.width));
  for (int column = 0; column < size.width; ++column) {
    const SphereAngles angles = angles_from_pixel({static_cast<double>(column), 0.0}, size);
    horizon.emplace_back(camera_from_world * direction_from_angles({angles.theta_rad, 0.0}));
  }
  std::vector<double> unseen(static_cast<std::size_t>(size.height));  // share of all directions
  parallel_for(0, size.height, kRowsAtOnce, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      auto* region = tables.region.ptr<unsigned char>(row);
      auto* weight = tables.front_weight.ptr<float>(row);
      const double phi_rad = angles_from_pixel({0.0, static_cast<double>(row)}, size).phi_rad;
      const double level = std::cos(phi_rad);
      const Eigen::Vector3d height = std::sin(phi_rad) * upwards;
      int unseen_pixels = 0;
      for (int column = 0; column < size.width; ++column) {
        const Eigen::Vector3d direction =
            level * horizon[static_cast<std::size_t>(column)] + height;
        const auto in_front = front.look(direction), in_back = back.look(direction);
        if (!in_front && !in_back) {
          ++unseen_pixels;
          continue;
        }
        region[column] = ramp.region_of(in_front, in_back, &weight[column]);
        if (region[column] != kBackOnly) set(*in_front, row, column, &tables.front);
        if (region[column] != kFrontOnly) set(*in_back, row, column, &tables.back);
      }
      unseen[static_cast<std::size_t>(row)] =
          unseen_pixels * level * kHalfPi / (static_cast<double>(size.width) * size.height);
    }
  });
  const double unseen_share = std::accumulate(unseen.begin(), unseen.end(), 0.0);
  if (unseen_share > 0.0) {
    throw Error(
        fmt::format("the two lenses leave a gap of {:.2g} % of all directions between "
                    "them; increase largest_angle_deg of both until they overlap",
                    100.0 * unseen_share));
  }
  return tables;
}

}  // namespace raywalk::calibrate
