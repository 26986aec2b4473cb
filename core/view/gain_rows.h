// Applies the stations' gains (core/room/gain_fields.h) to rows of a view as they are read.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "core/room/room.h"

namespace raywalk {

struct RowSamples;

// The gains of all stations of a room, prepared for look-up; made once, used by all threads.
class RoomGains {
 public:
  explicit RoomGains(const Room& room);  // which has gains

  bool is_one(int line, int station) const { return field(line, station).empty(); }
  // Adds `share` of a station's gains at a position of its panorama, which is in [0, 1) of the
  // width and of the height, to `rgb`.
  void add(int line, int station, float share, float u, float v, float* rgb) const;
  PanoramaSize panorama() const { return panorama_; }
  // The pixel at an offset of SamplePositions.
  RayPlace place_of(std::int32_t offset) const { return polar_part_.place_of(offset); }

 private:
  const cv::Mat& field(int line, int station) const {
    return fields_[static_cast<std::size_t>(line)][static_cast<std::size_t>(station)];
  }

  // [line][station]: factors, CV_32FC3, with a border of one patch; empty where all are 1.
  std::vector<std::vector<cv::Mat>> fields_;
  PanoramaSize panorama_;
  PolarPart polar_part_;
};

// A station's share of a row that is mixed from several.
struct StationShare {
  int line = 0;
  int station = 0;
  float share = 0.0F;
};

// One per thread: it owns scratch memory.
//
// Stations are mixed first and multiplied by their mixed gains after. For shares w1 + w2 = 1 this
// differs from mixing the corrected levels s g by w1 w2 (s1 - s2) (g1 - g2), a product of two small
// differences: neighbours that show one surface differ by their gains, so it is about w1 w2 (g1 -
// g2)^2 of the level, 0.3 % for gains that are 10 % apart.
class GainRows {
 public:
  explicit GainRows(const RoomGains* gains) : gains_(gains) {}  // null: all are 1

  bool change(std::span<const StationShare> shares) const;
  bool change(const RowSamples& samples) const;
  bool change(int line, int station) const {
    return gains_ != nullptr && !gains_->is_one(line, station);
  }

  // Multiplies rgb rows read at sample positions, samples.rows of them.
  void apply(const RowSamples& samples, std::uint8_t* rgb);
  // Multiplies rows read from the stored columns u, from `first_row` on.
  void apply_stored(std::span<const StationShare> shares, int u, int first_row, int rows,
                    std::uint8_t* rgb);

 private:
  // `place`(i, row) is where row `row` reads from shares[i]: a cv::Point of the panorama.
  template <typename Place>
  void multiply(std::span<const StationShare> shares, int rows, const Place& place,
                std::uint8_t* rgb);

  const RoomGains* gains_;
  std::vector<float> factors_;  // [row][rgb]
};

}  // namespace raywalk
