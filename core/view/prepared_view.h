// One eye's view, pass by pass (renderer.h lists them).
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "core/view/distance_view.h"
#include "core/view/edges.h"
#include "core/view/exposure.h"
#include "core/view/fill_stations.h"
#include "core/view/flat_view.h"
#include "core/view/rendered_part.h"
#include "core/view/view_options.h"
#include "core/view/view_plan.h"
#include "core/view/visibility.h"

namespace raywalk {

class GpuRenderer;
struct MixedView;

class PreparedView {
 public:
  // References must outlive the object; `exposure` may be null.
  PreparedView(const Room& room, const ViewOptions& options, const Exposure* exposure,
               PanoramaSize output)
      : room_(room),
        options_(options),
        exposure_(exposure),
        output_(output),
        distances_(room),
        visibility_(room) {}

  // Plans a view. Throws Error where the room cannot be rendered.
  void prepare(const Viewpoint& viewpoint);
  // The same of two eyes `eyes_apart_m` apart.
  static void prepare_stereo(const Viewpoint& viewpoint, double eyes_apart_m, PreparedView* left,
                             PreparedView* right);

  // Plans what the columns of a part of the panorama are read from. `sources`: the lines of each
  // column; none: those of the plan.
  void look_at(const PanoramaPart& part, Visibility::Sources sources = {});

  // All that needs pixels, of several eyes at once, whose columns read nearly the same ones of the
  // stations: each eye's part below that of the one before, CV_8UC3, bgr. Marks in `unread`, of the
  // image's size and empty before, what could not be read; it stays empty where all was. On `gpu`,
  // if it is not null and does not fail; if all could be read there, `flat`, which shows nothing
  // beyond the part, is made in place of the image. Returns whether it was.
  static bool render(std::span<PreparedView* const> eyes, const PanoramaPart& part,
                     GpuRenderer* gpu, const FlatPicture* flat, cv::Mat* image, cv::Mat1b* unread,
                     PixelCounts* counts);

  const ViewPlan& plan() const { return *plan_; }
  PanoramaSize output() const { return output_; }

 private:
  void plan_eye(const Viewpoint& viewpoint, double eye_radius_m);
  MixedView mixed_view();
  // The processor's passes before the last one: the distances, once for a viewpoint, and what is
  // seen in the columns of the part.
  void gather();
  void see();
  // The maps that distances are gathered from, and those that show what no line sees.
  std::vector<MapStation> choose_maps();

  const Room& room_;
  const ViewOptions& options_;
  const Exposure* exposure_;
  PanoramaSize output_;
  std::unique_ptr<ViewPlan> plan_;
  DistanceView distances_;
  bool gathered_ = false;  // whether the processor has gathered them
  FillStations fill_;
  Visibility visibility_;
  Edges edges_;
  Visibility::Sources sources_;
};

}  // namespace raywalk
