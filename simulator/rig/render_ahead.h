// Renders what the camera will see at the end of a move while the carriage is still on its way.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <thread>

#include "simulator/room/cameras.h"

namespace raywalk::capture {

// What the camera sees, and from where exactly (world frame, metres). Views of one pose share the
// image: do not write to it.
struct SceneView {
  CameraPose pose{};
  cv::Mat image{};  // as rendered: size and type are those of Render's result
};

// Thread-safe. One thread of its own renders the latest expected pose.
class RenderAhead {
 public:
  using Render = std::function<cv::Mat(const CameraPose&)>;

  // An expected pose is as good as the true one if its position is at most `tolerance_mm` away (0:
  // never) and its attitude the same. `render` is called from two threads, possibly at once; what
  // it throws while rendering ahead is dropped, as view() then calls it again.
  RenderAhead(Render render, double tolerance_mm);
  // Waits for a picture in progress.
  ~RenderAhead();
  RenderAhead(const RenderAhead&) = delete;
  RenderAhead& operator=(const RenderAhead&) = delete;

  // Starts rendering; replaces the pose expected before. Returns at once.
  void expect(const CameraPose& pose);

  // The view from `pose`, or from the expected pose if that is as good. Throws as `render` does.
  SceneView view(const CameraPose& pose);

 private:
  void work();
  bool is_expected_locked(const CameraPose& pose) const;

  const Render render_;
  const double tolerance_mm_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<CameraPose> expected_;
  cv::Mat image_;        // from the expected pose; empty until rendered
  bool wanted_ = false;  // the expected pose is still to be rendered
  bool ended_ = false;
  std::thread worker_;  // last, as it uses all of the above
};

}  // namespace raywalk::capture
