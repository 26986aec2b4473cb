#include "build_lf/depth/station_comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "build_lf/depth/pixel_directions.h"
#include "build_lf/depth/seen_surfaces.h"
#include "core/base/parallel.h"
#include "core/panorama/transposed_border.h"
#include "core/room/distance_volume.h"
#include "core/room/station_image.h"

namespace raywalk::build_lf {
namespace {

constexpr int kLeastWitnesses = 3;
constexpr float kAgreeingShare = 0.7f;

void for_each_column(PanoramaSize size, const std::function<void(int theta)>& work) {
  parallel_for(0, size.width, 8, [&](int begin, int end) {
    for (int theta = begin; theta < end; ++theta) work(theta);
  });
}

class StationComparison {
 public:
  StationComparison(const StationEvidence& own,
                    std::span<const std::shared_ptr<const StationEvidence>> neighbours,
                    PanoramaSize size, float tolerance_per_m)
      : own_(own),
        neighbours_(neighbours),
        size_(size),
        directions_(size),
        tolerance_(tolerance_per_m),
        slant_(kSlant * static_cast<float>(kPi) / static_cast<float>(size.width)) {
    for (const auto& neighbour : neighbours_) {
      offsets_.push_back((own_.position_m - neighbour->position_m).cast<float>());
    }
    project_surfaces();
    noise_ = measure_noise();
  }

  // CV_32FC1, [theta][phi]: grey levels by which each pixel lies outside what the others show; 0
  // also where what is contradicted is no wider than two pixels.
  cv::Mat gaps() const {
    // What moved is wider than this: one of so many pixels is judged first, then all around those
    // that are contradicted.
    constexpr int kEvery = 2;
    cv::Mat gaps = cv::Mat::zeros(size_.width, size_.height, CV_32FC1);
    for_each_column(size_, [&](int theta) {
      if (theta % kEvery != 0) return;
      for (int phi = 0; phi < size_.height; phi += kEvery)
        gaps.at<float>(theta, phi) = gap(theta, phi);
    });
    cv::Mat around = with_border(gaps, kEvery) > limits().weak;
    cv::dilate(around, around, cv::Mat::ones(2 * kEvery + 1, 2 * kEvery + 1, CV_8UC1));
    around = without_border(around, kEvery);
    for_each_column(size_, [&](int theta) {
      for (int phi = 0; phi < size_.height; ++phi) {
        if (theta % kEvery == 0 && phi % kEvery == 0) continue;
        if (around.at<uchar>(theta, phi) != 0) gaps.at<float>(theta, phi) = gap(theta, phi);
      }
    });
    return gaps;
  }

  // The inverse distance, 1/m, of the nearest surface that enough others agree on at a pixel;
  // negative: they do not tell, or the pixel is masked.
  float surface_behind(int theta, int phi) const {
    const size_t pixel = pixel_index(theta, phi, size_);
    if (!own_.shows(pixel)) return -1.0f;
    const ColourRange own = own_.range(pixel);
    for (const float inverse : hypotheses(pixel)) {
      if (gap_from(witnesses_of(directions_.of(theta, phi), inverse, true), own)) return inverse;
    }
    return -1.0f;
  }

  // Beyond what noise explains.
  GapLimits limits() const {
    constexpr float kLeastWeak = 12.0f;
    constexpr float kLeastStrong = 24.0f;
    return {std::max(kLeastWeak, 4.0f * noise_), std::max(kLeastStrong, 8.0f * noise_)};
  }

 private:
  using Colours = std::array<std::uint8_t, kMostNeighbours>;

  // Neighbours that see one surface: their colours.
  struct Witnesses {
    int count = 0;
    std::array<Colours, 3> colour{};
    std::array<ColourRange, kMostNeighbours> range;
  };

  // Each neighbour's confident surfaces as they are seen from here, the nearest one per pixel.
  void project_surfaces() {
    surfaces_.resize(neighbours_.size());
    parallel_for(0, static_cast<int>(neighbours_.size()), 1, [&](int begin, int end) {
      for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
        surfaces_[i] = seen_surfaces(neighbours_[i]->inverse, size_, directions_, offsets_[i]);
      }
    });
  }
  float tolerance_at(float inverse) const { return tolerance_ + slant_ * inverse; }

  // Inverse distances.
  class Surfaces {
   public:
    void add(float inverse) { inverse_[count_++] = inverse; }
    void sort_nearest_first() { std::sort(begin(), end(), std::greater()); }
    float* begin() { return inverse_.data(); }
    float* end() { return inverse_.data() + count_; }

   private:
    std::array<float, kMostNeighbours + 1> inverse_{};
    size_t count_ = 0;
  };

