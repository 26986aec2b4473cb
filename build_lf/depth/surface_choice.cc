#include "build_lf/depth/surface_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "build_lf/depth/located_points.h"
#include "build_lf/depth/pixel_directions.h"
#include "build_lf/depth/sphere_walks.h"
#include "build_lf/depth/station_picture.h"
#include "build_lf/depth/tile_planes.h"
#include "core/base/parallel.h"

namespace raywalk::build_lf {
namespace {

// Costs are levels of colour, summed over the channels, of clean pictures (measured_noise). A view
// differs by at most kMostUnlike, and by at most kHidden where its map says that something nearer
// hides the point: about what noise and resampling make of a surface that is seen, so that being
// hidden is neither better nor much worse.
constexpr float kMostUnlike = 30.0f;
constexpr float kHidden = 12.0f;
// A surface that nearly all views say is hidden would have to be seen from here alone: its cost
// grows by kUnseen per share of the views over kMostHidden.
constexpr float kUnseen = 100.0f;
constexpr float kMostHidden = 0.9f;
// Of neighbours: per pixel of parallax beyond the first half, and for any jump, at most, where the
// colours are the same; across g levels a jump costs 1 + g / kJumpLevels times less.
constexpr float kPerPixel = 8.0f;
constexpr float kSamePlanePx = 0.5f;
constexpr float kJump = 60.0f;
constexpr float kJumpLevels = 5.0f;

// A pixel's own value and planes.
constexpr std::size_t kPlanesAround = 9;
constexpr std::size_t kMostCandidates = 1 + kPlanesAround;
using Costs = std::array<float, kMostCandidates>;

// The tiles whose points are looked up together, so that they lie close in a view.
constexpr int kTilesAcross = 4;
constexpr int kTilesDown = 8;

class Choice {
 public:
  Choice(const InverseDistanceMap& map, const StationColours& colours,
         std::span<const ChoiceView> views, double pixel_per_m)
      : map_(map),
        colours_(colours),
        own_(ranges_of(colours)),
        views_(views),
        pixel_per_m_(static_cast<float>(pixel_per_m)),
        slant_(kSlant * static_cast<float>(kPi) / static_cast<float>(map.size.width)),
        directions_(map.size),
        costs_(map.inverse.size()),
        sums_(map.inverse.size()) {
    for (const ChoiceView& view : views) {
      offsets_.push_back((map.position_m - view.map->position_m).cast<float>());
    }
    const TilePlanes planes(map, pixel_per_m);
    columns_ = planes.columns();
    rows_ = planes.rows();
    planes_.resize(tile_index(columns_, 0, rows_));
    parallel_for(0, columns_, 2, [&](int begin, int end) {
      for (int column = begin; column < end; ++column) {
        for (int row = 0; row < rows_; ++row) {
          planes_[tile_index(column, row, rows_)] = planes.around(column, row, kPlanesAround);
        }
      }
    });
  }

  InverseDistanceMap chosen() {
    noise_ = measured_noise();
    const int across = (columns_ + kTilesAcross - 1) / kTilesAcross;
    const int down = (rows_ + kTilesDown - 1) / kTilesDown;
    parallel_for(0, across * down, 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) compare(i / down * kTilesAcross, i % down * kTilesDown);
    });
    for_each_walk(map_.size, [&](Walk walk, int run_up, int steps) { carry(walk, run_up, steps); });
    InverseDistanceMap chosen = map_;
    for (int theta = 0; theta < map_.size.width; ++theta) {
      for (int phi = 0; phi < map_.size.height; ++phi) {
        const std::size_t pixel = pixel_index(theta, phi, map_.size);
        const auto best = std::min_element(
            sums_[pixel].begin(),
            sums_[pixel].begin() + static_cast<std::ptrdiff_t>(candidates(theta, phi)));
        chosen.inverse[pixel] =
            inverse_of(theta, phi, static_cast<std::size_t>(best - sums_[pixel].begin()));
      }
    }
    return chosen;
  }

