#include "calibrate/rectify/held_out_light.h"

#include <algorithm>
#include <cmath>

namespace raywalk::calibrate {
namespace {

constexpr std::size_t kNeighbours = 4;

void extend(Eigen::VectorXd* values, Eigen::Index size) {
  const Eigen::Index before = values->size();
  values->conservativeResize(size);
  values->tail(size - before).setZero();
}

// What is left of the stations' measured light after their correction, mean.
double corrected_level(const ExposureResult& stations, const ExposureDecision& of_stations,
                       const ExposureDecision& of_all) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < stations.measured.size(); ++i) {
    if (!stations.measured[i]) continue;
    const auto at = static_cast<Eigen::Index>(i);
    sum += of_all.measured[at] - of_stations.correction[at];
    ++count;
  }
  return count > 0 ? sum / count : 0.0;
}

}  // namespace

std::vector<FrameLink> held_out_links(const CaptureSet& set, const FramePoses& poses) {
  std::vector<int> posed;
  for (std::size_t i = 0; i < set.stations(); ++i) {
    if (poses[i]) posed.push_back(static_cast<int>(i));
  }
  std::vector<FrameLink> links;
  for (std::size_t held_out = set.stations(); held_out < set.frames.size(); ++held_out) {
    if (!poses[held_out]) continue;
    const auto away_m = [&](int station) {
      return (poses[static_cast<std::size_t>(station)]->position_m - poses[held_out]->position_m)
          .norm();
    };
    const std::size_t count = std::min(kNeighbours, posed.size());
    std::partial_sort(posed.begin(), posed.begin() + static_cast<std::ptrdiff_t>(count),
                      posed.end(), [&](int a, int b) { return away_m(a) < away_m(b); });
    for (std::size_t i = 0; i < count; ++i) {
      links.push_back({posed[i], static_cast<int>(held_out)});
    }
  }
  return links;
}

void add_held_out_light(std::span<const LinkPatches> links, int frames,
                        std::span<const PictureLine> lines, const Eigen::Vector3d& centre_m,
                        ExposureResult* stations) {
  const std::size_t first = stations->gains.size();
  // A held-out frame is like a line of its own: nothing is assumed about its exposure.
  std::vector<PictureLine> with_held_out(lines.begin(), lines.end());
  for (int i = static_cast<int>(first); i < frames; ++i) {
    with_held_out.push_back({.pictures = {i}, .along_m = {0.0}});
  }
  const ExposureResult all = measure_exposures(links, frames, with_held_out, centre_m);
  for (std::size_t kind = 0; kind < stations->light.size(); ++kind) {
    ExposureDecision& decision = stations->light[kind].decision;
    const ExposureDecision& of_all = all.light[kind].decision;
    const double level = corrected_level(*stations, decision, of_all);
    for (Eigen::VectorXd* values :
         {&decision.measured, &decision.fitted, &decision.error, &decision.correction}) {
      extend(values, frames);
    }
    for (Eigen::Index i = static_cast<Eigen::Index>(first); i < frames; ++i) {
      if (!all.measured[static_cast<std::size_t>(i)]) continue;
      const double value = of_all.measured[i] - level;
      decision.measured[i] = decision.fitted[i] = value;
      decision.error[i] = of_all.error[i];
      const double limit = of_all.t_limit_single * of_all.error[i];
      if (limit > 0.0 && std::abs(value) > limit) decision.correction[i] = value;
    }
  }
  for (std::size_t i = first; i < static_cast<std::size_t>(frames); ++i) {
    const auto correction = [&](std::size_t kind) {
      return stations->light[kind].decision.correction[static_cast<Eigen::Index>(i)];
    };
    stations->gains.push_back(gain_of(correction(0), correction(1), correction(2)));
    stations->measured.push_back(all.measured[i]);
  }
}

}  // namespace raywalk::calibrate