  // The surfaces that at least two neighbours see in a direction, nearest first, and the station's
  // own distance.
  Surfaces hypotheses(size_t pixel) const {
    Surfaces proposed;
    for (const auto& surfaces : surfaces_) {
      if (surfaces[pixel] >= 0.0f) proposed.add(surfaces[pixel]);
    }
    proposed.sort_nearest_first();
    Surfaces distinct;
    for (const float* at = proposed.begin(); at != proposed.end();) {
      const float* next = at;
      while (next != proposed.end() && *at - *next <= tolerance_at(*at)) ++next;
      if (next - at >= 2) distinct.add(at[(next - at) / 2]);
      at = next;
    }
    if (!own_.inverse.empty() && own_.inverse[pixel] >= 0.0f) distinct.add(own_.inverse[pixel]);
    return distinct;
  }

  // With `by_maps` only those whose maps agree.
  Witnesses witnesses_of(const Eigen::Vector3f& direction, float inverse, bool by_maps) const {
    Witnesses witnesses;
    for (size_t i = 0; i < neighbours_.size(); ++i) {
      const StationEvidence& other = *neighbours_[i];
      const Eigen::Vector3f point = direction + inverse * offsets_[i];
      const size_t there = pixel_of(point, size_);
      if (!other.shows(there)) continue;
      if (by_maps) {
        const float expected = inverse / point.norm();
        const float held = other.inverse[there];
        if (held < 0.0f || std::fabs(held - expected) > tolerance_at(expected)) continue;
      }
      const auto n = static_cast<size_t>(witnesses.count++);
      const cv::Vec3b& colour = other.colour_of(there);
      for (int c = 0; c < 3; ++c) witnesses.colour[static_cast<size_t>(c)][n] = colour[c];
      witnesses.range[n] = other.range(there);
    }
    return witnesses;
  }

  static cv::Vec3b median_of(const Witnesses& witnesses) {
    cv::Vec3b median;
    for (int c = 0; c < 3; ++c) {
      Colours sorted = witnesses.colour[static_cast<size_t>(c)];
      // Insertion sort: there are few, and GCC 14 warns falsely of what std::sort does with many.
      for (auto next = sorted.begin(); next != sorted.begin() + witnesses.count; ++next) {
        std::rotate(std::upper_bound(sorted.begin(), next, *next), next, next + 1);
      }
      median[c] = sorted[static_cast<size_t>(witnesses.count / 2)];
    }
    return median;
  }

  // How far the station's colour is outside what those show who see the surface; none if they are
  // too few or disagree.
  std::optional<float> gap_from(const Witnesses& witnesses, const ColourRange& own) const {
    if (witnesses.count < kLeastWitnesses) return std::nullopt;
    const cv::Vec3b median = median_of(witnesses);
    const auto weak = static_cast<int>(limits().weak);
    int agreeing = 0;
    ColourRange shown{median, median};
    for (int i = 0; i < witnesses.count; ++i) {
      const auto n = static_cast<size_t>(i);
      if (gap_between(witnesses.range[n], {median, median}) > weak) continue;
      ++agreeing;
      for (int c = 0; c < 3; ++c) {
        const std::uint8_t level = witnesses.colour[static_cast<size_t>(c)][n];
        shown.least[c] = std::min(shown.least[c], level);
        shown.most[c] = std::max(shown.most[c], level);
      }
    }
    const float enough = kAgreeingShare * static_cast<float>(witnesses.count);
    if (agreeing < kLeastWitnesses || static_cast<float>(agreeing) < enough) return std::nullopt;
    return static_cast<float>(gap_between(shown, own));
  }

  // Whether most others show the same colour where the station's own distance says, though their
  // maps miss the surface: a thin or shining thing, but none that moved.
  bool shown_by_others(const Eigen::Vector3f& direction, float inverse,
                       const ColourRange& own) const {
    const Witnesses all = witnesses_of(direction, inverse, false);
    const auto weak = static_cast<int>(limits().weak);
    int same = 0;
    for (int i = 0; i < all.count; ++i) {
      same += gap_between(all.range[static_cast<size_t>(i)], own) <= weak ? 1 : 0;
    }
    return same >= kLeastWitnesses && 2 * same >= all.count;
  }

  // Grey levels by which a pixel lies outside what the others show of every surface they see there.
  float gap(int theta, int phi) const {
    const size_t pixel = pixel_index(theta, phi, size_);
    if (!own_.shows(pixel)) return 0.0f;
    const Eigen::Vector3f direction = directions_.of(theta, phi);
    const ColourRange own = own_.range(pixel);
    std::optional<float> least;
    for (const float inverse : hypotheses(pixel)) {
      const auto gap = gap_from(witnesses_of(direction, inverse, true), own);
      if (!gap) continue;
      least = std::min(*gap, least.value_or(*gap));
      if (*least <= 0.0f) return 0.0f;
    }
    const bool contradicted = least && *least > limits().weak;
    const bool own_distance = !own_.inverse.empty() && own_.inverse[pixel] >= 0.0f;
    if (contradicted && own_distance && shown_by_others(direction, own_.inverse[pixel], own)) {
      return 0.0f;
    }
    return least.value_or(0.0f);
  }

