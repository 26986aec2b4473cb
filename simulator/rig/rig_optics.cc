#include "simulator/rig/rig_optics.h"

#include <array>
#include <cmath>
#include <memory>

#include "core/base/error.h"
#include "core/files/lens_file.h"
#include "simulator/room/hash_random.h"
#include "simulator/room/sensor.h"
#include "simulator/room/shapes.h"

namespace raywalk::simulator {
namespace {

DualFisheyeLayout lenses_of(const std::filesystem::path& file, PanoramaSize frame) {
  if (file.empty()) return simple_dual_fisheye(frame);
  const DualFisheyeCamera camera = read_lens_file(file);
  if (camera.two_files) {
    throw UsageError(file.string() +
                     ": is for a camera with two files per shot; the simulated one writes a single "
                     "file and needs 'two_files: false'");
  }
  try {
    return scaled_to(camera, frame).layout;
  } catch (const Error& e) {
    throw UsageError(file.string() + ": " + e.what());
  }
}

std::unique_ptr<const PixelRays> rays_of(const std::optional<DualFisheyeLayout>& lenses,
                                         PanoramaSize frame) {
  if (lenses) return std::make_unique<DualFisheyeRays>(*lenses, frame);
  return std::make_unique<PanoramaRays>(frame);
}

using Eigen::Vector3d;

enum Finish { kSteel, kWood, kRubber, kAluminium };

// Scratched and dirty, in the order of Finish.
std::vector<Surface> finishes(double floor_m) {
  const std::array colors{Color(0.10F, 0.11F, 0.13F), Color(0.36F, 0.20F, 0.09F),
                          Color(0.03F, 0.03F, 0.03F), Color(0.45F, 0.46F, 0.48F)};
  std::vector<Surface> surfaces(colors.size());
  for (std::size_t i = 0; i < colors.size(); ++i) {
    surfaces[i].pattern = i == kWood ? Pattern::kBoards : Pattern::kPlaster;
    surfaces[i].base = colors[i];
    surfaces[i].accent = 0.7F * colors[i];
    surfaces[i].period = static_cast<float>(0.09 * floor_m);
    surfaces[i].seed = 71U + static_cast<std::uint32_t>(i);
  }
  return surfaces;
}

}  // namespace

RigOptics::RigOptics(const RigCameraSettings& camera, PanoramaSize frame,
                     const DollySettings& dolly, double floor_m, int seed)
    : camera_(camera), seed_(seed) {
  if (camera.layout == FrameKind::kDualFisheye) lenses_ = lenses_of(camera.lens, frame);
  rays_ = rays_of(lenses_, frame);
  if (lenses_ && !camera.light.is_even()) {
    light_ = lens_light(*lenses_, frame, camera.light);
  }
  if (dolly.visible) dolly_ = make_dolly(dolly, floor_m);
}

cv::Mat RigOptics::scene(const VirtualRoom& room, const CameraPose& pose) const {
  return room.render(*rays_, pose, {.carried = &dolly_});
}

cv::Mat RigOptics::picture(const cv::Mat& scene, const ExposureNow& exposure) const {
  const double drift_ev = camera_.exposure_drift_ev * exposure_drift(exposure.number, seed_);
  const std::uint64_t key = hash_bits(static_cast<std::uint64_t>(seed_), exposure.number);
  return apply_sensor(scene, camera_.sensor, exposure.gain * std::exp2(drift_ev), key, light_);
}

Facets make_dolly(const DollySettings& dolly, double floor_m) {
  if (!(floor_m > 0.0)) throw Error("the camera on a dolly must be above the floor");
  // In units of the floor's distance.
  constexpr double kTop = -0.86, kBottom = -0.90, kWheel = 0.05, kRailTop = -0.97, kPlate = -0.11;
  const double reach = std::tan(radians_from_degrees(dolly.reach_deg));
  const double half = -kTop * reach;
  Facets made{finishes(floor_m), {}};
  std::vector<Facet>* facets = &made.facets;
  const auto rod = [&](const Vector3d& from, const Vector3d& to, double radius, Finish finish) {
    add_rod({}, {floor_m * from, floor_m * to, floor_m * radius, floor_m * radius}, finish, facets);
  };
  const auto box = [&](const Vector3d& min, const Vector3d& max, Finish finish) {
    add_box({}, floor_m * min, floor_m * max, finish, facets);
  };
  // The plate hides a little more than the pole.
  rod({0, kPlate, 0}, {0, kPlate + 0.01, 0}, 0.055 * reach, kSteel);
  rod({0, kTop, 0}, {0, kPlate, 0}, 0.018, kAluminium);
  box({-half, kBottom, -half}, {half, kTop, half}, kWood);
  box({-0.06, -1.0, -1.1 * half}, {0.06, kRailTop, 1.1 * half}, kSteel);
  for (const double x : {-half, half}) {
    for (const double z : {-0.7 * half, 0.7 * half}) {
      rod({x - 0.03, kWheel - 1.0, z}, {x + 0.03, kWheel - 1.0, z}, kWheel, kRubber);
    }
  }
  return made;
}

double exposure_drift(std::uint64_t picture, int seed) {
  // Two waves with incommensurate periods, so that it does not repeat within a session.
  struct Wave {
    double share;
    double period;  // pictures
  };
  constexpr std::array<Wave, 2> kWaves{{{0.65, 97.3}, {0.35, 41.7}}};
  HashRandom random(hash_bits(static_cast<std::uint64_t>(seed), 0xd21f7));
  double sum = 0.0;
  for (const Wave& wave : kWaves) {
    const double phase = random.uniform(0.0, kTwoPi);
    sum += wave.share * std::sin(kTwoPi * static_cast<double>(picture) / wave.period + phase);
  }
  return sum;
}

}  // namespace raywalk::simulator
