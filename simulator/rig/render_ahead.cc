#include "simulator/rig/render_ahead.h"

#include <chrono>
#include <cmath>
#include <utility>

#include "capture/base/units.h"

namespace raywalk::simulator {
namespace {

// A hundredth of a pixel in a panorama 16384 wide. Poses of different lines that cross differ more.
constexpr double kSameAttitude_rad = 4e-6;

bool is_same(const Attitude& a, const Attitude& b) {
  return std::abs(a.yaw_rad - b.yaw_rad) <= kSameAttitude_rad &&
         std::abs(a.pitch_rad - b.pitch_rad) <= kSameAttitude_rad &&
         std::abs(a.roll_rad - b.roll_rad) <= kSameAttitude_rad;
}

}  // namespace

void RenderAhead::expect(const CameraPose& pose) {
  if (tolerance_mm_ <= 0.0) return;
  const std::lock_guard lock(mutex_);
  std::erase_if(images_, [](const Image& image) {
    return image.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  });
  expected_ = pose;
  images_.push_back(std::async(std::launch::async, render_, pose).share());
}

bool RenderAhead::is_expected(const CameraPose& pose) const {
  return !images_.empty() && is_same(expected_.attitude, pose.attitude) &&
         kMillimetresPerMetre * (expected_.position_m - pose.position_m).norm() <= tolerance_mm_;
}

SceneView RenderAhead::view(const CameraPose& pose) {
  std::unique_lock lock(mutex_);
  if (!is_expected(pose)) {
    lock.unlock();
    return {pose, render_(pose)};
  }
  const CameraPose expected = expected_;
  const Image image = images_.back();
  lock.unlock();
  return {expected, image.get()};
}

}  // namespace raywalk::simulator
