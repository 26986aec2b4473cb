// What StationMixing works on.
#pragma once

#include <algorithm>
#include <array>
#include <opencv2/core/matx.hpp>

#include "core/view/sampler.h"
#include "core/view/station_mixing.h"

namespace raywalk {

// Points in one plan direction.
struct StationMixing::Points {
  double theta_rad = 0.0;
  Eigen::Vector3d eye_m{0, 0, 0};
  float captured = 0.0f;
  int count = 0;
  const float *sin_phi = nullptr, *cos_phi = nullptr, *inverse = nullptr;
};

// Samples of points in a station that is mixed.
struct StationMixing::PlacedStation {
  Read read{};
  std::array<std::int32_t, kRows> left{}, right{}, across{}, down{};
  std::array<float, kRows> u{}, v{}, weight{};
  std::array<float, 4 * (kRows + 2)> exposure{};
  SamplePlaces places() { return {left.data(), right.data(), across.data(), down.data()}; }
};

// In all of them.
struct StationMixing::Placed {
  // The next station.
  PlacedStation& add(const Read& read) {
    if (count == stations.size()) stations.emplace_back();
    stations[count].read = read;
    return stations[count++];
  }
  std::vector<PlacedStation> stations;  // the first `count` are in use
  std::size_t count = 0;
  std::array<float, kRows> total{};  // of the weights, where stations have masks
};

struct StationMixing::Scratch {
  explicit Scratch(int distance_rows)
      : nothing_occluded(static_cast<std::size_t>(distance_rows), 0),
        inverse(nothing_occluded.size() + 2),
        joined(inverse.size()),
        u(inverse.size()),
        v(inverse.size()),
        part(inverse.size()),
        total(std::max(inverse.size(), static_cast<std::size_t>(kRows))),
        tile(static_cast<std::size_t>(kRows * kStride) + 4) {
    for (auto& station : weight) station.resize(total.size());
  }

  std::array<Column, kColumns> columns{};
  std::vector<std::uint8_t> nothing_occluded;
  // Of the rows of the distances in a tile, or of single points.
  std::vector<float> inverse, joined, u, v, part, total;
  std::array<std::vector<float>, kMostSamples> weight;
  std::array<float, kRows> row_weight;  // of the samples placed next
  std::array<Placed, 2> placed;         // of a column and the next one
  std::array<StationSamples, kMostSamples> samples{};
  std::array<SamplesAhead, kMostSamples> ahead{};
  // Of single points, at edges and where rows are filled.
  Placed points;
  std::array<float, kRows> sin_phi, cos_phi, point_inverse, trust;
  std::array<std::array<std::uint8_t, kRows>, kMaxSources> occluded;
  std::array<std::uint8_t, 4 * kRows + 4> colour;
  std::array<cv::Vec4i, kRows> sum;  // of colours, and their number
  std::vector<std::uint8_t> tile;
};

}  // namespace raywalk
