// Views on a graphics card: what the processor's passes do (core/view/renderer.h), to within
// rounding.
#pragma once

#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <span>

#include "core/view/flat_view.h"
#include "core/view/gpu/gpu_view.h"
#include "core/view/rendered_part.h"

namespace raywalk {

class GpuRenderer {
 public:
  // References must outlive the object. Throws GpuError.
  GpuRenderer(GpuContext* context, std::shared_ptr<RoomTextures> textures);
  ~GpuRenderer();

  // A part of the view of one eye, or of both eyes of a circle, each eye's part below that of the
  // one before: into `image`, CV_8UC3, bgr; marks in `unread` what could not be read, if anything,
  // and counts pixels. With `flat`, which shows nothing beyond the part, of one eye: where all
  // could be read, that picture is made in place of `image`; returns whether it was. Throws
  // GpuError, among other things where the stations of a column do not fit into the card's memory;
  // then nothing was counted.
  bool render(std::span<const MixedView> eyes, const PanoramaPart& part, const FlatPicture* flat,
              cv::Mat image, cv::Mat1b* unread, PixelCounts* counts);

  // After a failure further views would fail too.
  void give_up() { gave_up_ = true; }
  bool gave_up() const { return gave_up_; }

 private:
  struct Eye;
  struct OnCard;
  struct Block;

  // Passes 1 to 3, without the card and on it.
  void plan(std::span<const MixedView> eyes);
  void prepare(std::span<const MixedView> eyes);
  // Pass 4 of one eye. Its picture stays on the card, where it is read in so many bytes when it is
  // done: `use` is called with them.
  using Use = std::function<void(const std::byte*)>;
  PixelCounts mix(const MixedView& view, Eye* eye, const PanoramaPart& part, std::size_t bytes,
                  GpuContext::Turn* turn, const Use& use);
  void mix_block(const MixedView& view, Eye* eye, const PanoramaPart& part, const Block& block);
  void draw_flat(const MixedView& view, const PanoramaPart& part, const FlatPicture& flat,
                 GpuContext::Turn* turn);
  const GpuProgram& mixing_program(const MixedView& view, const Eye& eye);

  GpuContext* context_;
  bool gave_up_ = false;
  std::shared_ptr<RoomTextures> textures_;
  std::unique_ptr<OnCard> on_card_;
};

}  // namespace raywalk
