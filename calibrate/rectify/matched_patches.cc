#include "calibrate/rectify/matched_patches.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace raywalk::calibrate {
namespace {

// Largest parallax searched for, baseline / distance.
constexpr double kMaxParallax = 0.5;
// Where a surface without parallax is taken to be, metres.
constexpr double kFarthest_m = 1e4;
// Spacing of the distances tried, in pixels of parallax.
constexpr double kStep_px = 0.75;
// Least correlation of the same surface, and how closely the search must come back.
constexpr double kLeastCorrelation = 0.9;
constexpr double kBack_px = 0.5;

// Directions of a patch's samples from the station it is taken at; unit vectors to first order.
// `stride` > 1 takes every n-th of them.
template <int kStride>
struct PatchRays {
  static constexpr int kSide = 2 * (kPatchRadius_px / kStride) + 1;
  static constexpr int kCount = kSide * kSide;
  std::array<Eigen::Vector3d, kCount> rays;

  PatchRays(const Eigen::Vector3d& centre, double pixel_rad) {
    const Eigen::Vector3d across = centre.unitOrthogonal();
    const Eigen::Vector3d along = centre.cross(across);
    int i = 0;
    for (int a = -kPatchRadius_px; a <= kPatchRadius_px; a += kStride) {
      for (int b = -kPatchRadius_px; b <= kPatchRadius_px; b += kStride) {
        rays[static_cast<std::size_t>(i++)] = centre + pixel_rad * (a * across + b * along);
      }
    }
  }
};

// Grey levels less their mean, divided by their norm; zero without contrast.
template <int kCount>
class Pattern {
 public:
  template <typename RayOf>
  Pattern(const ComparedPanorama& panorama, RayOf ray_of) {
    for (int i = 0; i < kCount; ++i) values_[i] = panorama.grey(ray_of(i));
    values_ -= values_.mean();
    contrast_ = std::sqrt(values_.square().sum());
    if (contrast_ > 0.0F) values_ /= contrast_;
  }
  double correlation(const Pattern& other) const {
    return static_cast<double>((values_ * other.values_).sum());
  }

 private:
  Eigen::Array<float, kCount, 1> values_;
  float contrast_ = 0.0F;
};

// The vertex of the parabola through three equidistant values, in steps from the middle one.
double vertex(double before, double middle, double after) {
  const double bend = before - 2.0 * middle + after;
  return bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -1.0, 1.0) : 0.0;
}

// A patch of one panorama, looked for in another.
class PatchSearch {
 public:
  PatchSearch(const ComparedPanorama& from, const ComparedPanorama& to)
      : from_(from), to_(to), baseline_m_((to.position_m() - from.position_m()).norm()) {
    if (baseline_m_ > 0.0) heading_ = (to.position_m() - from.position_m()) / baseline_m_;
  }

  struct Found {
    double parallax = 0.0;  // baseline / distance
    double correlation = 0.0;
  };
  // nullopt if it is nowhere, or at the end of the distances tried.
  std::optional<Found> find(const Eigen::Vector3d& centre) const {
    const double step = kStep_px * from_.pixel_rad();
    // Stations at one place have no parallax.
    const int steps = baseline_m_ > 0.0 ? static_cast<int>(kMaxParallax / step) : 0;
    const PatchRays<2> coarse(centre, from_.pixel_rad());
    const Pattern<PatchRays<2>::kCount> pattern = pattern_of(from_, coarse);
    int best = 0;
    double most = -1.0;
    for (int i = 0; i <= steps; ++i) {
      const double correlation = pattern.correlation(moved_pattern(coarse, i * step));
      if (correlation > most) {
        most = correlation;
        best = i;
      }
    }
    if (best > 0 && best == steps) return std::nullopt;
    return refine(centre, best * step, step);
  }

  // The direction from `to`, of any length, of what `from` sees along `ray`.
  Eigen::Vector3d seen_there(const Eigen::Vector3d& ray, double parallax) const {
    return ray - parallax * heading_;
  }
  double ahead(const Eigen::Vector3d& ray) const { return std::abs(ray.dot(heading_)); }
  // The distance from `from`, metres.
  double distance_m(double parallax) const {
    return parallax * kFarthest_m > baseline_m_ ? baseline_m_ / parallax : kFarthest_m;
  }

