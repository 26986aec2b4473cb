// One station's picture compared with what other stations say about surfaces and their colours.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "build_lf/depth/contradictions.h"
#include "build_lf/depth/station_colours.h"

namespace raywalk::build_lf {

// What a station tells about colours and surfaces, all of one size, [theta][phi], without gaps
// between the columns.
struct StationEvidence {
  StationIndex station;
  Eigen::Vector3d position_m{0, 0, 0};
  std::vector<float> inverse;  // inverse distances, 1/m; negative: not known. Empty: no map
  cv::Mat colour;              // CV_8UC3 after the gains
  cv::Mat least, most;         // of the pixels around; 0 and 255 where dark or clipped
  cv::Mat valid;               // CV_8UC1, 0 = masked; empty: all valid

  // Of a pixel by its index (pixel_index).
  bool shows(std::size_t pixel) const { return valid.empty() || valid.ptr<uchar>()[pixel] != 0; }
  const cv::Vec3b& colour_of(std::size_t pixel) const { return colour.ptr<cv::Vec3b>()[pixel]; }
  ColourRange range(std::size_t pixel) const {
    return {least.ptr<cv::Vec3b>()[pixel], most.ptr<cv::Vec3b>()[pixel]};
  }
};

// What a station shows, with what its finished map knows; null: it has none. `size` is that of the
// map or a half, a quarter, ... of it.
StationEvidence evidence_of(const Room& room, StationIndex station, PanoramaSize size,
                            const GainField& gains, const InverseDistanceMap* map);

// The most stations to compare one with.
inline constexpr std::size_t kMostNeighbours = 12;

// What of `own` the neighbours contradict. A pixel is contradicted where neighbours agree on a
// surface and its colour, but the station shows another colour than on any of their surfaces
// (contradictions.h). The neighbours, at most kMostNeighbours, have maps; all evidence is of
// `size`. Inverse distances that differ by `tolerance_per_m`, 1/m, are one surface. `maps`: the
// size of the maps.
ContradictedStation contradicted_by(
    std::span<const std::shared_ptr<const StationEvidence>> neighbours, const StationEvidence& own,
    PanoramaSize size, float tolerance_per_m, PanoramaSize maps);

}  // namespace raywalk::build_lf
