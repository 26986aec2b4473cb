// Renders views of a room at any viewpoint between its lines: full 360 degrees for one eye or for
// two, or the part that a flat picture shows.
//
// A view goes through these passes, each of which takes images and gives images, of the size of the
// distance maps until the last ones:
//   view_plan.h        the lines and stations that every column is read from
//   distance_view.h    the distances seen from the eye
//   visibility.h       which of these points the stations of each line see
//   edges.h            where the distances have an edge: they are found at twice the resolution
//   station_mixing.h   the samples of the stations, mixed
//   fill_stations.h    what no line sees, from other stations; picture_fill.h fills the rest
// mixing_initial.cc makes initial views, which have no distances, flat_view.h flat pictures.
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>

#include "core/room/room.h"
#include "core/view/view_options.h"
#include "core/view/view_plan.h"
#include "core/view/viewport.h"

namespace raywalk {

class Exposure;
class GpuRenderer;
class PreparedView;

// How a view was rendered; shares are of all pixels of the rendered columns.
struct ViewReport {
  int limited_corners = 0;    // corners whose cut was moved because the overhang ran out, of four
  double filled_share = 0.0;  // occluded from the lines in use and filled from other stations
  double unseen_share = 0.0;  // seen by no station: filled from the rest of the picture
  double empty_share = 0.0;   // served by no line, filled from other stations and the rest
  double render_ms = 0.0;     // from plan to finished picture
};

struct RenderedView {
  // CV_8UC3, BGR; of a panorama height = width / 2, of two eyes' panoramas the left above the
  // right.
  cv::Mat image;
  ViewReport report;
};

// Size of the views of a room unless another is asked for: that of its panoramas, or of the next
// smaller width that views can have, a multiple of 4.
PanoramaSize size_as_captured(const Room& room);

// Throws UsageError unless all coordinates are finite, and for a height in an initial view, which
// does not know how far what it shows would move.
void require_viewpoint(const Viewpoint& viewpoint, ViewMethod method);

// The viewpoint to compare a method's views from: without the height in an initial view.
Viewpoint viewpoint_for(ViewMethod method, PlanPoint plan, std::optional<double> height_m);

// Renders views of one room, one at a time (each view uses all threads, or the device that was
// chosen, gpu/gpu_device.h). Memory use does not depend on the size of the volumes.
class Renderer {
 public:
  // Throws UsageError on options out of range; Error if the method needs distances and the room
  // has none. The room must outlive the renderer.
  Renderer(const Room& room, const ViewOptions& options);
  ~Renderer();

  // Throws UsageError as require_viewpoint does, Error where the room cannot be rendered (see
  // ViewPlan). An earlier `view`, moved in, lends the memory of its image.
  RenderedView render(const Viewpoint& viewpoint, RenderedView view = {});

  // Omnidirectional stereo (core/geometry/eye_circle.h) for eyes `eyes_apart_m` apart, above 0: the
  // panorama of the left eye above that of the right one, options.width columns and rows in all.
  RenderedView render_stereo(const Viewpoint& viewpoint, double eyes_apart_m,
                             RenderedView view = {});

  // A flat picture, which reads only the part of the volumes that it shows. It is resampled from a
  // panorama of options.width columns; much coarser pictures are averaged down. Throws UsageError
  // as require_viewport does.
  RenderedView render(const Viewpoint& viewpoint, const Viewport& viewport, RenderedView view = {});

  // A view that is planned and has its distances, to render parts of it from other lines. The next
  // view overwrites it.
  PreparedView& prepare(const Viewpoint& viewpoint);

 private:
  void render_eyes(std::span<PreparedView* const> eyes, RenderedView* view);

  const Room& room_;
  ViewOptions options_;
  int supersampling_ = 1;                     // rendered columns per output column
  std::unique_ptr<const Exposure> exposure_;  // null: all stations agree, or it is not wanted
  std::unique_ptr<GpuRenderer> gpu_;          // null: the processor renders
  std::unique_ptr<PreparedView> eye_, right_eye_;
  cv::Mat part_;       // the part of the panorama that a flat picture shows
  cv::Mat oversized_;  // rendered picture before averaging
};

}  // namespace raywalk
