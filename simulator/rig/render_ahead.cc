#include "simulator/rig/render_ahead.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <exception>
#include <utility>

#include "capture/base/units.h"

namespace raywalk::capture {
namespace {

// A hundredth of a pixel in a panorama 16384 wide. Poses of different lines that cross differ more.
constexpr double kSameAttitude_rad = 4e-6;

bool is_same(const Attitude& a, const Attitude& b) {
  return std::abs(a.yaw_rad - b.yaw_rad) <= kSameAttitude_rad &&
         std::abs(a.pitch_rad - b.pitch_rad) <= kSameAttitude_rad &&
         std::abs(a.roll_rad - b.roll_rad) <= kSameAttitude_rad;
}

}  // namespace

RenderAhead::RenderAhead(Render render, double tolerance_mm)
    : render_(std::move(render)), tolerance_mm_(tolerance_mm), worker_([this] { work(); }) {}

RenderAhead::~RenderAhead() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  worker_.join();
}

void RenderAhead::expect(const CameraPose& pose) {
  if (tolerance_mm_ <= 0.0) return;
  {
    const std::lock_guard lock(mutex_);
    expected_ = pose;
    image_.release();
    wanted_ = true;
  }
  changed_.notify_all();
}

bool RenderAhead::is_expected_locked(const CameraPose& pose) const {
  return expected_ && is_same(expected_->attitude, pose.attitude) &&
         kMillimetresPerMetre * (expected_->position_m - pose.position_m).norm() <= tolerance_mm_;
}

SceneView RenderAhead::view(const CameraPose& pose) {
  {
    std::unique_lock lock(mutex_);
    if (is_expected_locked(pose)) {
      changed_.wait(lock, [&] { return !image_.empty() || !is_expected_locked(pose); });
      if (is_expected_locked(pose)) return {*expected_, image_};
    }
  }
  return {pose, render_(pose)};
}

void RenderAhead::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return wanted_ || ended_; });
    if (ended_) return;
    wanted_ = false;
    const CameraPose pose = *expected_;
    lock.unlock();
    cv::Mat image;
    try {
      image = render_(pose);
    } catch (const std::exception& e) {
      spdlog::debug("nothing can be rendered ahead: {}", e.what());
    }
    lock.lock();
    if (!wanted_) {
      image_ = image;
      if (image.empty()) expected_.reset();  // the camera meets the error itself
    }
    changed_.notify_all();
  }
}

}  // namespace raywalk::capture
