#include "build_lf/depth/contradictions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "build_lf/depth/contradicted_regions.h"
#include "build_lf/depth/pixel_directions.h"
#include "build_lf/depth/station_evidence.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/room/distance_volume.h"

namespace raywalk::build_lf {
namespace {

constexpr int kLargestWidth = 512;  // regions of people are larger; four times cheaper than 1024
constexpr size_t kOfOwnLine = 4;    // stations compared
constexpr size_t kOfOtherLines = 8;
constexpr size_t kMostNeighbours = kOfOwnLine + kOfOtherLines;
constexpr int kLeastWitnesses = 3;
constexpr float kAgreeingShare = 0.7f;
constexpr float kAgreePx = 2.0f;  // of parallax at the reach: maps agree on a surface

// The size of the maps or a half, a quarter, ... of it.
PanoramaSize size_for(PanoramaSize maps) {
  PanoramaSize size = maps;
  while (size.width > kLargestWidth && size.width % 8 == 0) {
    size = {size.width / 2, size.height / 2};
  }
  return size;
}

// The maps of the plan to compare a station with: the nearest of its own line and of others.
std::vector<int> neighbours_of(const DepthPlan& plan, StationIndex station,
                               const Eigen::Vector3d& position_m) {
  std::vector<std::pair<double, int>> by_distance;
  for (int i = 0; i < static_cast<int>(plan.maps.size()); ++i) {
    const SweepReference& map = plan.maps[static_cast<size_t>(i)];
    if (!(map.station == station)) {
      by_distance.emplace_back((map.position_m - position_m).norm(), i);
    }
  }
  std::ranges::sort(by_distance);
  std::vector<int> neighbours;
  std::array<size_t, 2> left{kOfOtherLines, kOfOwnLine};
  for (const auto& [distance_m, i] : by_distance) {
    const bool same_line = plan.maps[static_cast<size_t>(i)].station.line == station.line;
    size_t& open = left[same_line ? 1 : 0];
    if (open == 0) continue;
    --open;
    neighbours.push_back(i);
  }
  return neighbours;
}

using Colours = std::array<std::uint8_t, kMostNeighbours>;

// One station compared with others.
class Comparison {
 public:
  Comparison(const StationEvidence& own,
             std::vector<std::shared_ptr<const StationEvidence>> neighbours, PanoramaSize size,
             float tolerance_per_m)
      : own_(own),
        neighbours_(std::move(neighbours)),
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

  // CV_32FC1: grey levels by which each pixel lies outside what the others show.
  cv::Mat gaps(cv::Mat* behind) const {
    cv::Mat gaps = cv::Mat::zeros(size_.width, size_.height, CV_32FC1);
    *behind = cv::Mat(size_.width, size_.height, CV_32FC1, cv::Scalar(-1.0));
    parallel_for(0, size_.width, 8, [&](int begin, int end) {
      for (int theta = begin; theta < end; ++theta) {
        for (int phi = 0; phi < size_.height; ++phi) {
          const Verdict verdict = judge(theta, phi);
          gaps.at<float>(theta, phi) = verdict.gap;
          behind->at<float>(theta, phi) = verdict.omega;
        }
      }
    });
    return gaps;
  }

  GapLimits limits() const {
    constexpr float kLeastWeak = 12.0f;
    constexpr float kLeastStrong = 24.0f;
    return {std::max(kLeastWeak, 4.0f * noise_), std::max(kLeastStrong, 8.0f * noise_)};
  }

