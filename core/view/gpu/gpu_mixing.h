// Pass 4 on a graphics card (core/view/shaders/mixing.glsl): what StationMixing does, to within
// rounding.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/view/gpu/gpu_context.h"
#include "core/view/gpu/station_textures.h"
#include "core/view/mixed_column.h"
#include "core/view/viewport.h"

namespace raywalk {

// How GpuMixing read a pixel; kUndecided: it has to be mixed on the processor. Plus kOfNoLine in a
// column that no line serves.
enum class PixelRead : std::uint8_t { kLines, kFilled, kUnread, kUndecided };
inline constexpr std::uint8_t kOfNoLine = 4;

class GpuMixing {
 public:
  // References must outlive the object. Throws GpuError.
  GpuMixing(GpuContext* context, std::shared_ptr<StationTextures> stations);
  ~GpuMixing();

  // A part of one eye's view: `image` CV_8UC3, bgr, and how each pixel was read (PixelRead), both
  // of the part's size. Throws GpuError, among other things where the stations of a column do not
  // fit into the card's memory.
  void render(const MixedView& view, const PanoramaPart& part, cv::Mat image, cv::Mat1b how);

  // After a failure further views would fail too.
  void give_up() { gave_up_ = true; }
  bool gave_up() const { return gave_up_; }

 private:
  struct Uploads;
  struct Program;

  void upload(const MixedView& view, const PanoramaPart& part);
  const Program& program_for(const MixedView& view);
  void set_uniforms(const MixedView& view, const PanoramaPart& part, const Program& program);
  // The end of the columns from `first` on whose stations fit, whose layers are set then.
  int require_stations(const MixedView& view, int first, int columns);

  GpuContext* context_;
  bool gave_up_ = false;
  std::shared_ptr<StationTextures> stations_;
  std::unique_ptr<Uploads> uploads_;
  std::unique_ptr<Program> plain_, keeping_;  // keeping_: with KEEP_SAMPLES
};

}  // namespace raywalk
