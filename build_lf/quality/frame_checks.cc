#include "build_lf/quality/frame_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "build_lf/depth/matching_views.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/room/hdf5_file.h"

namespace raywalk::build_lf {
namespace {

// Median and outlier threshold: 3.5 robust standard deviations (Iglewicz and Hoaglin 1993).
struct Usual {
  double median = 0.0;
  double margin = 0.0;
};

Usual usual_of(const std::vector<double>& values) {
  constexpr double kDeviations = 3.5;
  if (values.empty()) return {};
  const double middle = median(values);
  std::vector<double> deviations;
  deviations.reserve(values.size());
  for (const double value : values) deviations.push_back(std::fabs(value - middle));
  return {middle, kDeviations * robust_sigma(std::move(deviations))};
}

// The checks of one line.
class LineChecks {
 public:
  LineChecks(const Room& room, int line, std::span<const StationLink> links, FrameChecks* checks)
      : line_index_(line),
        line_(room.grid().lines[static_cast<size_t>(line)]),
        volume_(room.volume(line)),
        file_(line_volume_path(room.directory(), line_.id)),
        checks_(checks) {
    for (const StationLink& link : links) {
      if (link.compared.comparable && link.pair.from.line == line) {
        links_[{link.pair.from.station, link.pair.to.station}] = link;
      }
    }
  }

  void find_same_files() {
    const Hdf5File file = Hdf5File::open(file_);
    if (!file.has_dataset("sha256")) return;
    const std::vector<std::string> checksums = file.read_strings("sha256");
    const auto stored = static_cast<size_t>(volume_.stations_in_file());
    if (checksums.size() != stored) {
      throw Error(file_.string() + ": holds " + std::to_string(checksums.size()) +
                  " checksums for " + std::to_string(stored) + " stations; pack the room again");
    }
    std::map<std::string, int> first;
    for (int i = 0; i < stations(); ++i) {
      const auto [earlier, is_new] =
          first.emplace(checksums[static_cast<size_t>(volume_.index_in_file(i))], i);
      if (is_new) continue;
      report(i, FrameFault::kSameFile, earlier->second, distance_m(earlier->second, i));
      copies_.push_back(i);
    }
  }

  // The change grows at most in proportion to the distance between two stations, as twice the
  // distance at most doubles every displacement. So a moved pair changes at least by the typical
  // change scaled by its relative distance; less than half of that is suspicious regardless of the
  // line's spread.
  void find_unmoved() {
    std::vector<std::optional<double>> log_share(line_.stations.size());
    std::vector<double> known;
    for (int i = 1; i < stations(); ++i) {
      const auto share = relative_change(i);
      if (!share) continue;
      log_share[static_cast<size_t>(i)] = std::log(std::max(*share, 1e-6));
      known.push_back(*log_share[static_cast<size_t>(i)]);
    }
    constexpr size_t kFewest = 4;  // minimum number of pairs for statistics
    if (known.size() < kFewest) return;
    const double limit = std::min(std::log(0.5), -usual_of(known).margin);
    for (int i = 1; i < stations(); ++i) {
      const auto& value = log_share[static_cast<size_t>(i)];
      if (!value || *value >= limit || holds(copies_, i)) continue;
      report(i, FrameFault::kNotMoved, i - 1, std::exp(*value));
    }
  }

  // The two neighbours of a frame are farther apart than each is from the frame, so usually they
  // differ more. If the foreign content of a frame outweighs the change between its neighbours
  // (adding squares), it differs from both by more than sqrt 2 times that change.
  void find_unlike_neighbours() {
    std::vector<double> log_excess;
    std::vector<Excess> excesses;
    for (int i = 0; i < stations(); ++i) {
      const auto excess = excess_of(i);
      if (!excess) continue;
      excesses.push_back(*excess);
      log_excess.push_back(std::log(excess->times));
    }
    const Usual usual = usual_of(log_excess);
    const double limit = std::exp(std::max(0.5 * std::log(2.0), usual.median + usual.margin));
    for (const Excess& excess : excesses) {
      if (excess.times <= limit) continue;
      report(excess.station, FrameFault::kUnlikeNeighbours, excess.neighbour, excess.times);
      unlike_.push_back(excess.station);
    }
  }

