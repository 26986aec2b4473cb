#include "calibrate/poses/contradictions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

constexpr double kContradictionSigmas = 5.0;  // of a scatter that is known well
constexpr double kLeastOff_spacings = 0.02;
// A rail keeps its stations far better than this.
constexpr double kLargeScatter_spacings = 0.25;
// Lengths of the slider, or of a tape measure, are better than this.
constexpr double kLeastStretch = 0.01;
// An explanation has to leave less than this share of the deviations.
constexpr double kConvincing = 0.5;

struct Station {
  std::size_t frame = 0;
  double listed_m = 0.0;  // rail position
  double found_m = 0.0;   // by its solved pose, along the rail
};

std::vector<Station> solved_stations(const CaptureSet& set, const FramePoses& poses,
                                     const Rail& rail, const CaptureLine& line) {
  std::vector<Station> stations;
  for (const std::size_t frame : line.frames) {
    const auto& pose = poses[frame];
    if (!pose || pose->origin != PoseOrigin::kSolved) continue;
    const double listed_m = set.rail_m(frame);
    const double off_m = deviation_of(set, rail, frame, *pose).off_m[0];
    stations.push_back({frame, listed_m, listed_m + off_m});
  }
  return stations;
}

// The mean absolute deviation that an explanation of where the stations were found leaves. A
// displacement of the whole line is no deviation.
double left_by(const std::vector<Station>& stations,
               const std::function<double(std::size_t)>& expected_m) {
  std::vector<double> off_m;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    off_m.push_back(stations[i].found_m - expected_m(i));
  }
  const double middle_m = median(off_m);
  double sum_m = 0.0;
  for (const double one_m : off_m) sum_m += std::abs(one_m - middle_m);
  return sum_m / static_cast<double>(stations.size());
}

// Found over listed length, from pairs of stations half a line apart.
double stretch_of(const std::vector<Station>& stations) {
  const std::size_t half = stations.size() / 2;
  std::vector<double> ratios;
  for (std::size_t i = 0; i + half < stations.size(); ++i) {
    const Station &a = stations[i], &b = stations[i + half];
    if (b.listed_m > a.listed_m) {
      ratios.push_back((b.found_m - a.found_m) / (b.listed_m - a.listed_m));
    }
  }
  return ratios.empty() ? 1.0 : median(std::move(ratios));
}

// Where station `i` was taken if the pictures from `first` on are those of the stations `by`
// further on. Beyond the ends the last step goes on.
double shifted_m(const std::vector<Station>& stations, std::size_t first, int by, std::size_t i) {
  if (i < first) return stations[i].listed_m;
  const auto at = static_cast<std::ptrdiff_t>(i) + by;
  if (at < std::ssize(stations)) return stations[static_cast<std::size_t>(at)].listed_m;
  return 2.0 * stations[i].listed_m - stations[i - 1].listed_m;
}

struct Shift {
  std::size_t first = 0;
  int by = 1;
  double left_m = std::numeric_limits<double>::infinity();
};

Shift best_shift(const std::vector<Station>& stations) {
  Shift best;
  for (std::size_t first = 1; first < stations.size(); ++first) {
    for (const int by : {1, -1}) {
      const double left_m =
          left_by(stations, [&](std::size_t i) { return shifted_m(stations, first, by, i); });
      if (left_m < best.left_m) best = {first, by, left_m};
    }
  }
  return best;
}

std::vector<std::size_t> frames_from(const std::vector<Station>& stations, std::size_t first) {
  std::vector<std::size_t> frames;
  for (std::size_t i = first; i < stations.size(); ++i) frames.push_back(stations[i].frame);
  return frames;
}

void list_at(double rail_m, std::size_t frame, LineAxis axis, CaptureSet* set) {
  set->frames[frame].nominal_m[axis == LineAxis::kX ? 0 : 2] = rail_m;
}

