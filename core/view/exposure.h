// The exposure corrections of a room's stations (Room::gains), prepared for looking up: made once,
// used by all threads.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/room/room.h"

namespace raywalk {

class Exposure {
 public:
  explicit Exposure(const Room& room);

  bool is_one(int line, int station) const { return field(line, station).empty(); }
  // The factors of rgb at a pixel position of a station's panorama, and a fourth value of 0.
  cv::Vec4f at(int line, int station, float u, float v) const;

 private:
  const cv::Mat& field(int line, int station) const {
    return fields_[static_cast<std::size_t>(line)][static_cast<std::size_t>(station)];
  }

  // [line][station]: factors, CV_32FC3, [theta][phi] with a border of one patch; empty: all are 1.
  std::vector<std::vector<cv::Mat>> fields_;
  PanoramaSize panorama_;
};

}  // namespace raywalk