  // The median difference between the station's colours and those of the others, grey levels.
  float measure_noise() const {
    constexpr int kEvery = 7;
    std::vector<float> differences;
    for (int theta = 0; theta < size_.width; theta += kEvery) {
      for (int phi = 0; phi < size_.height; phi += kEvery) {
        const size_t pixel = pixel_index(theta, phi, size_);
        Surfaces surfaces = hypotheses(pixel);
        if (surfaces.begin() == surfaces.end() || !own_.shows(pixel)) continue;
        const Witnesses witnesses =
            witnesses_of(directions_.of(theta, phi), *surfaces.begin(), true);
        if (witnesses.count < kLeastWitnesses) continue;
        const cv::Vec3b median = median_of(witnesses);
        const auto& colour = own_.colour_of(pixel);
        int difference = 0;
        for (int c = 0; c < 3; ++c)
          difference = std::max(difference, std::abs(colour[c] - median[c]));
        differences.push_back(static_cast<float>(difference));
      }
    }
    if (differences.empty()) return 0.0f;
    const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
    std::nth_element(differences.begin(), middle, differences.end());
    return *middle;
  }

  const StationEvidence& own_;
  std::span<const std::shared_ptr<const StationEvidence>> neighbours_;
  PanoramaSize size_;
  PixelDirections directions_;
  float tolerance_;                           // 1/m
  float slant_;                               // share of the inverse distance
  std::vector<Eigen::Vector3f> offsets_;      // from each neighbour to this station, metres
  std::vector<std::vector<float>> surfaces_;  // inverse distances from here; negative: none seen
  float noise_ = 0.0f;                        // grey levels
};

// The regions as runs of pixels of the maps.
void add_regions(const cv::Mat& regions, const StationComparison& comparison, PanoramaSize size,
                 PanoramaSize maps, ContradictedStation* found) {
  const int step = maps.width / size.width;
  for (int theta = 0; theta < size.width; ++theta) {
    for (int phi = 0; phi < size.height; ++phi) {
      if (regions.at<uchar>(theta, phi) == 0) continue;
      found->behind.push_back({theta, phi, comparison.surface_behind(theta, phi)});
      const bool continues = phi > 0 && regions.at<uchar>(theta, phi - 1) != 0;
      for (int column = 0; column < step; ++column) {
        if (!continues) {
          int end = phi + 1;
          while (end < size.height && regions.at<uchar>(theta, end) != 0) ++end;
          found->runs.insert(found->runs.end(), {found->station.station, theta * step + column,
                                                 phi * step, end * step});
        }
      }
    }
  }
}

}  // namespace

StationEvidence evidence_of(const Room& room, StationIndex station, PanoramaSize size,
                            const GainField& gains, const InverseDistanceMap* map) {
  StationEvidence evidence{station, room.grid().station(station).position_m, {}, {}, {}, {}, {}};
  const StationColours colours = station_colours(room, station, size, gains);
  const cv::Mat around = cv::Mat::ones(3, 3, CV_8UC1);
  cv::erode(with_border(colours.least, 1), evidence.least, around);
  cv::dilate(with_border(colours.most, 1), evidence.most, around);
  evidence.colour = colours.shown;
  evidence.least = without_border(evidence.least, 1).clone();
  evidence.most = without_border(evidence.most, 1).clone();
  evidence.valid = station_validity(room, station, size, 2);
  if (map == nullptr) return evidence;
  const int step = map->size.width / size.width;
  for (int theta = 0; theta < size.width; ++theta) {
    for (int phi = 0; phi < size.height; ++phi) {
      const size_t pixel = pixel_index(theta * step + step / 2, phi * step + step / 2, map->size);
      evidence.inverse.push_back(map->confidence[pixel] < kMinConfidence ? -1.0f
                                                                         : map->inverse[pixel]);
    }
  }
  return evidence;
}

ContradictedStation contradicted_by(
    std::span<const std::shared_ptr<const StationEvidence>> neighbours, const StationEvidence& own,
    PanoramaSize size, float tolerance_per_m, PanoramaSize maps) {
  const StationComparison comparison(own, neighbours, size, tolerance_per_m);
  ContradictedStation found{own.station, {}, {}};
  add_regions(contradicted_regions(comparison.gaps(), comparison.limits()), comparison, size, maps,
              &found);
  return found;
}

}  // namespace raywalk::build_lf
