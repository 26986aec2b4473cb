#include "capture/import/film_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"

namespace raywalk::capture {
namespace {

constexpr double kCoarseStep_s = 0.1;
constexpr double kPeakWidth_s = 1.0;     // maxima closer than this count as one
constexpr double kMoving = 0.3;          // activity above this is motion
constexpr double kLeastExplained = 0.5;  // below, the film is of something else
constexpr double kClearlyWorse = 0.8;    // a rival above this share of the best is ambiguous
constexpr double kChi2_95 = 3.84;        // 95 % point of chi squared with one degree of freedom

double quantile(std::vector<double> values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

// The interval between two frames, or several merged ones.
struct Interval {
  double from_s = 0.0;
  double to_s = 0.0;
  double activity = 0.0;  // 0 at rest to 1 in steady motion
};

std::vector<Interval> intervals_of(const FilmTrack& track, const std::string& film) {
  std::vector<double> activities;
  for (std::size_t i = 1; i < track.frames.size(); ++i) {
    activities.push_back(track.frames[i].activity);
  }
  constexpr std::size_t kFewestFrames = 10;
  if (activities.size() < kFewestFrames) {
    throw Error(fmt::format("{}: {} frames are too few to detect the carriage's motion", film,
                            track.frames.size()));
  }
  const double rest = quantile(activities, 0.02);
  const double halfway = 0.5 * (rest + quantile(activities, 0.98));
  std::vector<double> moving;
  for (const double activity : activities) {
    if (activity > halfway) moving.push_back(activity);
  }
  // In grey levels; well above the noise of a camera at rest.
  constexpr double kLeastRise = 0.1;
  const double steady = moving.empty() ? rest : median(moving);
  if (steady < 1.3 * rest + kLeastRise) {
    throw Error(fmt::format(
        "{}: shows no start or stop of motion (the picture changes by {:.2f} to {:.2f} grey levels "
        "from frame to frame); film some seconds at rest before and after each line",
        film, rest, steady));
  }
  std::vector<Interval> intervals;
  for (std::size_t i = 1; i < track.frames.size(); ++i) {
    const double share = (track.frames[i].activity - rest) / (steady - rest);
    intervals.push_back(
        {track.frames[i - 1].time_s, track.frames[i].time_s, std::clamp(share, 0.0, 1.0)});
  }
  return intervals;
}

// The same film in longer intervals, for the search over all offsets.
std::vector<Interval> coarse(const std::vector<Interval>& intervals) {
  std::vector<Interval> longer;
  for (const Interval& interval : intervals) {
    if (longer.empty() || longer.back().to_s - longer.back().from_s >= kCoarseStep_s) {
      longer.push_back({interval.from_s, interval.from_s, 0.0});
    }
    Interval& last = longer.back();
    const double before_s = last.to_s - last.from_s;
    const double added_s = interval.to_s - interval.from_s;
    last.activity = (last.activity * before_s + interval.activity * added_s) / (before_s + added_s);
    last.to_s = interval.to_s;
  }
  return longer;
}

double steady_speed(std::span<const Travel> travels) {
  constexpr double kSample_s = 0.1;
  std::vector<double> speeds;
  double fastest = 0.0;
  for (const Travel& travel : travels) {
    for (double time_s = travel.begin_s(); time_s + kSample_s < travel.end_s();
         time_s += kSample_s) {
      speeds.push_back(travel.speed_mm_s(time_s, time_s + kSample_s));
      fastest = std::max(fastest, speeds.back());
    }
  }
  std::erase_if(speeds, [&](double speed) { return speed < 0.3 * fastest; });
  return speeds.empty() ? 0.0 : median(speeds);
}

// Evaluates how well an offset explains the film.
class MotionFit {
 public:
  MotionFit(std::span<const Travel> travels, std::vector<Interval> intervals)
      : travels_(travels), intervals_(std::move(intervals)), steady_mm_s_(steady_speed(travels)) {}

  // G of film_clock.h.
  double explained(double offset_s) const {
    const Sums sums = sums_at(offset_s);
    if (sums.count < 2.0) return 0.0;
    const double s_am = sums.am - sums.a * sums.m / sums.count;
    const double s_mm = sums.mm - sums.m * sums.m / sums.count;
    const double s_aa = sums.aa - sums.a * sums.a / sums.count + sums.outside_aa;
    if (s_am <= 0.0 || s_mm <= 1e-9 || s_aa <= 0.0) return 0.0;
    return s_am * s_am / (s_mm * s_aa);
  }

  // Residuals of the fit, in order of time.
  std::vector<double> residuals(double offset_s) const {
    const Sums sums = sums_at(offset_s);
    const double s_am = sums.am - sums.a * sums.m / sums.count;
    const double slope = s_am / (sums.mm - sums.m * sums.m / sums.count);
    const double at_rest = (sums.a - slope * sums.m) / sums.count;
    std::vector<double> left;
    for (const Interval& interval : intervals_) {
      const auto motion = motion_during(interval, offset_s);
      if (motion) left.push_back(interval.activity - at_rest - slope * *motion);
    }
    return left;
  }

 private:
  struct Sums {
    double count = 0.0;  // within the journal
    double a = 0.0;
    double aa = 0.0;
    double m = 0.0;
    double am = 0.0;
    double mm = 0.0;
    double outside_aa = 0.0;  // beyond it
  };

  std::optional<double> motion_during(const Interval& interval, double offset_s) const {
    const double from_s = interval.from_s + offset_s;
    const double to_s = interval.to_s + offset_s;
    for (const Travel& travel : travels_) {
      if (from_s < travel.begin_s() || to_s > travel.end_s()) continue;
      return std::min(travel.speed_mm_s(from_s, to_s) / steady_mm_s_, 1.0);
    }
    return std::nullopt;
  }

  Sums sums_at(double offset_s) const {
    Sums sums;
    for (const Interval& interval : intervals_) {
      const auto motion = motion_during(interval, offset_s);
      if (!motion) {
        if (interval.activity > kMoving) sums.outside_aa += interval.activity * interval.activity;
        continue;
      }
      sums.count += 1.0;
      sums.a += interval.activity;
      sums.aa += interval.activity * interval.activity;
      sums.m += *motion;
      sums.am += interval.activity * *motion;
      sums.mm += *motion * *motion;
    }
    return sums;
  }

  std::span<const Travel> travels_;
  std::vector<Interval> intervals_;
  double steady_mm_s_;
};

struct Peak {
  double offset_s = 0.0;
  double explained = 0.0;
};

// All local maxima over the offsets at which film and journal overlap, best first.
std::vector<Peak> coarse_peaks(const MotionFit& fit, std::span<const Travel> travels,
                               double film_end_s) {
  std::vector<Peak> peaks;
  for (const Travel& travel : travels) {
    std::vector<Peak> samples;
    for (double offset_s = travel.begin_s() - film_end_s; offset_s <= travel.end_s();
         offset_s += kCoarseStep_s) {
      throw_if_interrupted();
      samples.push_back({offset_s, fit.explained(offset_s)});
    }
    for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
      const double here = samples[i].explained;
      if (here > 0.0 && here >= samples[i - 1].explained && here > samples[i + 1].explained) {
        peaks.push_back(samples[i]);
      }
    }
  }
  std::sort(peaks.begin(), peaks.end(),
            [](const Peak& a, const Peak& b) { return a.explained > b.explained; });
  return peaks;
}

// The best offset around a peak: in steps, then by a parabola through the three best samples.
Peak refined(const MotionFit& fit, double around_s, double step_s) {
  const int steps = static_cast<int>(std::ceil(2.0 * kCoarseStep_s / step_s));
  Peak best{around_s, fit.explained(around_s)};
  for (int i = -steps; i <= steps; ++i) {
    const double offset_s = around_s + i * step_s;
    const double explained = fit.explained(offset_s);
    if (explained > best.explained) best = {offset_s, explained};
  }
  const double before = fit.explained(best.offset_s - step_s);
  const double after = fit.explained(best.offset_s + step_s);
  const double bend = before - 2.0 * best.explained + after;
  if (bend < 0.0) best.offset_s += std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) * step_s;
  return best;
}

// Effective sample size of n residuals with first-order autocorrelation r: n (1 - r) / (1 + r).
// (M. S. Bartlett, "Some Aspects of the Time-Correlation Problem", 1935.)
double effective_count(const std::vector<double>& residuals) {
  double squares = 0.0;
  double products = 0.0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    squares += residuals[i] * residuals[i];
    if (i > 0) products += residuals[i] * residuals[i - 1];
  }
  const double r = squares > 0.0 ? std::clamp(products / squares, 0.0, 0.99) : 0.0;
  return std::max(1.0, static_cast<double>(residuals.size()) * (1.0 - r) / (1.0 + r));
}

