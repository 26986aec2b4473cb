#include "build_lf/depth/map_fusion.h"

#include <algorithm>
#include <cmath>

#include "build_lf/depth/located_points.h"
#include "build_lf/depth/pixel_directions.h"
#include "build_lf/depth/seen_surfaces.h"
#include "core/base/parallel.h"

namespace raywalk::build_lf {
namespace {

class Fusion {
 public:
  Fusion(std::span<const InverseDistanceMap> maps, int which, const FusionOptions& options,
         std::span<const cv::Mat> colours)
      : maps_(maps),
        colours_(colours),
        map_(maps[static_cast<size_t>(which)]),
        which_(static_cast<size_t>(which)),
        nearby_(maps.size() - static_cast<size_t>(options.fallback_maps)),
        min_voters_(static_cast<size_t>(options.min_voters)),
        directions_(map_.size),
        tolerance_(static_cast<float>(options.tolerance_per_m)),
        slant_(kSlant * static_cast<float>(kPi) / static_cast<float>(map_.size.width)) {
    for (const InverseDistanceMap& map : maps) {
      offsets_.push_back((map_.position_m - map.position_m).cast<float>());
    }
  }

  // The proposals of each map: its surfaces projected into this map, the nearest one per pixel.
  void propose() {
    proposals_.resize(maps_.size());
    parallel_for(0, static_cast<int>(maps_.size()), 1, [&](int begin, int end) {
      for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
        proposals_[i] = i == which_ ? map_.inverse : seen_from_here(i);
      }
    });
  }

  InverseDistanceMap vote() const {
    InverseDistanceMap fused = map_;
    parallel_for(0, map_.size.width, 8, [&](int begin, int end) {
      LocatedPoints points(maps_.size());
      for (int theta = begin; theta < end; ++theta) {
        for (int phi = 0; phi < map_.size.height; ++phi) {
          const size_t pixel = pixel_index(theta, phi, map_.size);
          const Ballot best = elect(directions_.of(theta, phi), pixel, &points);
          fused.inverse[pixel] = best.inverse;
          fused.confidence[pixel] = best.confidence;
        }
      }
    });
    return fused;
  }

 private:
  struct Ballot {
    float inverse = 0.0f;
    float votes = 0.0f;
    float against = 0.0f;
    float voters = 0.0f;
    std::uint8_t confidence = 0;

    float score() const { return votes - against; }
  };

  std::vector<float> seen_from_here(size_t i) const {
    std::vector<float> known = maps_[i].inverse;
    for (size_t pixel = 0; pixel < known.size(); ++pixel) {
      if (maps_[i].confidence[pixel] == 0) known[pixel] = -1.0f;
    }
    std::vector<float> seen = seen_surfaces(known, map_.size, directions_, offsets_[i]);
    close_gaps(&seen);
    return seen;
  }

  // Around a pole, points of another map hit only few of the many pixels. Where this map has no
  // value of its own, pixels take the proposal of the nearest column within about the width of a
  // pixel at the horizon.
  void close_gaps(std::vector<float>* seen) const {
    const std::vector<float> drawn = *seen;
    for (int phi = 0; phi < map_.size.height; ++phi) {
      const double from_pole_rad = (phi + 0.5) * kPi / map_.size.height;
      const int reach =
          std::min(static_cast<int>(std::ceil(1.0 / std::sin(from_pole_rad))), map_.size.width / 2);
      for (int theta = 0; theta < map_.size.width; ++theta) {
        const size_t pixel = pixel_index(theta, phi, map_.size);
        if (map_.confidence[pixel] != 0) continue;
        for (int aside = 1; aside <= reach && (*seen)[pixel] < 0.0f; ++aside) {
          (*seen)[pixel] = std::max(drawn[column_beside(theta, aside, phi)],
                                    drawn[column_beside(theta, -aside, phi)]);
        }
      }
    }
  }

  size_t column_beside(int theta, int aside, int phi) const {
    return pixel_index((theta + aside + map_.size.width) % map_.size.width, phi, map_.size);
  }

