#include "calibrate/rectify/exposure_gains.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "calibrate/base/disjoint_sets.h"
#include "calibrate/rectify/light_estimate.h"
#include "core/base/median.h"
#include "core/geometry/sphere.h"
#include "core/panorama/srgb.h"

namespace raywalk::calibrate {
namespace {

// Fewer patches say nothing about a link.
constexpr std::size_t kLeastPatches = 16;
// What rounding to 8 bits may do to a frame's exposure.
constexpr double kLeastError = 2e-4;

using Order = std::function<double(const MatchedPatch&)>;

// The patches of a link with the lower and the upper half of the values of `order`.
struct Halves {
  std::vector<LinkPatches> lower, upper;
};

Halves halves_by(std::span<const LinkPatches> links, const Order& order) {
  Halves halves;
  for (const LinkPatches& link : links) {
    std::vector<MatchedPatch> sorted = link.patches;
    std::stable_sort(
        sorted.begin(), sorted.end(),
        [&](const MatchedPatch& a, const MatchedPatch& b) { return order(a) < order(b); });
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    halves.lower.push_back({link.link, {sorted.begin(), middle}});
    halves.upper.push_back({link.link, {middle, sorted.end()}});
  }
  return halves;
}

struct Split {
  const char* name;
  Order order;
};

// What errors of matching, of parallax, of uneven light in the picture, and of approaching depend
// on.
std::vector<Split> splits() {
  return {{"match quality", [](const MatchedPatch& patch) { return patch.error; }},
          {"distance", [](const MatchedPatch& patch) { return patch.parallax; }},
          {"height", [](const MatchedPatch& patch) { return patch.seen_from.y(); }},
          {"direction of motion", [](const MatchedPatch& patch) { return patch.ahead; }}};
}

// Eight sectors of the horizon in three layers of equal solid angle.
int part_of_scene(const Eigen::Vector3d& point_m, const Eigen::Vector3d& centre_m) {
  constexpr int kLayers = 3;
  constexpr int kSectors = kSceneParts / kLayers;
  const Eigen::Vector3d direction = (point_m - centre_m).normalized();
  const double turn = std::atan2(direction.x(), direction.z()) / kTwoPi + 0.5;
  const int sector = std::clamp(static_cast<int>(turn * kSectors), 0, kSectors - 1);
  const int layer =
      std::clamp(static_cast<int>(0.5 * (direction.y() + 1.0) * kLayers), 0, kLayers - 1);
  return layer * kSectors + sector;
}

double log_ratio_of(int kind, const Eigen::Array3d& rgb) {
  const double mean = rgb.mean();
  if (kind == 0) return mean;
  return (kind == 1 ? rgb[0] : rgb[2]) - mean;
}

// Light less what the place in the picture takes or gives by these coefficients of lens_terms.
std::vector<LightSample> without_lens(std::vector<LightSample> samples, const LensTerms& lens) {
  for (LightSample& sample : samples) {
    sample.log_ratio -= lens.dot(sample.lens);
    sample.lens.setZero();
  }
  return samples;
}

std::vector<LightSample> samples_of(std::span<const LinkPatches> links, int kind,
                                    const Eigen::Vector3d& centre_m) {
  std::vector<LightSample> samples;
  for (const auto& [link, patches] : links) {
    for (const MatchedPatch& patch : patches) {
      samples.push_back({.from = link.from,
                         .to = link.to,
                         .log_ratio = log_ratio_of(kind, patch.log_ratio),
                         .error = patch.error,
                         .part = part_of_scene(patch.point_m, centre_m),
                         .lens = lens_terms(patch.seen_to) - lens_terms(patch.seen_from)});
    }
  }
  return samples;
}

double root_mean_square(const Eigen::VectorXd& values) {
  return values.size() == 0 ? 0.0 : std::sqrt(values.squaredNorm() / values.size());
}

// What the halves differ by, and half of what exceeds chance as an error of the whole.
struct HalvesDisagreement {
  HalvesComparison comparison{};
  Eigen::RowVectorXd error;
};

// `lens` is that of the whole: a half alone, such as the upper one, cannot tell it well.
HalvesDisagreement disagreement_of(const Split& split, std::span<const LinkPatches> links, int kind,
                                   const LensTerms& lens, int frames,
                                   const Eigen::Vector3d& centre_m) {
  const Halves halves = halves_by(links, split.order);
  const auto estimate_of = [&](std::span<const LinkPatches> half) {
    return estimate_light(without_lens(samples_of(half, kind, centre_m), lens), frames);
  };
  const LightEstimate lower = estimate_of(halves.lower), upper = estimate_of(halves.upper);
  const Eigen::VectorXd difference = lower.log_light - upper.log_light;
  const double squares = difference.squaredNorm();
  const double by_chance = (lower.influence - upper.influence).squaredNorm();
  const double excess = squares > by_chance ? std::sqrt(1.0 - by_chance / squares) : 0.0;
  return {{.split = split.name,
           .difference = root_mean_square(difference),
           .by_chance = std::sqrt(by_chance / std::max(1, frames))},
          0.5 * excess * difference.transpose()};
}

// Without samples of two parts of the scene nothing can be said.
int parts_in(std::span<const LightSample> samples) {
  std::array<bool, kSceneParts> found{};
  for (const LightSample& sample : samples) found[static_cast<std::size_t>(sample.part)] = true;
  return static_cast<int>(std::count(found.begin(), found.end(), true));
}

MeasuredLight measure_light(std::span<const LinkPatches> links, int kind, int frames,
                            std::span<const PictureLine> lines, const Eigen::Vector3d& centre_m) {
  const std::vector<LightSample> samples = samples_of(links, kind, centre_m);
  const LightEstimate estimate = estimate_light(samples, frames);
  MeasuredLight light{.spread = root_mean_square(estimate.log_light)};
  const std::vector<Split> kinds_of_halves = splits();
  const auto extra = static_cast<Eigen::Index>(kinds_of_halves.size());
  UncertainLight uncertain{.value = estimate.log_light,
                           .errors = Eigen::MatrixXd::Zero(kSceneParts + extra + frames, frames),
                           .freedom = parts_in(samples) - 1};
  uncertain.errors.topRows(kSceneParts) = estimate.influence;
  for (Eigen::Index i = 0; i < extra; ++i) {
    const HalvesDisagreement found = disagreement_of(kinds_of_halves[static_cast<std::size_t>(i)],
                                                     links, kind, estimate.lens, frames, centre_m);
    light.halves.push_back(found.comparison);
    uncertain.errors.row(kSceneParts + i) = found.error;
  }
  uncertain.errors.bottomRows(frames).diagonal().setConstant(kLeastError);
  light.decision = decide_exposures(uncertain, lines);
  return light;
}

// The better half of the matches of every link that has enough.
std::vector<LinkPatches> better_half(std::span<const LinkPatches> links) {
  std::vector<LinkPatches> better =
      halves_by(links, [](const MatchedPatch& patch) { return patch.error; }).lower;
  std::erase_if(better,
                [](const LinkPatches& link) { return link.patches.size() < kLeastPatches; });
  return better;
}

std::vector<bool> linked_frames(std::span<const LinkPatches> links, int frames) {
  std::vector<bool> linked(static_cast<std::size_t>(frames), false);
  for (const LinkPatches& link : links) {
    linked[static_cast<std::size_t>(link.link.from)] = true;
    linked[static_cast<std::size_t>(link.link.to)] = true;
  }
  return linked;
}

std::vector<PictureLine> measured_lines(std::span<const PictureLine> lines,
                                        const std::vector<bool>& measured) {
  std::vector<PictureLine> kept;
  for (const PictureLine& line : lines) {
    PictureLine shorter;
    for (std::size_t i = 0; i < line.pictures.size(); ++i) {
      if (!measured[static_cast<std::size_t>(line.pictures[i])]) continue;
      shorter.pictures.push_back(line.pictures[i]);
      shorter.along_m.push_back(line.along_m[i]);
    }
    if (!shorter.pictures.empty()) kept.push_back(shorter);
  }
  return kept;
}

// The number of independent loops of the links.
int count_loops(std::span<const LinkPatches> links, int frames) {
  DisjointSets joined(frames);
  int loops = 0;
  for (const LinkPatches& link : links) {
    const int from = link.link.from, to = link.link.to;
    loops += joined.root(from) == joined.root(to) ? 1 : 0;
    joined.join(from, to);
  }
  return loops;
}

double loop_error(std::span<const LinkPatches> links, int frames, const Eigen::Vector3d& centre_m) {
  const LightEstimate estimate = estimate_light(samples_of(links, 0, centre_m), frames);
  Eigen::VectorXd left(static_cast<Eigen::Index>(links.size()));
  for (std::size_t i = 0; i < links.size(); ++i) {
    std::vector<double> residuals;
    for (const LightSample& sample : samples_of(links.subspan(i, 1), 0, centre_m)) {
      residuals.push_back(sample.log_ratio - sample.lens.dot(estimate.lens) -
                          estimate.log_light[sample.to] + estimate.log_light[sample.from]);
    }
    left[static_cast<Eigen::Index>(i)] = median(std::move(residuals));
  }
  return root_mean_square(left);
}

}  // namespace

const char* light_kind_name(int kind) {
  constexpr std::array<const char*, kLightKinds> kNames{"brightness", "red", "blue"};
  return kNames[static_cast<std::size_t>(kind)];
}

LightGain gain_of(double brightness, double red, double blue) {
  return {std::exp(-brightness - red), std::exp(-brightness + red + blue),
          std::exp(-brightness - blue)};
}

ExposureResult measure_exposures(std::span<const LinkPatches> links, int frames,
                                 std::span<const PictureLine> lines,
                                 const Eigen::Vector3d& centre_m) {
  const std::vector<LinkPatches> used = better_half(links);
  ExposureResult result{
      .gains = std::vector<LightGain>(static_cast<std::size_t>(frames), {1, 1, 1}),
      .measured = linked_frames(used, frames),
      .links = static_cast<int>(used.size()),
      .scene_parts = parts_in(samples_of(used, 0, centre_m)),
      .loops = count_loops(used, frames),
      .loop_error = loop_error(used, frames, centre_m)};
  for (const LinkPatches& link : used) result.patches += static_cast<int>(link.patches.size());
  const std::vector<PictureLine> measured = measured_lines(lines, result.measured);
  for (int kind = 0; kind < kLightKinds; ++kind) {
    result.light[static_cast<std::size_t>(kind)] =
        measure_light(used, kind, frames, measured, centre_m);
  }
  for (int i = 0; i < frames; ++i) {
    const auto correction = [&](std::size_t kind) {
      return result.light[kind].decision.correction[i];
    };
    result.gains[static_cast<std::size_t>(i)] =
        gain_of(correction(0), correction(1), correction(2));
  }
  return result;
}

LevelsUnderGain::LevelsUnderGain(const LightGain& gain) {
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < table_[c].size(); ++i) {
      const double level = static_cast<double>(i) / kStepsPerLevel;
      table_[c][i] =
          static_cast<float>(srgb_level_from_linear(gain[c] * linear_from_srgb_level(level)));
    }
  }
}

cv::Vec3f LevelsUnderGain::operator()(const cv::Vec3f& levels) const {
  cv::Vec3f changed;
  for (int c = 0; c < 3; ++c) {
    const auto& table = table_[static_cast<std::size_t>(2 - c)];
    const float at = std::clamp(levels[c], 0.0f, 255.0f) * kStepsPerLevel;
    const auto below = static_cast<std::size_t>(at);
    const float share = at - static_cast<float>(below);
    changed[c] = table[below] + share * (table[below + 1] - table[below]);
  }
  return changed;
}

}  // namespace raywalk::calibrate