 private:
  PanoramaSize sampled_size() const {
    return {map_.size.width * kSamplesPerPixel, map_.size.height * kSamplesPerPixel};
  }
  const std::vector<Plane>& planes_at(int theta, int phi) const {
    return planes_[tile_index(theta / kPlaneTile, phi / kPlaneTile, rows_)];
  }
  // How many a pixel has: its own value first.
  std::size_t candidates(int theta, int phi) const {
    const bool known = map_.confidence[pixel_index(theta, phi, map_.size)] != 0;
    return known ? 1 + planes_at(theta, phi).size() : 1;
  }
  // The inverse distance of a pixel's candidate in the direction of another pixel, which need not
  // meet its plane.
  float inverse_towards(int theta, int phi, std::size_t candidate,
                        const Eigen::Vector3f& direction) const {
    return candidate == 0 ? map_.inverse[pixel_index(theta, phi, map_.size)]
                          : planes_at(theta, phi)[candidate - 1].dot(direction);
  }
  float inverse_of(int theta, int phi, std::size_t candidate) const {
    return std::max(0.0f, inverse_towards(theta, phi, candidate, directions_.of(theta, phi)));
  }

  // A candidate of a pixel, and what the views say so far.
  struct Compared {
    std::size_t pixel = 0;
    std::size_t candidate = 0;
    Eigen::Vector3f direction{0, 0, 0};
    float inverse = 0.0f;
    float unlike = 0.0f;
    float hidden = 0.0f;  // the number of views
  };

  // Compares the candidates of a group of tiles with what all views show.
  void compare(int first_column, int first_row) {
    std::vector<Compared> all;
    const int end_theta = std::min(map_.size.width, (first_column + kTilesAcross) * kPlaneTile);
    const int end_phi = std::min(map_.size.height, (first_row + kTilesDown) * kPlaneTile);
    for (std::size_t candidate = 0; candidate < kMostCandidates; ++candidate) {
      for (int theta = first_column * kPlaneTile; theta < end_theta; ++theta) {
        for (int phi = first_row * kPlaneTile; phi < end_phi; ++phi) {
          if (candidate >= candidates(theta, phi)) continue;
          all.push_back({pixel_index(theta, phi, map_.size), candidate, directions_.of(theta, phi),
                         inverse_of(theta, phi, candidate)});
        }
      }
    }
    LocatedPoints points(all.size());
    for (std::size_t view = 0; view < views_.size(); ++view) {
      for (std::size_t i = 0; i < all.size(); ++i) {
        points.set(i, all[i].direction + all[i].inverse * offsets_[view]);
      }
      points.locate(all.size(), sampled_size());
      for (std::size_t i = 0; i < all.size(); ++i) {
        add_view(views_[view], points.pixel(i), points.length(i), &all[i]);
      }
    }
    for (const Compared& compared : all) {
      const auto count = static_cast<float>(views_.size());
      costs_[compared.pixel][compared.candidate] =
          compared.unlike / count + kUnseen * std::max(0.0f, compared.hidden / count - kMostHidden);
    }
  }

  // `sample`: the view's sample that shows the point; `length`: the point's distance from it, times
  // the candidate's inverse distance.
  void add_view(const ChoiceView& view, std::size_t sample, float length,
                Compared* compared) const {
    constexpr float kNearerPx = 1.5f;
    const ColourRange& there = view.ranges[sample];
    if (is_masked(there)) {
      compared->unlike += kHidden;
      return;
    }
    const ColourRange& own = range_at(own_, compared->pixel);
    const float gap = std::min(kMostUnlike, static_cast<float>(gaps_between(own, there)) / noise_);
    const auto sample_rows = static_cast<std::size_t>(sampled_size().height);
    const auto theta = static_cast<int>(sample / sample_rows) / kSamplesPerPixel;
    const auto phi = static_cast<int>(sample % sample_rows) / kSamplesPerPixel;
    const float expected = compared->inverse / length;
    const float nearest = view.map->inverse[pixel_index(theta, phi, map_.size)];
    const bool hidden = nearest > expected + kNearerPx * pixel_per_m_ + slant_ * expected;
    compared->unlike += hidden ? std::min(gap, kHidden) : gap;
    if (hidden) compared->hidden += 1.0f;
  }