  Ballot elect(const Eigen::Vector3f& direction, size_t pixel, LocatedPoints* points) const {
    constexpr float kNoVotes = -1e30f;
    Ballot best{map_.inverse[pixel], kNoVotes, 0.0f, 0.0f, 0};
    const size_t voter_count = map_.confidence[pixel] == 0 ? maps_.size() : nearby_;
    // Skips proposals close to one already voted on, which would get the same votes.
    std::vector<float> voted;
    voted.reserve(voter_count);
    for (size_t i = 0; i < voter_count; ++i) {
      const float proposed = proposals_[(which_ + i) % voter_count][pixel];
      const bool known = std::any_of(voted.begin(), voted.end(), [&](float other) {
        return std::fabs(other - proposed) < 0.25f * tolerance_;
      });
      if (proposed < 0.0f || known) continue;
      voted.push_back(proposed);
      const Ballot ballot = count(direction, pixel, proposed, voter_count, points);
      if (ballot.score() > best.score()) best = ballot;
    }
    return best;
  }

  // How much the colour of a pixel of map i is like that of a pixel of this map, 0 to 1; 1 where
  // this station does not show the scene.
  float likeness(size_t pixel, size_t i, size_t there) const {
    constexpr float kUnlikeLevels = 24.0f;
    if (colours_.empty() || i == which_ || map_.confidence[pixel] == 0) return 1.0f;
    const int gap = gap_between(range_at(colours_[which_], pixel), range_at(colours_[i], there));
    const float unlike = static_cast<float>(gap) / kUnlikeLevels;
    return 1.0f / (1.0f + unlike * unlike);
  }

  // Counts the votes of the first `voter_count` maps on a surface at inverse distance `proposed`.
  Ballot count(const Eigen::Vector3f& direction, size_t pixel, float proposed, size_t voter_count,
               LocatedPoints* points) const {
    for (size_t i = 0; i < voter_count; ++i) points->set(i, direction + proposed * offsets_[i]);
    points->locate(voter_count, map_.size);
    size_t known = 0;
    float votes = 0.0f;
    float against = 0.0f;
    float weights = 0.0f;
    float weighted = 0.0f;
    for (size_t i = 0; i < voter_count; ++i) {
      const float distance = points->length(i);
      const size_t there = points->pixel(i);
      if (maps_[i].confidence[there] == 0) continue;
      ++known;
      const float expected = proposed / distance;
      const float difference = maps_[i].inverse[there] - expected;
      const float tolerance = tolerance_ + slant_ * expected;
      if (std::fabs(difference) < tolerance) {
        const float like = likeness(pixel, i, there);
        votes += like * (1.0f - 0.5f * std::fabs(difference) / tolerance);
        against += 1.0f - like;
        // Only close agreement contributes to the mean.
        const float weight = like * static_cast<float>(maps_[i].confidence[there]) *
                             std::max(0.0f, 1.0f - 0.5f * std::fabs(difference) / tolerance_);
        weights += weight;
        weighted += weight * (proposed + difference * distance);
      } else if (difference < 0.0f) {
        against += std::min(1.0f, (-difference - tolerance) / tolerance);
      }
    }
    Ballot ballot;
    ballot.votes = votes;
    ballot.against = against;
    ballot.inverse = std::max(0.0f, weights > 0.0f ? weighted / weights : proposed);
    ballot.voters =
        static_cast<float>(min_voters_ > 0 ? std::max(known, min_voters_) : voter_count);
    const float share = votes / ballot.voters;
    // Confidence 0 (unknown) only without a vote.
    const float least = votes > 0.0f ? 1.0f : 0.0f;
    ballot.confidence = static_cast<std::uint8_t>(std::clamp(share * 255.0f, least, 255.0f));
    return ballot;
  }

  std::span<const InverseDistanceMap> maps_;
  std::span<const cv::Mat> colours_;
  const InverseDistanceMap& map_;
  size_t which_;
  size_t nearby_;      // maps that always vote; the others are fallbacks
  size_t min_voters_;  // FusionOptions
  PixelDirections directions_;
  float tolerance_;                       // 1/m
  float slant_;                           // share of the inverse distance
  std::vector<Eigen::Vector3f> offsets_;  // from each map's station to this one's, metres
  std::vector<std::vector<float>> proposals_;
};

}  // namespace

InverseDistanceMap fuse_maps(std::span<const InverseDistanceMap> maps, int which,
                             const FusionOptions& options, std::span<const cv::Mat> colours) {
  Fusion fusion(maps, which, options, colours);
  fusion.propose();
  return fusion.vote();
}

}  // namespace raywalk::build_lf
