#include "core/base/processor_use.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>

namespace raywalk {
namespace {

constexpr double kTick_s = 0.01;  // USER_HZ is 100 on every architecture of Debian

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

double own_processor_s() {
  rusage use = {};
  getrusage(RUSAGE_SELF, &use);
  return seconds_of(use.ru_utime) + seconds_of(use.ru_stime);
}

}  // namespace

ProcessorUse processor_use() {
  std::ifstream file("/proc/stat");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  return processor_use_from(text, own_processor_s());
}

ProcessorUse processor_use_from(const std::string& proc_stat, double own_s) {
  // user nice system idle iowait irq softirq steal; guests are counted in user and nice.
  enum : std::size_t { kIdle = 3, kWaiting = 4, kCount = 8 };
  std::istringstream line(proc_stat);
  std::string name;
  line >> name;
  std::array<double, kCount> ticks{};
  for (double& each : ticks) line >> each;
  if (name != "cpu" || line.fail()) return {};
  double all = 0.0;
  for (const double each : ticks) all += each;
  return {.all_s = kTick_s * all,
          .busy_s = kTick_s * (all - ticks[kIdle] - ticks[kWaiting]),
          .own_s = own_s};
}

double share_of_others(const ProcessorUse& before, const ProcessorUse& after) {
  const double all_s = after.all_s - before.all_s;
  if (!(all_s > 0.0)) return 0.0;
  const double hidden_s = 2.0 * kTick_s * std::max(1U, std::thread::hardware_concurrency());
  const double others_s = (after.busy_s - before.busy_s) - (after.own_s - before.own_s);
  return std::clamp((others_s - hidden_s) / all_s, 0.0, 1.0);
}

}  // namespace raywalk
