// Views on a graphics card: what the processor's passes do (core/view/renderer.h), to within
// rounding.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <span>

#include "core/view/gpu/gpu_view.h"
#include "core/view/viewport.h"

namespace raywalk {

// How a pixel was read; kWaiting: the station that it is filled from is not on the card. Plus
// kOfNoLine in a column that no line serves.
enum class PixelRead : std::uint8_t { kLines, kFilled, kUnread, kWaiting };
inline constexpr std::uint8_t kOfNoLine = 4;

class GpuRenderer {
 public:
  // References must outlive the object. Throws GpuError.
  GpuRenderer(GpuContext* context, std::shared_ptr<RoomTextures> textures);
  ~GpuRenderer();

  // A part of the view of one eye, or of both eyes of a circle: `image` CV_8UC3, bgr, and how each
  // pixel was read (PixelRead), each eye's part below that of the one before. Throws GpuError, among
  // other things where the stations of a column do not fit into the card's memory.
  void render(std::span<const MixedView> eyes, const PanoramaPart& part, cv::Mat image,
              cv::Mat1b how);

  // After a failure further views would fail too.
  void give_up() { gave_up_ = true; }
  bool gave_up() const { return gave_up_; }

 private:
  struct Columns;  // what the columns of a part are read from
  struct OnCard;

  // Pass 4 of one eye.
  void mix(const MixedView& view, const GpuView& eye, const PanoramaPart& part, cv::Mat image,
           cv::Mat1b how);
  // Mixes columns of the part from `first` on whose stations fit; returns their end.
  int mix_block(const MixedView& view, int first, const PanoramaPart& part,
                const GpuProgram& program);
  const GpuProgram& mixing_program(const MixedView& view);

  GpuContext* context_;
  bool gave_up_ = false;
  std::shared_ptr<RoomTextures> textures_;
  std::unique_ptr<Columns> columns_;
  std::unique_ptr<OnCard> on_card_;
};

}  // namespace raywalk