 private:
  template <int kStride>
  static Pattern<PatchRays<kStride>::kCount> pattern_of(const ComparedPanorama& panorama,
                                                        const PatchRays<kStride>& patch) {
    return {panorama, [&](int i) { return patch.rays[static_cast<std::size_t>(i)]; }};
  }
  template <int kStride>
  Pattern<PatchRays<kStride>::kCount> moved_pattern(const PatchRays<kStride>& patch,
                                                    double parallax) const {
    return {to_,
            [&](int i) { return seen_there(patch.rays[static_cast<std::size_t>(i)], parallax); }};
  }
  // All samples, at steps of half and a quarter of the first.
  Found refine(const Eigen::Vector3d& centre, double parallax, double first_step) const {
    const PatchRays<1> fine(centre, from_.pixel_rad());
    const Pattern<PatchRays<1>::kCount> pattern = pattern_of(from_, fine);
    const auto at = [&](double place) { return pattern.correlation(moved_pattern(fine, place)); };
    for (const double step : {first_step, 0.5 * first_step}) {
      parallax += step * vertex(at(parallax - step), at(parallax), at(parallax + step));
    }
    return {parallax, at(parallax)};
  }

  const ComparedPanorama& from_;
  const ComparedPanorama& to_;
  double baseline_m_;
  Eigen::Vector3d heading_{0, 0, 0};  // unit vector; zero without a baseline
};

// The light of a patch in both panoramas, and its contrast.
struct PatchLight {
  Eigen::Array3d from{0, 0, 0}, to{0, 0, 0};
  double contrast = 0.0;  // standard deviation of the light over its mean
};

// nullopt if more than a third of the patch is not usable in both, or either hides some of it.
std::optional<PatchLight> light_of(const ComparedPanorama& from, const ComparedPanorama& to,
                                   const PatchSearch& search, const Eigen::Vector3d& centre,
                                   double parallax) {
  const PatchRays<1> patch(centre, from.pixel_rad());
  PatchLight light;
  double squares = 0.0, sum = 0.0;
  int count = 0;
  for (const Eigen::Vector3d& ray : patch.rays) {
    Eigen::Array3d here, there;
    if (from.hidden(ray) || to.hidden(search.seen_there(ray, parallax))) return std::nullopt;
    if (!from.light(ray, &here)) continue;
    if (!to.light(search.seen_there(ray, parallax), &there)) continue;
    light.from += here;
    light.to += there;
    sum += here.mean();
    squares += here.mean() * here.mean();
    ++count;
  }
  if (3 * count < 2 * kPatchSamples) return std::nullopt;
  light.contrast = std::sqrt(std::max(0.0, count * squares / (sum * sum) - 1.0));
  return light;
}

double error_of(double correlation, double contrast) {
  // Of the light itself, even of a perfect match: rounding and noise.
  constexpr double kFloor = 0.002;
  // What does not correlate is correlated over about a quarter of the patch.
  constexpr double kIndependentParts = 4.0;
  return std::hypot(
      contrast * std::sqrt(std::max(0.0, 1.0 - correlation * correlation) / kIndependentParts),
      kFloor);
}

void add_matches(const ComparedPanorama& from, const ComparedPanorama& to, bool reversed,
                 std::vector<MatchedPatch>* patches) {
  const PatchSearch there(from, to), back(to, from);
  for (const Eigen::Vector3d& centre : from.textured()) {
    const auto found = there.find(centre);
    if (!found || found->correlation < kLeastCorrelation) continue;
    const Eigen::Vector3d seen = there.seen_there(centre, found->parallax).normalized();
    const auto returned = back.find(seen);
    if (!returned) continue;
    const Eigen::Vector3d start = back.seen_there(seen, returned->parallax).normalized();
    if ((start - centre).norm() > kBack_px * from.pixel_rad()) continue;
    const auto light = light_of(from, to, there, centre, found->parallax);
    if (!light) continue;
    const Eigen::Array3d log_ratio = (light->to / light->from).log();
    MatchedPatch patch{.point_m = from.position_m() + there.distance_m(found->parallax) * centre,
                       .log_ratio = log_ratio,
                       .error = error_of(found->correlation, light->contrast),
                       .parallax = found->parallax,
                       .ahead = there.ahead(centre),
                       .seen_from = from.seen_by_camera(centre),
                       .seen_to = to.seen_by_camera(seen)};
    if (reversed) {
      patch.log_ratio = -log_ratio;
      std::swap(patch.seen_from, patch.seen_to);
    }
    patches->push_back(patch);
  }
}

}  // namespace

std::vector<MatchedPatch> match_patches(const ComparedPanorama& from, const ComparedPanorama& to) {
  std::vector<MatchedPatch> patches;
  add_matches(from, to, false, &patches);
  add_matches(to, from, true, &patches);
  return patches;
}

}  // namespace raywalk::calibrate