  // How many times the gap between what two stations show of a surface is larger than where
  // pictures are clean: the median over pixels all over the map, by their own values; at least 1.
  float measured_noise() const {
    constexpr float kCleanLevels = 2.0f;
    constexpr int kApart = 16;
    std::vector<int> gaps;
    LocatedPoints points(views_.size());
    for (int theta = 0; theta < map_.size.width; theta += kApart) {
      for (int phi = 0; phi < map_.size.height; phi += kApart) {
        const std::size_t pixel = pixel_index(theta, phi, map_.size);
        if (map_.confidence[pixel] == 0) continue;
        for (std::size_t view = 0; view < views_.size(); ++view) {
          points.set(view, directions_.of(theta, phi) + map_.inverse[pixel] * offsets_[view]);
        }
        points.locate(views_.size(), sampled_size());
        for (std::size_t view = 0; view < views_.size(); ++view) {
          const ColourRange& there = views_[view].ranges[points.pixel(view)];
          if (!is_masked(there)) gaps.push_back(gaps_between(range_at(own_, pixel), there));
        }
      }
    }
    if (gaps.empty()) return 1.0f;
    const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
    std::nth_element(gaps.begin(), middle, gaps.end());
    return std::max(1.0f, static_cast<float>(*middle) / kCleanLevels);
  }

  // Adds the costs along a walk (Hirschmueller 2008) to those of the pixels on it.
  void carry(Walk walk, int run_up, int steps) {
    Costs before{};
    Walk last;
    for (int i = -run_up; i < steps; ++i) {
      const std::size_t pixel = pixel_index(walk.theta, walk.phi, map_.size);
      const std::size_t count = candidates(walk.theta, walk.phi);
      Costs path = costs_[pixel];
      if (i > -run_up) add_least(last, before, walk, &path);
      if (i >= 0) {
        for (std::size_t k = 0; k < count; ++k) sums_[pixel][k] += path[k];
      }
      before = path;
      last = walk;
      walk.advance(map_.size);
    }
  }

  // Adds to each candidate's cost the least cost of coming to it from the last pixel's, less the
  // least of the last pixel, which is the same for all.
  void add_least(const Walk& last, const Costs& before, const Walk& walk, Costs* path) const {
    const std::size_t count_before = candidates(last.theta, last.phi);
    const Eigen::Vector3f direction = directions_.of(walk.theta, walk.phi);
    Costs carried{};  // the last pixel's candidates, here
    float least = before[0];
    for (std::size_t j = 0; j < count_before; ++j) {
      carried[j] = inverse_towards(last.theta, last.phi, j, direction);
      least = std::min(least, before[j]);
    }
    const auto& colour = colours_.shown.at<cv::Vec3b>(walk.theta, walk.phi);
    const auto& colour_before = colours_.shown.at<cv::Vec3b>(last.theta, last.phi);
    float edge = 0.0f;
    for (int c = 0; c < 3; ++c)
      edge += std::fabs(float(colour[c]) - float(colour_before[c])) / 3.0f;
    const float jump = std::max(1.2f * kPerPixel, kJump / (1.0f + edge / kJumpLevels));
    const std::size_t count = candidates(walk.theta, walk.phi);
    for (std::size_t k = 0; k < count; ++k) {
      const float inverse = inverse_of(walk.theta, walk.phi, k);
      float cheapest = least + jump;
      for (std::size_t j = 0; j < count_before; ++j) {
        const float off_px = std::fabs(carried[j] - inverse) / pixel_per_m_;
        cheapest =
            std::min(cheapest, before[j] + kPerPixel * std::max(0.0f, off_px - kSamePlanePx));
      }
      (*path)[k] += cheapest - least;
    }
  }

  const InverseDistanceMap& map_;
  const StationColours& colours_;
  cv::Mat own_;
  std::span<const ChoiceView> views_;
  float pixel_per_m_;
  float slant_;         // share of the inverse distance
  float noise_ = 1.0f;  // measured_noise()
  PixelDirections directions_;
  std::vector<Eigen::Vector3f> offsets_;  // from each view's station to this one's, metres
  int columns_ = 0;                       // tiles
  int rows_ = 0;
  std::vector<std::vector<Plane>> planes_;  // of each tile
  std::vector<Costs> costs_;                // of each pixel
  std::vector<Costs> sums_;
};

}  // namespace

InverseDistanceMap choose_surfaces(const InverseDistanceMap& map, const StationColours& colours,
                                   std::span<const ChoiceView> views, double pixel_per_m) {
  constexpr std::size_t kFewest = 2;
  if (views.size() < kFewest) return map;
  return Choice(map, colours, views, pixel_per_m).chosen();
}

}  // namespace raywalk::build_lf
