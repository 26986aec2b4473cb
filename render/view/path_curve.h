// A smooth movement through a few places.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/view/path_table.h"

namespace raywalk::render {

// How time goes by on the way.
enum class Pace {
  kConstant,  // the same speed all the way
  kEased,     // slow at the start and the end
  kRecorded   // as the table's times say
};

struct SmoothMovement {
  Pace pace = Pace::kConstant;
  double fps = 30.0;                      // frames per second
  std::optional<double> seconds{};        // of the whole movement
  std::optional<double> speed_m_per_s{};  // on average; else 0.4
};

// Throws UsageError where a number is out of range or two contradict each other.
void require_movement(const SmoothMovement& movement);

// The curve through the poses of a table: centripetal Catmull-Rom curves (C. Yuksel, S. Schaefer,
// J. Keyser, "Parameterization and applications of Catmull-Rom curves", 2011), which make no loops
// where poses are unevenly spaced; for Pace::kRecorded the parameter is the time. Angles are
// counted on from pose to pose by the shortest turn.
class PathCurve {
 public:
  // Poses that are the same as the one before are left out. Throws Error where times do not grow.
  PathCurve(std::span<const PathView> views, Pace pace);

  // What the movement takes at a speed of 1: metres per metre per second, or as long as turning by
  // 100 degrees for each of them, so that one who turns on the spot is not rushed; with recorded
  // times seconds. 0 for a single pose.
  double length() const { return lengths_.back(); }
  // The pose where this much of length() has gone by; name and time are those of the pose before.
  PathView at(double gone) const;

 private:
  struct Knot {
    std::size_t view = 0;
    double parameter = 0.0;
    std::vector<double> values{};  // x_m, y_m (0 without heights), z_m and the angles in degrees
  };
  std::vector<double> values_at(double step) const;
  double step_at(double gone) const;

  std::vector<PathView> views_;
  std::vector<Knot> knots_;
  std::vector<double> lengths_{0.0};  // what has gone by at each step of the curve
};

// The frames of a movement through `views`, named `name`-00001 and so on. Throws Error naming
// `table` where there is nothing to move through or there would be more than a million frames.
std::vector<PathView> frames_of(std::span<const PathView> views, const SmoothMovement& movement,
                                const std::filesystem::path& table);

}  // namespace raywalk::render
