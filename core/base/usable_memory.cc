#include "core/base/usable_memory.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

// Version 2 writes "max" where there is no limit.
std::uint64_t limit_in(const fs::path& file) {
  std::ifstream text(file);
  std::uint64_t bytes = 0;
  return text >> bytes ? bytes : kNoLimit;
}

// A group is limited by those around it too. Where only a part of the tree is mounted, as in a
// container, the group itself is at the mount.
std::uint64_t limit_of(fs::path group, const fs::path& mount, const std::string& name) {
  std::uint64_t least = limit_in(mount / name);
  for (group = group.relative_path(); !group.empty(); group = group.parent_path()) {
    least = std::min(least, limit_in(mount / group / name));
  }
  return least;
}

bool contains_memory(const std::string& controllers) {
  return ("," + controllers + ",").find(",memory,") != std::string::npos;
}

}  // namespace

std::uint64_t control_group_limit_bytes(const fs::path& membership, const fs::path& mount) {
  std::uint64_t least = kNoLimit;
  std::ifstream lines(membership);
  // Number, controllers and group: "4:memory:/jobs/7", in version 2 "0::/jobs/7".
  for (std::string line; std::getline(lines, line);) {
    const auto first = line.find(':');
    const auto second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const fs::path group = line.substr(second + 1);
    if (controllers.empty()) {
      least = std::min(least, limit_of(group, mount, "memory.max"));
    } else if (contains_memory(controllers)) {
      least = std::min(least, limit_of(group, mount / "memory", "memory.limit_in_bytes"));
    }
  }
  return least;
}

std::uint64_t usable_memory_bytes() {
  const std::uint64_t physical = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                                 static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  return std::min(physical, control_group_limit_bytes("/proc/self/cgroup", "/sys/fs/cgroup"));
}

}  // namespace raywalk
