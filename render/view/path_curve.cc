#include "render/view/path_curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"

namespace raywalk::render {
namespace {

constexpr int kStepsPerPiece = 256;
constexpr double kUsualSpeed_m_per_s = 0.4;
// At the usual speed 40 degrees per second.
constexpr double kMetresPerDegree = 0.01;
constexpr double kMostFrames = 1e6;
constexpr std::size_t kFirstAngle = 3;  // of the values of a knot

// In [-180, 180).
double shortest_turn(double from_deg, double to_deg) {
  const double turn = to_deg - from_deg;
  return turn - 360.0 * std::floor((turn + 180.0) / 360.0);
}

double length_between(const std::vector<double>& from, const std::vector<double>& to) {
  const double way_m = std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
  const double turn_deg = std::hypot(to[3] - from[3], to[4] - from[4], to[5] - from[5]);
  return std::max(way_m, turn_deg * kMetresPerDegree);
}

// The slope at the middle one of three knots of a Catmull-Rom curve with any parameters: that of
// the parabola through them.
double slope(double a, double b, double c, double ab, double bc) {
  return (b - a) / ab - (c - a) / (ab + bc) + (c - b) / bc;
}

// The cubic between two values with given slopes, `part` of 0 to 1 of the way.
double hermite(double from, double to, double slope_from, double slope_to, double span,
               double part) {
  const double start = slope_from * span, end = slope_to * span;
  const double square = 3.0 * (to - from) - 2.0 * start - end;
  const double cubic = 2.0 * (from - to) + start + end;
  return from + part * (start + part * (square + part * cubic));
}

// Rises from 0 to 1 with speed and acceleration 0 at both ends (K. Perlin, "Improving noise",
// 2002).
double smootherstep(double t) { return t * t * t * (t * (6.0 * t - 15.0) + 10.0); }

bool is_positive(std::optional<double> number) {
  return !number || (*number > 0.0 && std::isfinite(*number));
}

}  // namespace

void require_movement(const SmoothMovement& movement) {
  if (!is_positive(movement.seconds)) {
    throw UsageError(fmt::format("--seconds is {:g}; it must be above 0", *movement.seconds));
  }
  if (!is_positive(movement.speed_m_per_s)) {
    throw UsageError(
        fmt::format("--speed-m-per-s is {:g}; it must be above 0", *movement.speed_m_per_s));
  }
  if (movement.seconds && movement.speed_m_per_s) {
    throw UsageError("--seconds and --speed-m-per-s contradict each other; give one of them");
  }
  if (movement.speed_m_per_s && movement.pace == Pace::kRecorded) {
    throw UsageError("--smooth recorded goes by the table's times; leave out --speed-m-per-s");
  }
}

PathCurve::PathCurve(std::span<const PathView> views, Pace pace)
    : views_(views.begin(), views.end()) {
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const PathView& view = views_[i];
    const PlanPoint place = view.viewpoint.plan;
    std::vector<double> values{place.x_m,      view.viewpoint.height_m.value_or(0.0),
                               place.z_m,      view.yaw_deg,
                               view.pitch_deg, view.roll_deg};
    if (knots_.empty()) {
      knots_.push_back({i, pace == Pace::kRecorded ? view.time_s : 0.0, values});
      continue;
    }
    const Knot& last = knots_.back();
    for (std::size_t k = kFirstAngle; k < values.size(); ++k) {
      values[k] = last.values[k] + shortest_turn(last.values[k], values[k]);
    }
    if (pace == Pace::kRecorded) {
      if (!(view.time_s > last.parameter)) {
        throw Error(
            fmt::format("view '{}': its time of {:g} s is not after that of the view "
                        "before, {:g} s; give growing times, or another --smooth",
                        view.name, view.time_s, last.parameter));
      }
      knots_.push_back({i, view.time_s, values});
    } else if (const double length = length_between(last.values, values); length > 0.0) {
      knots_.push_back({i, last.parameter + std::sqrt(length), values});
    }
  }
  const std::size_t steps = kStepsPerPiece * (knots_.empty() ? 0 : knots_.size() - 1);
  std::vector<double> before = values_at(0.0);
  for (std::size_t step = 1; step <= steps; ++step) {
    std::vector<double> here = values_at(static_cast<double>(step));
    const std::size_t piece = (step - 1) / kStepsPerPiece;
    lengths_.push_back(lengths_.back() + (pace == Pace::kRecorded ? (knots_[piece + 1].parameter -
                                                                     knots_[piece].parameter) /
                                                                        kStepsPerPiece
                                                                  : length_between(before, here)));
    before = std::move(here);
  }
}

