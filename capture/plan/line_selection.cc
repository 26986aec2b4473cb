#include "capture/plan/line_selection.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <optional>

#include "core/base/error.h"
#include "core/files/fingerprint.h"

namespace raywalk::capture {
namespace {

std::optional<std::size_t> index_of(const CapturePlan& plan, const std::string& id) {
  const auto line = std::ranges::find(plan.lines, id, &CaptureLine::id);
  if (line == plan.lines.end()) return std::nullopt;
  return static_cast<std::size_t>(line - plan.lines.begin());
}

[[noreturn]] void refuse_word(const CapturePlan& plan, const std::string& word) {
  throw UsageError(fmt::format(
      "--lines: {} is no line of the plan, which has {} to {}; a range is FIRST-LAST, as in {}-{}",
      excerpt(word), plan.lines.front().id, plan.lines.back().id, plan.lines.front().id,
      plan.lines.back().id));
}

void mark(const CapturePlan& plan, const std::string& word, std::vector<bool>* taken) {
  const std::size_t dash = word.find('-');
  const std::optional<std::size_t> first = index_of(plan, word.substr(0, dash));
  const std::optional<std::size_t> last =
      dash == std::string::npos ? first : index_of(plan, word.substr(dash + 1));
  if (!first || !last || *last < *first) refuse_word(plan, word);
  for (std::size_t i = *first; i <= *last; ++i) (*taken)[i] = true;
}

}  // namespace

CapturePlan select_lines(const CapturePlan& plan, const CameraConfig& camera,
                         const std::vector<std::string>& words) {
  std::vector<bool> taken(plan.lines.size(), words.empty());
  for (const std::string& word : words) mark(plan, word, &taken);
  if (std::ranges::find(taken, false) == taken.end()) return plan;
  CapturePlan selected;
  selected.overhang_m = plan.overhang_m;
  selected.part_of = whole_plan_of(plan, camera);
  for (std::size_t i = 0; i < plan.lines.size(); ++i) {
    if (taken[i]) selected.lines.push_back(plan.lines[i]);
  }
  return selected;
}

WholePlan whole_plan_of(const CapturePlan& plan, const CameraConfig& camera) {
  if (plan.part_of) return *plan.part_of;
  WholePlan whole;
  CapturePlan grid = plan;
  for (CaptureLine& line : grid.lines) {
    whole.lines.push_back(line.id);
    for (CaptureStation& station : line.stations) station.rail_mm = 0.0;
  }
  whole.sha256 = sha256_hex(plan_json(grid, camera));
  return whole;
}

}  // namespace raywalk::capture
