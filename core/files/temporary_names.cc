#include "core/files/temporary_names.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <mutex>
#include <regex>
#include <set>
#include <span>
#include <string>
#include <system_error>

#include "core/files/atomic_output.h"
#include "core/files/sha256.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

// Linux limits a name to 255 bytes; a temporary name adds far less than 100 to the stem.
constexpr std::size_t kMaxStemBytes = 100;
constexpr auto kForeignAge = std::chrono::hours(24);

// Process ids mean something only until the system is restarted, and only within one container (PID
// namespace): this tells them apart.
const std::string& system_id() {
  static const std::string id = [] {
    std::error_code error;
    const fs::path boot = "/proc/sys/kernel/random/boot_id";
    const std::string boot_id = fs::exists(boot, error) ? read_file(boot) : "";
    const std::string text = boot_id + fs::read_symlink("/proc/self/ns/pid", error).string();
    return sha256_hex(text).substr(0, 8);
  }();
  return id;
}

bool is_running(pid_t process) { return kill(process, 0) == 0 || errno == EPERM; }

// Whether a temporary was left by a process that does not run any more. Of this process's id, it is
// of an earlier process: the directory is looked through before this one makes any in it.
bool is_abandoned(const std::string& system, pid_t process, const fs::path& path) {
  if (system == system_id()) return process == getpid() || !is_running(process);
  std::error_code error;
  const fs::file_time_type changed = fs::last_write_time(path, error);
  return !error && fs::file_time_type::clock::now() - changed > kForeignAge;
}

// The first time that this process writes to the directory.
void clean_once(const fs::path& directory) {
  static std::mutex mutex;
  static std::set<fs::path> cleaned;
  std::error_code error;
  const fs::path canonical = fs::canonical(directory, error);
  if (error) return;
  const std::lock_guard lock(mutex);
  if (cleaned.insert(canonical).second) remove_abandoned_temporaries(canonical);
}

}  // namespace

fs::path temporary_beside(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  clean_once(directory_of(target));
  fs::path temporary;
  do {
    temporary = directory_of(target) / fmt::format(".{}.{}-{}.{}.partial{}",
                                                   target.stem().string().substr(0, kMaxStemBytes),
                                                   system_id(), getpid(), counter.fetch_add(1),
                                                   target.extension().string());
  } while (fs::exists(fs::symlink_status(temporary)));
  return temporary;
}

void remove_abandoned_temporaries(const fs::path& directory) {
  static const std::regex pattern(R"(\..*\.([0-9a-f]{8})-([0-9]{1,9})\.[0-9]+\.partial(\.[^.]*)?)");
  std::error_code error;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    std::smatch parts;
    // The search for the word is much faster than the pattern, and directories may be large.
    if (name.find(".partial") == std::string::npos || !std::regex_match(name, parts, pattern)) {
      continue;
    }
    if (!is_abandoned(parts[1], static_cast<pid_t>(std::stol(parts[2])), entry->path())) continue;
    std::error_code stays;
    fs::remove_all(entry->path(), stays);
  }
}

}  // namespace raywalk