 private:
  struct Verdict {
    float gap = 0.0f;     // grey levels
    float omega = -1.0f;  // of the surface that the others see; negative: they do not tell
  };

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
        std::vector<float>& seen = surfaces_[i];
        seen.assign(neighbours_[i]->omega.size(), -1.0f);
        for (int theta = 0; theta < size_.width; ++theta) {
          for (int phi = 0; phi < size_.height; ++phi) {
            const float omega = neighbours_[i]->omega[pixel_index(theta, phi, size_)];
            if (omega < 0.0f) continue;
            const Eigen::Vector3f point = directions_.of(theta, phi) - omega * offsets_[i];
            float& nearest = seen[pixel_of(point, size_)];
            nearest = std::max(nearest, omega / point.norm());
          }
        }
      }
    });
  }

  float tolerance_at(float omega) const { return tolerance_ + slant_ * omega; }

  // The surfaces that at least two neighbours see in a direction, nearest first, and the station's
  // own distance.
  std::vector<float> hypotheses(size_t pixel) const {
    std::vector<float> proposed;
    for (const auto& surfaces : surfaces_) {
      if (surfaces[pixel] >= 0.0f) proposed.push_back(surfaces[pixel]);
    }
    std::ranges::sort(proposed, std::greater());
    std::vector<float> distinct;
    for (size_t i = 0; i < proposed.size();) {
      size_t next = i;
      while (next < proposed.size() && proposed[i] - proposed[next] <= tolerance_at(proposed[i])) {
        ++next;
      }
      if (next - i >= 2) distinct.push_back(proposed[i + (next - i) / 2]);
      i = next;
    }
    if (!own_.omega.empty() && own_.omega[pixel] >= 0.0f) distinct.push_back(own_.omega[pixel]);
    return distinct;
  }

  Witnesses witnesses_of(const Eigen::Vector3f& direction, float omega, bool by_maps) const {
    Witnesses witnesses;
    for (size_t i = 0; i < neighbours_.size(); ++i) {
      const StationEvidence& other = *neighbours_[i];
      const Eigen::Vector3f point = direction + omega * offsets_[i];
      const size_t there = pixel_of(point, size_);
      const auto theta = static_cast<int>(there / static_cast<size_t>(size_.height));
      const auto phi = static_cast<int>(there % static_cast<size_t>(size_.height));
      if (!other.shows(theta, phi)) continue;
      if (by_maps) {
        const float expected = omega / point.norm();
        const float held = other.omega[there];
        if (held < 0.0f || std::fabs(held - expected) > tolerance_at(expected)) continue;
      }
      const auto n = static_cast<size_t>(witnesses.count++);
      const auto& colour = other.colour.at<cv::Vec3b>(theta, phi);
      for (int c = 0; c < 3; ++c) witnesses.colour[static_cast<size_t>(c)][n] = colour[c];
      witnesses.range[n] = other.range(theta, phi);
    }
    return witnesses;
  }

  static cv::Vec3b median_of(const Witnesses& witnesses) {
    cv::Vec3b median;
    for (int c = 0; c < 3; ++c) {
      Colours sorted = witnesses.colour[static_cast<size_t>(c)];
      const auto end = sorted.begin() + witnesses.count;
      const auto middle = sorted.begin() + witnesses.count / 2;
      std::nth_element(sorted.begin(), middle, end);
      median[c] = *middle;
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
  bool shown_by_others(const Eigen::Vector3f& direction, float omega,
                       const ColourRange& own) const {
    const Witnesses all = witnesses_of(direction, omega, false);
    const auto weak = static_cast<int>(limits().weak);
    int same = 0;
    for (int i = 0; i < all.count; ++i) {
      same += gap_between(all.range[static_cast<size_t>(i)], own) <= weak ? 1 : 0;
    }
    return same >= kLeastWitnesses && 2 * same >= all.count;
  }

  Verdict judge(int theta, int phi) const {
    if (!own_.shows(theta, phi)) return {};
    const Eigen::Vector3f direction = directions_.of(theta, phi);
    const size_t pixel = pixel_index(theta, phi, size_);
    const ColourRange own = own_.range(theta, phi);
    Verdict verdict;
    bool judged = false;
    for (const float omega : hypotheses(pixel)) {
      const auto gap = gap_from(witnesses_of(direction, omega, true), own);
      if (!gap) continue;
      if (!judged) verdict = {*gap, omega};
      verdict.gap = std::min(verdict.gap, *gap);
      judged = true;
      if (verdict.gap <= 0.0f) return verdict;
    }
    const bool contradicted = judged && verdict.gap > limits().weak;
    const bool own_distance = !own_.omega.empty() && own_.omega[pixel] >= 0.0f;
    if (contradicted && own_distance && shown_by_others(direction, own_.omega[pixel], own)) {
      verdict.gap = 0.0f;
    }
    return verdict;
  }

  // The median difference between the station's colours and those of the others, grey levels.
  float measure_noise() const {
    constexpr int kEvery = 5;
    std::vector<float> differences;
    for (int theta = 0; theta < size_.width; theta += kEvery) {
      for (int phi = 0; phi < size_.height; phi += kEvery) {
        const size_t pixel = pixel_index(theta, phi, size_);
        const std::vector<float> surfaces = hypotheses(pixel);
        if (surfaces.empty() || !own_.shows(theta, phi)) continue;
        const Witnesses witnesses =
            witnesses_of(directions_.of(theta, phi), surfaces.front(), true);
        if (witnesses.count < kLeastWitnesses) continue;
        const cv::Vec3b median = median_of(witnesses);
        const auto& colour = own_.colour.at<cv::Vec3b>(theta, phi);
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
  std::vector<std::shared_ptr<const StationEvidence>> neighbours_;
  PanoramaSize size_;
  PixelDirections directions_;
  float tolerance_;                           // 1/m
  float slant_;                               // share of the inverse distance
  std::vector<Eigen::Vector3f> offsets_;      // from each neighbour to this station, metres
  std::vector<std::vector<float>> surfaces_;  // inverse distances from here; negative: none seen
  float noise_ = 0.0f;                        // grey levels
};

// The regions as runs of pixels of the maps.
void add_regions(const cv::Mat& regions, const cv::Mat& behind, PanoramaSize size,
                 PanoramaSize maps, ContradictedStation* found) {
  const int step = maps.width / size.width;
  double all = 0.0;
  for (int theta = 0; theta < size.width; ++theta) {
    for (int phi = 0; phi < size.height; ++phi) {
      const double solid_angle = std::sin((phi + 0.5) * kPi / size.height);
      all += solid_angle;
      if (regions.at<uchar>(theta, phi) == 0) continue;
      found->share += solid_angle;
      found->behind.push_back({theta, phi, behind.at<float>(theta, phi)});
      const bool continues = phi > 0 && regions.at<uchar>(theta, phi - 1) != 0;
      for (int column = 0; column < step; ++column) {
        if (!continues) {
          int end = phi + 1;
          while (end < size.height && regions.at<uchar>(theta, end) != 0) ++end;
          found->runs.insert(found->runs.end(), {theta * step + column, phi * step, end * step});
        }
      }
    }
  }
  found->share /= all;
}

}  // namespace

Contradictions find_contradictions(const Room& room, const DepthPlan& plan,
                                   const std::vector<std::vector<GainField>>& gains,
                                   const FinalMap& final_map) {
  Contradictions result{size_for(plan.size), {}};
  EvidenceCache cache(room, plan, result.size, gains, final_map);
  const auto tolerance = static_cast<float>(kAgreePx / plan.pixels_per_omega_m());
  std::int64_t count = 0;
  for (const Line& line : room.grid().lines) {
    count += static_cast<std::int64_t>(line.stations.size());
  }
  Progress progress("looking for what moved", count, "stations");
  for (int l = 0; l < static_cast<int>(room.grid().lines.size()); ++l) {
    const Line& line = room.grid().lines[static_cast<size_t>(l)];
    for (int s = 0; s < static_cast<int>(line.stations.size()); ++s) {
      throw_if_interrupted();
      const StationIndex station{l, s};
      std::vector<std::shared_ptr<const StationEvidence>> neighbours;
      for (const int i :
           neighbours_of(plan, station, line.stations[static_cast<size_t>(s)].position_m)) {
        neighbours.push_back(cache.get(i));
      }
      const auto mapped = std::ranges::find(plan.maps, station, &SweepReference::station);
      const std::shared_ptr<const StationEvidence> own =
          mapped != plan.maps.end() ? cache.get(static_cast<int>(mapped - plan.maps.begin()))
                                    : std::make_shared<StationEvidence>(evidence_without_map(
                                          room, station, result.size,
                                          gains[static_cast<size_t>(l)][static_cast<size_t>(s)]));
      const Comparison comparison(*own, std::move(neighbours), result.size, tolerance);
      cv::Mat behind;
      const cv::Mat gaps = comparison.gaps(&behind);
      ContradictedStation found{station, 0.0, {}, {}};
      add_regions(contradicted_regions(gaps, comparison.limits()), behind, result.size, plan.size,
                  &found);
      if (!found.runs.empty()) result.stations.push_back(std::move(found));
      progress.advance();
    }
  }
  return result;
}

void show_behind(const Contradictions& contradictions, double tolerance_per_m,
                 InverseDistanceMap* map) {
  const auto found =
      std::ranges::find(contradictions.stations, map->station, &ContradictedStation::station);
  if (found == contradictions.stations.end()) return;
  const int step = map->size.width / contradictions.size.width;
  for (const SurfaceBehind& behind : found->behind) {
    for (int theta = behind.theta * step; theta < (behind.theta + 1) * step; ++theta) {
      for (int phi = behind.phi * step; phi < (behind.phi + 1) * step; ++phi) {
        const size_t pixel = pixel_index(theta, phi, map->size);
        if (behind.omega < 0.0f) {
          map->confidence[pixel] = 0;
        } else if (std::fabs(map->omega[pixel] - behind.omega) > tolerance_per_m) {
          map->omega[pixel] = behind.omega;
          map->confidence[pixel] = kMinConfidence;
        }
      }
    }
  }
}

}  // namespace raywalk::build_lf
