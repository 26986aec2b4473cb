#include "build_lf/depth/depth_truth.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/panorama/transposed_border.h"

namespace raywalk::build_lf {
namespace {

constexpr size_t kBands = 8;

// A histogram of pixel errors, to compute medians without storing every error.
class ErrorHistogram {
 public:
  void add(double error) {
    ++counts_[static_cast<size_t>(std::min(error / kBinWidth, kBins - 1.0))];
    ++total_;
  }
  std::int64_t total() const { return total_; }
  double share_below(double error) const {
    std::int64_t below = 0;
    for (size_t i = 0; i < static_cast<size_t>(error / kBinWidth); ++i) below += counts_[i];
    return total_ > 0 ? static_cast<double>(below) / static_cast<double>(total_) : 0.0;
  }
  double median() const {
    std::int64_t below = 0;
    size_t i = 0;
    while (i < counts_.size() && 2 * (below + counts_[i]) < total_) below += counts_[i++];
    return (static_cast<double>(i) + 0.5) * kBinWidth;
  }

 private:
  static constexpr double kBinWidth = 1.0 / 128.0;
  static constexpr double kBins = 4096.0;
  std::vector<std::int64_t> counts_ = std::vector<std::int64_t>(static_cast<size_t>(kBins));
  std::int64_t total_ = 0;
};

// Errors by confidence.
class ErrorsByConfidence {
 public:
  void add(std::uint8_t confidence, double error_px) {
    bands_[confidence * kBands / 256].add(error_px);
  }
  // The bands that hold pixels.
  std::vector<ConfidenceBand> bands() const {
    std::vector<ConfidenceBand> filled;
    for (size_t i = 0; i < bands_.size(); ++i) {
      const ErrorHistogram& band = bands_[i];
      if (band.total() == 0) continue;
      filled.push_back({(static_cast<double>(i) + 0.5) / kBands, band.total(),
                        1.0 - band.share_below(1.0), band.median()});
    }
    return filled;
  }

 private:
  std::vector<ErrorHistogram> bands_ = std::vector<ErrorHistogram>(kBands);
};

// Pixels within kEdgePx of a silhouette: of neighbours whose parallax at the reach differs by over
// 1.5 pixels. On a plane that passes the station at the distance d it differs by at most reach / d
// pixels, as inverse = u . n / d.
std::vector<bool> near_edges(const std::vector<float>& inverse, PanoramaSize size,
                             double px_per_inverse) {
  constexpr double kTornPx = 1.5;
  cv::Mat edges(size.width, size.height, CV_8U, cv::Scalar(0));
  const auto compare = [&](int theta, int phi, int other_theta, int other_phi) {
    const float step =
        inverse[pixel_index(theta, phi, size)] - inverse[pixel_index(other_theta, other_phi, size)];
    if (std::fabs(step) * px_per_inverse <= kTornPx) return;
    edges.at<std::uint8_t>(theta, phi) = edges.at<std::uint8_t>(other_theta, other_phi) = 255;
  };
  for (int theta = 0; theta < size.width; ++theta) {
    for (int phi = 0; phi < size.height; ++phi) {
      compare(theta, phi, (theta + 1) % size.width, phi);
      if (phi + 1 < size.height) compare(theta, phi, theta, phi + 1);
    }
  }
  cv::dilate(with_border(edges, kEdgePx), edges,
             cv::Mat::ones(2 * kEdgePx + 1, 2 * kEdgePx + 1, CV_8U));
  edges = without_border(edges, kEdgePx).clone();
  return {edges.begin<std::uint8_t>(), edges.end<std::uint8_t>()};
}

}  // namespace

GivenDistances::GivenDistances(const Room& room) : volumes_(room.grid().lines.size()) {
  const std::filesystem::path folder = distances_directory(room.directory(), DistanceKind::kGiven);
  std::error_code error;
  if (std::filesystem::exists(folder, error)) volumes_ = open_distance_volumes(folder, room.grid());
}

bool GivenDistances::empty() const {
  return std::all_of(volumes_.begin(), volumes_.end(),
                     [](const DistanceVolume& volume) { return volume.maps() == 0; });
}

std::optional<std::vector<float>> GivenDistances::inverse_of(StationIndex station,
                                                             PanoramaSize size) const {
  const DistanceVolume& volume = volumes_[static_cast<size_t>(station.line)];
  const auto found = std::find(volume.stations().begin(), volume.stations().end(), station.station);
  if (found == volume.stations().end()) return std::nullopt;
  const int map = static_cast<int>(found - volume.stations().begin());
  std::vector<float> inverse;
  inverse.reserve(static_cast<size_t>(size.width) * static_cast<size_t>(size.height));
  for (int theta = 0; theta < size.width; ++theta) {
    const auto column = volume.distance_column(
        map, static_cast<int>((theta + 0.5) / size.width * volume.size().width));
    for (int phi = 0; phi < size.height; ++phi) {
      const auto row = static_cast<size_t>((phi + 0.5) / size.height * volume.size().height);
      inverse.push_back(1.0f / column[row]);
    }
  }
  return inverse;
}

TruthComparison compare_with_truth(const GivenDistances& given, const DepthPlan& plan,
                                   const PartialMaps& partial) {
  TruthComparison comparison;
  ErrorHistogram all;
  ErrorHistogram relative;
  ErrorsByConfidence elsewhere;
  ErrorsByConfidence edges;
  const double px_per_inverse = plan.pixels_per_inverse_m();
  for (const SweepReference& reference : plan.maps) {
    const auto truth = given.inverse_of(reference.station, plan.size);
    const auto map = partial.load(kFinalStage, reference.station);
    if (!truth || !map) continue;
    const std::vector<bool> near_edge = near_edges(*truth, plan.size, px_per_inverse);
    ++comparison.maps;
    for (size_t p = 0; p < truth->size(); ++p) {
      const double true_inverse = (*truth)[p];
      const double error_px = std::fabs(map->inverse[p] - true_inverse) * px_per_inverse;
      all.add(error_px);
      (near_edge[p] ? edges : elsewhere).add(map->confidence[p], error_px);
      // In percent, so that the bins are fine enough.
      if (true_inverse > 0.0) relative.add(100.0 * std::fabs(map->inverse[p] / true_inverse - 1.0));
    }
  }
  if (comparison.maps == 0) {
    throw Error(
        "--truth: no station with an estimated map has a given one; choose --every so that "
        "they meet");
  }
  comparison.within_1px_share = all.share_below(1.0);
  comparison.within_2px_share = all.share_below(2.0);
  comparison.within_4px_share = all.share_below(4.0);
  comparison.median_relative_error = 0.01 * relative.median();
  comparison.elsewhere = elsewhere.bands();
  comparison.edges = edges.bands();
  return comparison;
}

}  // namespace raywalk::build_lf