  // The exposure of an outlier frame cannot be measured, so those are skipped.
  void find_exposure_steps() {
    std::map<int, double> log_step;  // to a station
    std::vector<double> sizes;
    for (int i = 1; i < stations(); ++i) {
      const StationLink* pair = link(i - 1, i);
      if (pair == nullptr || holds(unlike_, i) || holds(unlike_, i - 1)) continue;
      log_step[i] = pair->log_exposure_step();
      sizes.push_back(std::fabs(log_step[i]));
    }
    constexpr double kVisible = 0.02;  // Weber fraction: smaller steps are invisible
    const Usual usual = usual_of(sizes);
    const double limit = std::max(kVisible, usual.median + usual.margin);
    double& largest = checks_->largest_exposure_step;
    for (const auto& [station, step] : log_step) {
      if (std::fabs(step) > std::fabs(std::log(largest))) largest = std::exp(step);
      if (std::fabs(step) <= limit) continue;
      report(station, FrameFault::kExposureStep, station - 1, std::exp(step));
    }
  }

 private:
  // Ratio of a frame's difference from its neighbours to their difference from each other.
  struct Excess {
    int station = 0;
    int neighbour = 0;
    double times = 0.0;
  };

  int stations() const { return static_cast<int>(line_.stations.size()); }

  double distance_m(int a, int b) const {
    return std::fabs(line_.stations[static_cast<size_t>(b)].along_m -
                     line_.stations[static_cast<size_t>(a)].along_m);
  }

  const StationLink* link(int a, int b) const {
    const auto found = links_.find({std::min(a, b), std::max(a, b)});
    return found == links_.end() ? nullptr : &found->second;
  }

  static bool holds(const std::vector<int>& stations, int station) {
    return std::find(stations.begin(), stations.end(), station) != stations.end();
  }

  // The change from station i - 1 to i relative to the median of the pairs around it, within half
  // of the line; robust as long as fewer than half of these are faulty.
  std::optional<double> relative_change(int i) const {
    const StationLink* pair = link(i - 1, i);
    if (pair == nullptr) return std::nullopt;
    const int around = std::max(2, stations() / 4);
    std::vector<double> changes;
    std::vector<double> distances_m;
    for (int j = std::max(1, i - around); j <= std::min(stations() - 1, i + around); ++j) {
      const StationLink* other = link(j - 1, j);
      if (other == nullptr) continue;
      changes.push_back(other->compared.change);
      distances_m.push_back(distance_m(j - 1, j));
    }
    const double expected = median(std::move(changes)) *
                            std::min(1.0, distance_m(i - 1, i) / median(std::move(distances_m)));
    if (expected <= 0.0) return std::nullopt;
    return pair->compared.change / expected;
  }

  std::optional<Excess> excess_of(int i) const {
    if (stations() < 3) return std::nullopt;
    const int before = i == 0 ? 1 : i == stations() - 1 ? i - 2 : i - 1;
    const int after = before == i - 1 ? i + 1 : before + 1;
    const StationLink* to_before = link(before, i);
    const StationLink* to_after = link(after, i);
    const StationLink* across = link(before, after);
    if (to_before == nullptr || to_after == nullptr || across == nullptr) return std::nullopt;
    const bool before_is_nearer =
        to_before->compared.unexplained_change < to_after->compared.unexplained_change;
    const double difference =
        std::min(to_before->compared.unexplained_change, to_after->compared.unexplained_change);
    if (difference <= 0.0) return std::nullopt;
    // Levels are integers, so identical views still differ by rounding errors.
    constexpr double kRounding = 0.3;
    return Excess{i, before_is_nearer ? before : after,
                  difference / std::max(across->compared.unexplained_change, kRounding)};
  }

