// How much memory this process may use.
#pragma once

#include <cstdint>
#include <filesystem>

namespace raywalk {

// The machine's memory in bytes, or less where a control group of this process sets a limit, as
// Slurm, containers and systemd do.
std::uint64_t usable_memory_bytes();

// The smallest limit of the control groups that `membership` names (/proc/self/cgroup), and of
// those around them, in bytes; 2^64 - 1 without any. `mount` is where the groups are mounted
// (/sys/fs/cgroup). Both versions of control groups: cgroups(7), and memory.max and
// memory.limit_in_bytes in the kernel's Documentation/admin-guide. Unreadable files set no limit.
std::uint64_t control_group_limit_bytes(const std::filesystem::path& membership,
                                        const std::filesystem::path& mount);

}  // namespace raywalk
