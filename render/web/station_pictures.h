// The pictures of stations as an export holds them: with the gains of views, and complete where a
// station is masked or left out of views.
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>

#include "core/room/distance_maps.h"
#include "core/room/room.h"
#include "core/view/renderer.h"

namespace raywalk::render {

// What a station captured, multiplied by its gains, `width` wide: CV_8UC3, BGR.
cv::Mat captured_picture_at(const Room& room, int line, int station, int width);

// The pixels of that picture which views do not show, masked or left out: CV_8UC1, 255 there; empty
// where views show all.
cv::Mat hidden_in_views(const Room& room, int line, int station, int width);

class StationPictures {
 public:
  // `options` are those of the views that pictures are completed from; their width is that of the
  // pictures. The room must outlive the object.
  StationPictures(const Room& room, const ViewOptions& options) : room_(room), options_(options) {}

  // The picture of a station, complete: what views do not show of it is taken from the view that
  // the engine renders there. Beyond the cells, where it renders none, from the nearest place in a
  // cell, moved by the distances seen from the station. Throws Error as the renderer does.
  cv::Mat picture_of(int line, int station, const InverseMap& distances);

 private:
  const Room& room_;
  ViewOptions options_;
  std::unique_ptr<Renderer> renderer_;  // made when it is first needed
};

}  // namespace raywalk::render
