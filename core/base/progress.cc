#include "core/base/progress.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <utility>

#include "core/base/escaped.h"

namespace raywalk {
namespace {

using std::chrono::steady_clock;

constexpr auto kTerminalInterval = std::chrono::milliseconds(100);
constexpr auto kLogInterval = std::chrono::seconds(1);
constexpr std::int64_t kLogLines = 10;
// The first units of a task also start it, so that what is left is estimated from this time on,
// and from a twentieth of the work on, or a minute.
constexpr double kFirstEstimate_s = 3.0, kSureEstimate_s = 60.0;
constexpr std::int64_t kEstimatedPart = 20;

std::string duration_text(double seconds) {
  // The clamp keeps the cast defined; an estimate above a hundred hours is meaningless anyway.
  const auto whole = static_cast<std::int64_t>(std::clamp(seconds, 0.0, 360000.0));
  if (whole >= 3600) return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
  if (whole >= 60) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} s", whole);
}

// Whether `total` units are known and all of them are done.
bool complete(std::int64_t done, std::int64_t total) { return total > 0 && done >= total; }

}  // namespace

Progress::Progress(std::string what, std::int64_t total, std::string unit, Shown shown)
    : what_(std::move(what)),
      unit_(std::move(unit)),
      total_(total),
      shown_(shown),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_(steady_clock::now()),
      last_print_(start_) {}

Progress::~Progress() {
  const std::lock_guard lock(mutex_);
  if (terminal_ && printed_ >= 0) std::cerr << '\n' << std::flush;
}

void Progress::advance(std::int64_t units) {
  if (!spdlog::should_log(spdlog::level::info)) return;
  const std::lock_guard lock(mutex_);
  const bool was_complete = complete(done_, total_);
  done_ += units;
  if (shown_ == Shown::kIfLong && printed_ < 0 && steady_clock::now() - start_ < kLogInterval) {
    return;
  }
  if (complete(done_, total_)) {
    if (!was_complete) print(true);
    return;
  }
  const auto since_print = steady_clock::now() - last_print_;
  if (terminal_) {
    if (printed_ < 0 || since_print >= kTerminalInterval) print(false);
    return;
  }
  const std::int64_t step = std::max<std::int64_t>(total_ / kLogLines, 1);
  const bool is_due = printed_ < 0 || done_ / step > printed_ / step;
  if (is_due && since_print >= kLogInterval) print(false);
}

void Progress::print(bool final) {
  last_print_ = steady_clock::now();
  printed_ = done_;
  const double elapsed_s = std::chrono::duration<double>(last_print_ - start_).count();
  const double rate = elapsed_s > 0.0 ? static_cast<double>(done_) / elapsed_s : 0.0;
  std::string line = fmt::format("{}: {}", what_, done_);
  if (total_ > 0) {
    const double share = static_cast<double>(done_) / static_cast<double>(total_);
    line += fmt::format(" of {} {} ({} %)", total_, unit_,
                        static_cast<int>(100.0 * std::clamp(share, 0.0, 1.0)));
  } else {
    line += " " + unit_;
  }
  if (rate > 0.0) line += fmt::format(", {:.3g} {}/s", rate, unit_);
  if (final) {
    line += ", took " + duration_text(elapsed_s);
  } else if (total_ > 0 && rate > 0.0 && elapsed_s >= kFirstEstimate_s &&
             (done_ * kEstimatedPart >= total_ || elapsed_s >= kSureEstimate_s)) {
    line += ", " + duration_text(static_cast<double>(total_ - done_) / rate) + " left";
  }
  // "\r" returns to the start of the live line; ESC [ K (ECMA-48, EL) clears what a longer one
  // left.
  if (terminal_) {
    std::cerr << "\r" << escaped(line) << "\x1b[K" << std::flush;
  } else {
    std::cerr << escaped(line) << '\n' << std::flush;
  }
}

}  // namespace raywalk