// Half the width of the interval in which the squared residuals, proportional to 1 - G, stay below
// 1 + chi^2 / n times their minimum: the profile likelihood of normal residuals.
double uncertainty_of(const MotionFit& fit, const Peak& best, double step_s) {
  const double count = effective_count(fit.residuals(best.offset_s));
  const double allowed = 1.0 - (1.0 - best.explained) * (1.0 + kChi2_95 / count);
  double low_s = best.offset_s - step_s;
  double high_s = best.offset_s + step_s;
  while (low_s > best.offset_s - kPeakWidth_s && fit.explained(low_s) > allowed) low_s -= step_s;
  while (high_s < best.offset_s + kPeakWidth_s && fit.explained(high_s) > allowed) {
    high_s += step_s;
  }
  return 0.5 * (high_s - low_s);
}

double frame_interval(const std::vector<Interval>& intervals) {
  std::vector<double> lengths;
  lengths.reserve(intervals.size());
  for (const Interval& interval : intervals) lengths.push_back(interval.to_s - interval.from_s);
  return median(lengths);
}

}  // namespace

FilmClock match_film_clock(const FilmTrack& track, std::span<const Travel> travels,
                           const std::string& film) {
  const std::vector<Interval> intervals = intervals_of(track, film);
  const MotionFit coarse_fit(travels, coarse(intervals));
  const std::vector<Peak> peaks = coarse_peaks(coarse_fit, travels, track.frames.back().time_s);
  if (peaks.empty() || peaks.front().explained < kLeastExplained) {
    throw Error(fmt::format(
        "{}: the motion does not fit the journal at any offset (at best {:.0f} % of it); is it the "
        "film of another session? Cut parts in which the camera is carried",
        film, peaks.empty() ? 0.0 : 100.0 * peaks.front().explained));
  }
  const auto rival = std::find_if(peaks.begin() + 1, peaks.end(), [&](const Peak& peak) {
    return std::abs(peak.offset_s - peaks.front().offset_s) > kPeakWidth_s;
  });
  FilmClock clock;
  if (rival != peaks.end()) clock.next_best = rival->explained;
  if (clock.next_best > kClearlyWorse * peaks.front().explained) {
    throw Error(fmt::format(
        "{}: the motion fits the journal at two times, {:.1f} s apart ({:.0f} and {:.0f} % of it); "
        "name the filmed line with --line",
        film, std::abs(rival->offset_s - peaks.front().offset_s), 100.0 * peaks.front().explained,
        100.0 * rival->explained));
  }
  const double step_s = 0.1 * frame_interval(intervals);
  const MotionFit fit(travels, intervals);
  const Peak best = refined(fit, peaks.front().offset_s, step_s);
  clock.offset_s = best.offset_s;
  clock.explained = best.explained;
  clock.uncertainty_s = uncertainty_of(fit, best, step_s);
  return clock;
}

}  // namespace raywalk::capture