  void report(int station, FrameFault fault, int other, double measure) {
    checks_->frames.push_back({{line_index_, station},
                               line_.stations[static_cast<size_t>(station)].file,
                               fault,
                               {line_index_, other},
                               measure});
  }

  int line_index_;
  const Line& line_;
  const LineVolume& volume_;
  std::filesystem::path file_;
  std::map<std::pair<int, int>, StationLink> links_;  // by station
  std::vector<int> copies_;
  std::vector<int> unlike_;
  FrameChecks* checks_;
};

void check_baselines(int index, const Line& line, double reach_m,
                     std::vector<LineFinding>* findings) {
  const double shortest_m = reach_m / kViewsPerSide;
  const double length_m = line.last_m() - line.first_m();
  if (length_m < shortest_m) {
    findings->push_back({index, LineFault::kTooShort, length_m, shortest_m});
  }
  double widest_m = 0.0;
  for (size_t i = 1; i < line.stations.size(); ++i) {
    widest_m = std::max(widest_m, line.stations[i].along_m - line.stations[i - 1].along_m);
  }
  if (widest_m > reach_m) findings->push_back({index, LineFault::kTooSparse, widest_m, reach_m});
}

}  // namespace

std::string_view name_of(FrameFault fault) {
  switch (fault) {
    case FrameFault::kSameFile:
      return "same_file";
    case FrameFault::kNotMoved:
      return "not_moved";
    case FrameFault::kUnlikeNeighbours:
      return "unlike_neighbours";
    case FrameFault::kExposureStep:
      return "exposure_step";
  }
  return {};
}

FrameChecks check_frames(const Room& room, std::span<const StationLink> links, double reach_m) {
  FrameChecks checks;
  const auto& lines = room.grid().lines;
  for (int i = 0; i < static_cast<int>(lines.size()); ++i) {
    LineChecks line(room, i, links, &checks);
    line.find_same_files();
    line.find_unmoved();
    line.find_unlike_neighbours();
    line.find_exposure_steps();
    check_baselines(i, lines[static_cast<size_t>(i)], reach_m, &checks.lines);
  }
  return checks;
}

std::vector<std::string> warnings_of(const Room& room, const FrameChecks& checks) {
  std::vector<std::string> warnings;
  for (const FrameFinding& finding : checks.frames) {
    const std::string& other = room.grid().station(finding.other).file;
    switch (finding.fault) {
      case FrameFault::kSameFile:
        warnings.push_back(fmt::format("{} is a copy of {}, {:.3f} m away; it is not used",
                                       finding.file, other, finding.measure));
        break;
      case FrameFault::kNotMoved:
        warnings.push_back(fmt::format(
            "{} shows the same as {}: the camera seems not to have moved; it is not used",
            finding.file, other));
        break;
      case FrameFault::kUnlikeNeighbours:
        warnings.push_back(fmt::format(
            "{} differs from {} {:.1f} times more than its neighbours do from one another: "
            "something moved, or the frame is misplaced; it is not used",
            finding.file, other, finding.measure));
        break;
      case FrameFault::kExposureStep:
        warnings.push_back(fmt::format(
            "the exposure of {} is {:.2f} times that of {}; its colours are scaled for matching",
            finding.file, finding.measure, other));
        break;
    }
  }
  for (const LineFinding& finding : checks.lines) {
    const std::string& line = room.grid().lines[static_cast<size_t>(finding.line)].id;
    warnings.push_back(
        finding.fault == LineFault::kTooShort
            ? fmt::format(
                  "line {} is {:.3f} m long; estimating distances from it alone needs {:.3f} m",
                  line, finding.measure_m, finding.needed_m)
            : fmt::format("line {} has a gap of {:.3f} m; stations further apart than {:.3f} m "
                          "cannot be compared",
                          line, finding.measure_m, finding.needed_m));
  }
  return warnings;
}

}  // namespace raywalk::build_lf
