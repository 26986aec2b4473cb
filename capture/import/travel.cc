#include "capture/import/travel.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace raywalk::capture {
namespace {

constexpr double kLongestGap_s = 1.0;

}  // namespace

Travel::Travel(std::string line, std::vector<double> times_s, std::vector<double> positions_mm)
    : line_(std::move(line)),
      times_s_(std::move(times_s)),
      positions_mm_(std::move(positions_mm)) {}

std::optional<double> Travel::position_mm(double time_s) const {
  if (time_s < begin_s() || time_s > end_s()) return std::nullopt;
  const auto after = std::upper_bound(times_s_.begin(), times_s_.end(), time_s);
  if (after == times_s_.begin()) return positions_mm_.front();
  if (after == times_s_.end()) return positions_mm_.back();
  const auto i = static_cast<std::size_t>(after - times_s_.begin());
  const double share = (time_s - times_s_[i - 1]) / (times_s_[i] - times_s_[i - 1]);
  return std::lerp(positions_mm_[i - 1], positions_mm_[i], share);
}

double Travel::speed_mm_s(double from_s, double to_s) const {
  const double from_mm = position_mm(std::clamp(from_s, begin_s(), end_s())).value();
  const double to_mm = position_mm(std::clamp(to_s, begin_s(), end_s())).value();
  return std::abs(to_mm - from_mm) / (to_s - from_s);
}

std::vector<Travel> travels_of(const std::string& line, std::span<const JournalSample> journal,
                               WallTime start) {
  std::vector<Travel> travels;
  std::vector<double> times_s;
  std::vector<double> positions_mm;
  const auto end_pass = [&] {
    if (times_s.size() >= 2) travels.emplace_back(line, times_s, positions_mm);
    times_s.clear();
    positions_mm.clear();
  };
  for (const JournalSample& sample : journal) {
    const double time_s = std::chrono::duration<double>(sample.time - start).count();
    if (!times_s.empty() && time_s <= times_s.back()) continue;
    if (!times_s.empty() && time_s > times_s.back() + kLongestGap_s) end_pass();
    times_s.push_back(time_s);
    positions_mm.push_back(sample.position_mm);
  }
  end_pass();
  return travels;
}

}  // namespace raywalk::capture