std::vector<double> PathCurve::values_at(double step) const {
  const std::size_t last = knots_.size() - 1;
  if (last == 0) return knots_.front().values;
  const auto piece = std::min(static_cast<std::size_t>(step / kStepsPerPiece), last - 1);
  const double part = step / kStepsPerPiece - static_cast<double>(piece);
  const Knot& from = knots_[piece];
  const Knot& to = knots_[piece + 1];
  const Knot& before = knots_[piece == 0 ? 0 : piece - 1];
  const Knot& after = knots_[std::min(piece + 2, last)];
  const double span = to.parameter - from.parameter;
  // At an end there is no knot beyond; the slope there is the one that makes the piece a parabola,
  // or with two knots a straight line.
  const bool first = piece == 0, final = piece + 1 == last;
  std::vector<double> values;
  for (std::size_t k = 0; k < from.values.size(); ++k) {
    const double a = from.values[k], b = to.values[k], chord = (b - a) / span;
    double start =
        first ? chord : slope(before.values[k], a, b, from.parameter - before.parameter, span);
    double end = final ? chord : slope(a, b, after.values[k], span, after.parameter - to.parameter);
    if (first && !final) start = 2.0 * chord - end;
    if (final && !first) end = 2.0 * chord - start;
    values.push_back(hermite(a, b, start, end, span, part));
  }
  return values;
}

double PathCurve::step_at(double gone) const {
  if (!(gone > 0.0)) return 0.0;
  if (gone >= length()) return static_cast<double>(lengths_.size() - 1);
  const auto above = std::upper_bound(lengths_.begin(), lengths_.end(), gone);
  const auto step = static_cast<std::size_t>(above - lengths_.begin()) - 1;
  return static_cast<double>(step) +
         (gone - lengths_[step]) / (lengths_[step + 1] - lengths_[step]);
}

PathView PathCurve::at(double gone) const {
  const double step = step_at(gone);
  // Straight between steps, where the speed is even; along the curve it would not quite be.
  std::vector<double> values = values_at(std::floor(step));
  const std::vector<double> next = values_at(std::ceil(step));
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] = std::lerp(values[k], next[k], step - std::floor(step));
  }
  const std::size_t last = knots_.size() - 1;
  const auto piece = std::min(static_cast<std::size_t>(step / kStepsPerPiece), last);
  PathView view = views_[knots_[piece].view];
  view.viewpoint.plan = {values[0], values[2]};
  if (view.viewpoint.height_m) view.viewpoint.height_m = values[1];
  view.yaw_deg = values[3];
  view.pitch_deg = values[4];
  view.roll_deg = values[5];
  if (piece < last) {
    view.place =
        fmt::format("between '{}' and '{}'", view.name, views_[knots_[piece + 1].view].name);
  }
  return view;
}

std::vector<PathView> frames_of(std::span<const PathView> views, const SmoothMovement& movement,
                                const std::filesystem::path& table) {
  require_movement(movement);
  try {
    const PathCurve curve(views, movement.pace);
    const double speed = movement.pace == Pace::kRecorded
                             ? 1.0
                             : movement.speed_m_per_s.value_or(kUsualSpeed_m_per_s);
    const double seconds = movement.seconds.value_or(curve.length() / speed);
    if (!(seconds > 0.0)) {
      throw Error("all views are the same; give --seconds for a video that stands still");
    }
    if (seconds * movement.fps > kMostFrames) {
      throw Error(
          fmt::format("{:.4g} s at {:g} frames per second are more than {:g} frames; give "
                      "--seconds",
                      seconds, movement.fps, kMostFrames));
    }
    const auto count = std::max<std::int64_t>(2, std::llround(seconds * movement.fps));
    std::vector<PathView> frames;
    for (std::int64_t i = 0; i < count; ++i) {
      const double t = static_cast<double>(i) / static_cast<double>(count - 1);
      const double share = movement.pace == Pace::kEased ? smootherstep(t) : t;
      PathView frame = curve.at(share * curve.length());
      frame.name = fmt::format("{}-{:05}", table.stem().string(), i + 1);
      frames.push_back(std::move(frame));
    }
    return frames;
  } catch (const UsageError&) {
    throw;
  } catch (const Error& e) {
    throw Error(table.string() + ": " + e.what());
  }
}

}  // namespace raywalk::render
