// Renders views of a room at any viewpoint between its lines: full 360 degrees for one eye or for
// two, or the part that a flat picture shows.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/room/room.h"
#include "core/view/column_renderer.h"
#include "core/view/picture_fill.h"
#include "core/view/touched_rays.h"
#include "core/view/view_options.h"
#include "core/view/viewport.h"

namespace raywalk {

// How a view was rendered; shares are of all pixels of the rendered columns.
struct ViewReport {
  int layers = 0;             // 0 in an initial view
  int limited_corners = 0;    // corners whose cut was moved because the overhang ran out, of four
  double filled_share = 0.0;  // hidden from the lines in use and filled from other stations
  double stretched_share = 0.0;    // seen by no station: filled from the rest of the picture
  double empty_share = 0.0;        // served by no line, filled from other stations and the rest
  std::int64_t pixels = 0;         // of the columns that were rendered
  WorkCounts work{};               // in those pixels
  std::int64_t bytes_touched = 0;  // of the rays, in whole 64-byte lines; 0 unless counted
  double render_ms = 0.0;          // from plan to finished picture
};

struct RenderedView {
  // CV_8UC3, BGR; of a panorama height = width / 2, of two eyes' panoramas the left above the
  // right.
  cv::Mat image;
  ViewReport report;
};

// One eye's view prepared for rendering columns; connect-error uses it to render the two lines of a
// connection separately.
class PreparedView {
 public:
  const ViewPlan& plan() const { return *plan_; }
  const ViewInputs& inputs() const { return *inputs_; }
  int layers() const { return layers_; }

 private:
  friend class Renderer;
  explicit PreparedView(const Room& room) : distances_(room) {}

  std::unique_ptr<ViewPlan> plan_;
  std::unique_ptr<ViewInputs> inputs_;
  std::vector<MapStation> maps_;
  std::vector<MapStation> fill_maps_;
  DistanceView distances_;
  int layers_ = 0;
};

// Size of the views of a room unless another is asked for: that of its panoramas, or of the next
// smaller width that views can have, a multiple of 4.
PanoramaSize size_as_captured(const Room& room);

// Throws UsageError unless all coordinates are finite, and for a height in an initial view, which
// does not know how far what it shows would move.
void require_viewpoint(const Viewpoint& viewpoint, Generation generation);

// The viewpoint to compare a generation's views from: without the height in an initial view.
Viewpoint viewpoint_for(Generation generation, PlanPoint plan, std::optional<double> height_m);

// Renders views of one room, one at a time (each view uses all threads). Memory use does not depend
// on the size of the volumes.
class Renderer {
 public:
  // Throws UsageError on options out of range; Error if the generation needs distances and the room
  // has none. The room must outlive the renderer.
  Renderer(const Room& room, const ViewOptions& options);
  ~Renderer();

  // Throws UsageError as require_viewpoint does, Error where the room cannot be rendered (see
  // ViewPlan). The second form reuses the memory of an earlier view's image.
  RenderedView render(const Viewpoint& viewpoint);
  void render(const Viewpoint& viewpoint, RenderedView& view);

  // Omnidirectional stereo (core/geometry/eye_circle.h) for eyes `eyes_apart_m` apart, above 0: the
  // panorama of the left eye above that of the right one, options.width columns and rows in all.
  RenderedView render_stereo(const Viewpoint& viewpoint, double eyes_apart_m);
  void render_stereo(const Viewpoint& viewpoint, double eyes_apart_m, RenderedView& view);

  // A flat picture, which reads only the part of the volumes that it shows. It is resampled from a
  // panorama of options.width columns; much coarser pictures are averaged down. Throws UsageError
  // as require_viewport does.
  RenderedView render(const Viewpoint& viewpoint, const Viewport& viewport);
  void render(const Viewpoint& viewpoint, const Viewport& viewport, RenderedView& view);

  // Whether views count the bytes of the rays that they read, which makes them much slower.
  void count_bytes(bool wanted);

  // Plans a view and, for corrected generations, gathers its distances. The result is overwritten
  // by the next call.
  const PreparedView& prepare(const Viewpoint& viewpoint);

  // The lines a column is read from in this generation, front and (two-sided) behind.
  std::vector<RaySource> sources(const ColumnPlan& column) const;

 private:
  using Eyes = std::vector<PreparedView*>;

  // Prepares the views of the left and the right eye.
  Eyes prepare_stereo(const Viewpoint& viewpoint, double eyes_apart_m);
  // Renders the prepared eyes; `start` is when preparing them began.
  void render_prepared(const Eyes& eyes, const Viewport* viewport,
                       std::chrono::steady_clock::time_point start, RenderedView* view);
  void plan_eye(const Viewpoint& viewpoint, double eye_radius_m, PreparedView* eye);
  void choose_maps(PreparedView* eye) const;
  // After gathering its distances.
  void use_distances(PreparedView* eye);
  PanoramaSize render_size() const;
  OmegaRange range_of(std::span<const MapStation> maps);
  // Receives rendered columns of an eye: `count` rgb columns, `column_bytes` apart, from index
  // `begin` of the requested ones on.
  using ColumnSink = std::function<void(std::size_t eye, int begin, int count,
                                        const std::uint8_t* columns, std::size_t column_bytes)>;
  // Renders `count` columns from `first` on, around the seam; unknown_ then tells what is unknown.
  void render_columns(const Eyes& eyes, int first, int count, const ColumnSink& sink,
                      ViewReport* report);
  void render_panoramas(const Eyes& eyes, cv::Mat* image, ViewReport* report);
  void render_flat(const Viewport& viewport, cv::Mat* image, ViewReport* report);
  // Renders a part of the panorama into part_ and returns what is unknown of it.
  UnknownPixels render_part(const PanoramaPart& part, ViewReport* report);
  void fill_part(const UnknownPixels& unknown);

  std::optional<Room> part_of_room_;  // set where station_stride > 1
  const Room& room_;
  ViewOptions options_;
  PreparedView view_;                                     // of the eye, or of the left one
  std::unique_ptr<PreparedView> right_eye_;               // null until stereo is rendered
  std::unique_ptr<const RoomGains> gains_;                // null: all are 1, or not wanted
  std::unique_ptr<TouchedRays> touched_;                  // null: bytes are not counted
  std::map<std::pair<int, int>, OmegaRange> map_ranges_;  // by line and map, once looked at
  cv::Mat oversized_;  // rendered picture before averaging, where supersampling_ > 1
  std::vector<std::vector<UnknownRows>> unknown_;  // of each eye's columns rendered last
  std::vector<std::uint8_t> part_;  // the part of the panorama that a flat picture shows
  int supersampling_ = 1;           // rendered columns per output column
};

}  // namespace raywalk