// A line that is listed wrong as a whole. `believed` gets the positions that explain its pictures.
std::optional<Contradiction> explained_line(const CaptureSet& set, const CaptureLine& line,
                                            const std::vector<Station>& stations, double spacing_m,
                                            CaptureSet* believed) {
  const double listed_left_m =
      left_by(stations, [&](std::size_t i) { return stations[i].listed_m; });
  if (listed_left_m < kLeastOff_spacings * spacing_m) return std::nullopt;
  const double stretch = stretch_of(stations);
  const auto stretched_m = [&](std::size_t i) { return stretch * stations[i].listed_m; };
  const double stretched_left_m = left_by(stations, stretched_m);
  const Shift shift = best_shift(stations);
  if (std::min(stretched_left_m, shift.left_m) > kConvincing * listed_left_m) return std::nullopt;
  if (stretched_left_m <= shift.left_m) {
    if (std::abs(stretch - 1.0) < kLeastStretch) return std::nullopt;
    for (std::size_t i = 0; i < stations.size(); ++i) {
      list_at(stretched_m(i), stations[i].frame, line.axis, believed);
    }
    return Contradiction{
        "stretched", frames_from(stations, 0),
        fmt::format("line {}: by the pictures it is {:.1f} % {} than listed", line.id,
                    100.0 * std::abs(stretch - 1.0), stretch > 1.0 ? "longer" : "shorter")};
  }
  for (std::size_t i = 0; i < stations.size(); ++i) {
    list_at(shifted_m(stations, shift.first, shift.by, i), stations[i].frame, line.axis, believed);
  }
  return Contradiction{
      "shifted", frames_from(stations, shift.first),
      fmt::format("line {}: from {} on the pictures are those of the {} station: a picture before "
                  "it {}, and the names after it are shifted by one",
                  line.id, set.frames[stations[shift.first].frame].name,
                  shift.by > 0 ? "next" : "previous",
                  shift.by > 0 ? "is missing" : "is there twice")};
}

Contradiction scattered_line(const CaptureSet& set, const CaptureLine& line,
                             const std::vector<Station>& stations) {
  const auto off_m = [](const Station& one) { return std::abs(one.found_m - one.listed_m); };
  const Station& worst = *std::ranges::max_element(stations, {}, off_m);
  return {"scattered", frames_from(stations, 0),
          fmt::format("line {}: by the pictures its stations are not where they are listed, {} for "
                      "one by {:.0f} mm along the line",
                      line.id, set.frames[worst.frame].name, 1e3 * off_m(worst))};
}

// The scatter of a line is measured from its stations, and the fewer they are, the more it may be
// wrong itself. Student's t of as rare an event as z standard deviations of a normal one, with n
// degrees of freedom: z + (z^3 + z) / (4 n) (Abramowitz and Stegun, Handbook of Mathematical
// Functions, 26.7.5, to first order).
double contradicting_sigmas(const Rail& rail) {
  constexpr double z = kContradictionSigmas;
  constexpr int kFitted = 3;  // offset and direction along the line, and the scatter
  return z + (z * z * z + z) / (4.0 * std::max(1, rail.stations - kFitted));
}

std::optional<Contradiction> station_off(const CaptureSet& set, const FramePose& pose,
                                         const Rail& rail, std::size_t frame, double spacing_m) {
  const Eigen::Vector3d off_m = deviation_of(set, rail, frame, pose).off_m;
  const double own_m = 1e-3 * pose.position_sigma_mm;
  const double along = std::abs(off_m[0]) / std::hypot(rail.scatter.along_m, own_m);
  const double across = off_m.tail<2>().norm() / std::hypot(rail.scatter.across_m, own_m);
  if (std::max(along, across) < contradicting_sigmas(rail) ||
      off_m.norm() < kLeastOff_spacings * spacing_m) {
    return std::nullopt;
  }
  return Contradiction{
      "off",
      {frame},
      fmt::format("{} lies {:.3g} mm from its listed place ({:+.3g} mm along its line, {:+.3g} "
                  "across, {:+.3g} up)",
                  set.frames[frame].name, 1e3 * off_m.norm(), 1e3 * off_m[0], 1e3 * off_m[1],
                  1e3 * off_m[2])};
}

