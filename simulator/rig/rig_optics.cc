#include "simulator/rig/rig_optics.h"

#include <array>
#include <cmath>
#include <memory>

#include "core/base/error.h"
#include "core/files/lens_file.h"
#include "simulator/room/hash_random.h"
#include "simulator/room/sensor.h"

namespace raywalk::capture {
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

}  // namespace

RigOptics::RigOptics(const RigCameraSettings& camera, PanoramaSize frame,
                     const DollySettings& dolly, double floor_m, int seed)
    : camera_(camera), seed_(seed) {
  if (camera.layout == FrameKind::kDualFisheye) lenses_ = lenses_of(camera.lens, frame);
  if (lenses_ && camera.light != LensLightSettings{}) {
    light_ = lens_light(*lenses_, frame, camera.light);
  }
  rays_ = rays_of(lenses_, frame);
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

}  // namespace raywalk::capture
