// What StationMixing works on.
#pragma once

#include <algorithm>
#include <array>
#include <opencv2/core/matx.hpp>

#include "core/view/column_rows.h"
#include "core/view/sampler.h"
#include "core/view/station_mixing.h"

namespace raywalk {

// A station that a column is read from.
struct StationMixing::Read {
  std::size_t source = 0;  // index of the column's source
  int line = 0, station = 0;
  StationShare share{};  // of the column
  StationOccluders by{};
  bool has_masks = false;
};

// What is the same in all rows of an output column.
struct StationMixing::Column {
  int u = 0;
  double theta_rad = 0.0;
  Eigen::Vector3d eye_m{0, 0, 0};
  int left = 0, right = 0, nearest = 0;  // columns of the distances around it
  float part = 0.0f;                     // of the way to the right one
  float captured = 0.0f;                 // its place in the stations, W to 2 W
  ColumnSources sources{};
  std::array<const std::uint8_t*, kMaxSources> occluded{};
  const float* trust = nullptr;
  std::vector<Read> reads;
  bool any_masks = false;
  std::span<const EdgePixel> edges;
};

// Samples in one plan direction, each of its own point.
struct StationMixing::Points {
  double theta_rad = 0.0;
  Eigen::Vector3d eye_m{0, 0, 0};
  float captured = 0.0f;
  int count = 0;
  const float *sin_phi = nullptr, *cos_phi = nullptr, *inverse = nullptr;
  const float* right_px = nullptr;  // displacements in pixels of the stations; null: none
};

// Of the points of a column of the distances in a station.
struct StationMixing::Positions {
  int line = -1, station = -1, theta = -1;
  std::vector<float> from_column, v;
};

struct StationMixing::Scratch {
  // Samples that are placed in a station, and the weight and part of each.
  struct Station {
    std::array<std::int32_t, kRows> left, right, part_u, part_v;
    std::array<float, kRows> u, v, weight;
    std::array<std::int16_t, kRows> part;
    std::array<float, 4 * (kRows + 2)> exposure;
    SamplePlaces places() { return {left.data(), right.data(), part_u.data(), part_v.data()}; }
  };

  explicit Scratch(int distance_rows)
      : nothing_occluded(static_cast<std::size_t>(distance_rows), 0),
        parts(nothing_occluded.size() + 1),
        inverse(parts.size()),
        step(parts.size()),
        from_column(parts.size()),
        v(parts.size()),
        part(parts.size()),
        total(std::max(parts.size(), static_cast<std::size_t>(kRows))),
        tile(static_cast<std::size_t>(kRows * kStride) + 4) {
    for (auto& station : weight) station.resize(parts.size());
  }

  std::array<Column, kColumns> columns{};
  std::vector<Positions> positions;
  std::size_t positions_used = 0;
  std::vector<std::uint8_t> nothing_occluded;
  // Of the rows of the distances in a tile.
  std::vector<float> parts, inverse, step, from_column, v;
  std::array<std::vector<float>, kMostSamples> weight;
  std::vector<std::int16_t> part;
  std::vector<float>
      total;  // of the weights: of these rows, or of the samples that were mixed last
  // Of each station that is mixed.
  std::vector<Station> stations;
  std::array<StationSamples, kMostSamples> samples{};
  std::array<const Read*, kMostSamples> read{};
  std::size_t count = 0;
  // Of single samples, at edges and where rows are filled.
  std::array<float, kRows> sin_phi, cos_phi, point_inverse, right_px, trust;
  std::array<std::array<std::uint8_t, kRows>, kMaxSources> occluded;
  std::array<std::uint8_t, 4 * kRows + 4> colour;
  std::array<cv::Vec4i, kRows> sum;  // of colours, and their number
  std::vector<std::uint8_t> tile;
};

}  // namespace raywalk
