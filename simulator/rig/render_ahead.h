// Renders what the camera will see at the end of a move while the carriage is still on its way.
#pragma once

#include <functional>
#include <future>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "simulator/room/cameras.h"

namespace raywalk::simulator {

// What the camera sees, and from where exactly (world frame, metres). Views of one pose share the
// image: do not write to it.
struct SceneView {
  CameraPose pose{};
  cv::Mat image{};  // as rendered: size and type are those of Render's result
};

// Thread-safe.
class RenderAhead {
 public:
  using Render = std::function<cv::Mat(const CameraPose&)>;

  // An expected pose is as good as the true one if its position is at most `tolerance_mm` away (0:
  // never) and its attitude the same. `render` is called from several threads, possibly at once.
  RenderAhead(Render render, double tolerance_mm)
      : render_(std::move(render)), tolerance_mm_(tolerance_mm) {}

  // Starts rendering; replaces the pose expected before. Returns at once.
  void expect(const CameraPose& pose);

  // The view from `pose`, or from the expected pose if that is as good. Throws as `render` does.
  SceneView view(const CameraPose& pose);

 private:
  using Image = std::shared_future<cv::Mat>;

  bool is_expected(const CameraPose& pose) const;

  const Render render_;
  const double tolerance_mm_;
  std::mutex mutex_;
  CameraPose expected_;
  // Of the expected pose, the last one, and of earlier ones that are not complete yet: releasing
  // such a future would wait for it. The destructor does.
  std::vector<Image> images_;
};

}  // namespace raywalk::simulator