// Joins what are single stations to pairs that were exchanged: each was found at the other's place
// on its rail, or one was and the other, whose picture was matched where it is listed, not solved.
class Exchanges {
 public:
  Exchanges(const CaptureSet& set, const FramePoses& poses, const std::vector<Rail>& rails)
      : set_(set), poses_(poses), rails_(rails) {}

  void join(std::vector<Contradiction>* single) const {
    for (std::size_t i = 0; i < single->size(); ++i) {
      const std::size_t a = (*single)[i].frames.front();
      const auto other = std::find_if(single->begin() + static_cast<std::ptrdiff_t>(i) + 1,
                                      single->end(), [&](const Contradiction& one) {
                                        const std::size_t b = one.frames.front();
                                        return found_at(a, b) && found_at(b, a);
                                      });
      if (other != single->end()) {
        const std::size_t b = other->frames.front();
        (*single)[i] = {
            "exchanged",
            {a, b},
            fmt::format("{} and {} lie at each other's listed places: they are exchanged", name(a),
                        name(b))};
        single->erase(other);
      } else if (const auto b = unsolved_where_found(a)) {
        (*single)[i] = {
            "exchanged",
            {a, *b},
            fmt::format(
                "{} lies at the listed place of {}, which was not solved: they may be exchanged",
                name(a), name(*b))};
      }
    }
  }

 private:
  const std::string& name(std::size_t frame) const { return set_.frames[frame].name; }
  bool is_solved(std::size_t frame) const {
    return poses_[frame] && poses_[frame]->origin == PoseOrigin::kSolved;
  }
  Eigen::Vector3d place_m(std::size_t frame) const {
    return pose_on_rail(set_, rails_[set_.frames[frame].line], frame).position_m;
  }
  bool found_at(std::size_t frame, std::size_t other) const {
    const double tolerance_m = 0.25 * (place_m(frame) - place_m(other)).norm();
    return (poses_[frame]->position_m - place_m(other)).norm() < tolerance_m;
  }
  std::optional<std::size_t> unsolved_where_found(std::size_t frame) const {
    const double tolerance_m = 0.25 * station_spacing_m(set_);
    for (const CaptureLine& line : set_.lines) {
      for (const std::size_t other : line.frames) {
        if (is_solved(other)) continue;
        if ((poses_[frame]->position_m - place_m(other)).norm() < tolerance_m) return other;
      }
    }
    return std::nullopt;
  }

  const CaptureSet& set_;
  const FramePoses& poses_;
  const std::vector<Rail>& rails_;
};

}  // namespace

std::vector<Contradiction> contradictions_of(const CaptureSet& set, const FramePoses& poses,
                                             const std::vector<Rail>& rails) {
  const double spacing_m = station_spacing_m(set);
  std::vector<std::vector<Station>> stations;
  std::vector<Contradiction> found, single;
  CaptureSet believed = set;
  for (std::size_t i = 0; i < rails.size(); ++i) {
    stations.push_back(solved_stations(set, poses, rails[i], set.lines[i]));
    if (stations[i].size() < 3) continue;
    auto whole = explained_line(set, set.lines[i], stations[i], spacing_m, &believed);
    if (whole) found.push_back(std::move(*whole));
  }
  const std::vector<Rail> fitted = found.empty() ? rails : fit_rails(believed, poses);
  for (std::size_t i = 0; i < fitted.size(); ++i) {
    if (stations[i].size() < 3) continue;
    if (fitted[i].scatter.along_m > kLargeScatter_spacings * spacing_m) {
      found.push_back(scattered_line(set, set.lines[i], stations[i]));
      continue;
    }
    for (const Station& station : stations[i]) {
      auto off = station_off(believed, *poses[station.frame], fitted[i], station.frame, spacing_m);
      if (off) single.push_back(std::move(*off));
    }
  }
  Exchanges(believed, poses, fitted).join(&single);
  found.insert(found.end(), single.begin(), single.end());
  return found;
}

}  // namespace raywalk::calibrate
