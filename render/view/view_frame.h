// Direction, field of view and size of a view, as given on the command line.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "core/view/renderer.h"

namespace raywalk::render {

// Which eyes see a view.
enum class Stereo {
  kMono,
  kOds  // both: omnidirectional stereo (core/geometry/eye_circle.h), two panoramas, left above
        // right
};

// Distance between the eyes.
inline constexpr double kUsualIpd_mm = 63.0;  // the mean of adults
inline constexpr double kLeastIpd_mm = 1.0;
inline constexpr double kMostIpd_mm = 200.0;

struct ViewFrame {
  double yaw_deg = 0.0;    // to the right
  double pitch_deg = 0.0;  // up
  double roll_deg = 0.0;   // the camera clockwise
  double fov_deg = 0.0;    // of a flat picture's width; 0: a panorama
  std::string size{};      // of a flat picture, "1440x1600"; empty: 1280x720
  Stereo stereo = Stereo::kMono;
  double ipd_mm = 0.0;  // distance between the eyes; 0: kUsualIpd_mm; stereo only
};

// The flat picture of a frame; none where the frame is a panorama. Throws UsageError as
// require_viewport does, for a malformed size, for a size without a field of view, for a stereo
// view that is flat, pitched or rolled, and for a distance between the eyes out of range or without
// stereo.
std::optional<Viewport> viewport_of(const ViewFrame& frame);

// How many times wider than captured a pixel's detail is shown, in the middle of a flat picture or
// everywhere in a panorama `output_width_px` wide. Above 1 the picture shows less detail than its
// size suggests; a flat picture is enlarged more towards its borders.
double enlargement_of(const ViewFrame& frame, int output_width_px, int captured_width_px);

// "enlarged 8.8 times from panoramas 512 pixels wide"; empty where the enlargement is not above 1.
std::string enlargement_text(double enlargement, int captured_width_px);

// The distance between the eyes of a stereo frame.
double ipd_mm_of(const ViewFrame& frame);

// "ods, left eye above right eye, 63 mm apart"; empty unless the frame is stereo.
std::string stereo_text(const ViewFrame& frame);

// Renders a frame: a flat picture, or one or two panoramas turned by resampling them. Throws
// UsageError as viewport_of() does, Error as the renderer does.
RenderedView render_framed(Renderer* renderer, const Viewpoint& viewpoint, const ViewFrame& frame);

struct PlacedFrame {
  Viewpoint viewpoint;
  ViewFrame frame;
};

// Renders many frames. Calls `use` with the picture of each in their order, in another thread,
// while the next one is rendered; on a card, two are, so that it draws one while the processor
// plans and reads back the other. Throws as render_framed() and `use` do.
void render_frames(const Room& room, const ViewOptions& options,
                   std::span<const PlacedFrame> frames,
                   const std::function<void(std::size_t, const cv::Mat&)>& use);

}  // namespace raywalk::render
