// Views on a graphics card: what the processor's passes do (core/view/renderer.h), to within
// rounding.
#pragma once

#include <array>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <span>

#include "core/view/gpu/gpu_view.h"
#include "core/view/rendered_part.h"
#include "core/view/viewport.h"

namespace raywalk {

class GpuRenderer {
 public:
  // References must outlive the object. Throws GpuError.
  GpuRenderer(GpuContext* context, std::shared_ptr<RoomTextures> textures);
  ~GpuRenderer();

  // A part of the view of one eye, or of both eyes of a circle, each eye's part below that of the
  // one before: into `image`, CV_8UC3, bgr; marks in `unread` what could not be read, if anything,
  // and counts pixels. Throws GpuError, among other things where the stations of a column do not
  // fit into the card's memory; then nothing was counted.
  void render(std::span<const MixedView> eyes, const PanoramaPart& part, cv::Mat image,
              cv::Mat1b* unread, PixelCounts* counts);
  // A flat picture, resampled from a part of a view that holds all that it shows. Returns false,
  // having counted nothing, where something could not be read, which the processor fills.
  bool render_flat(const MixedView& view, const PanoramaPart& part, const Viewport& viewport,
                   cv::Mat* image, PixelCounts* counts);

  // After a failure further views would fail too.
  void give_up() { gave_up_ = true; }
  bool gave_up() const { return gave_up_; }

 private:
  struct Columns;  // what the columns of a part are read from
  struct OnCard;

  // Passes 1 to 3, and pass 4 of one eye, whose picture stays on the card.
  void prepare(std::span<const MixedView> eyes);
  void prepare_on_card(std::span<const MixedView> eyes);
  PixelCounts mix(const MixedView& view, const GpuView& eye, const PanoramaPart& part);
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
