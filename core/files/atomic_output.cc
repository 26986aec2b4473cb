#include "core/files/atomic_output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <mutex>
#include <regex>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/files/fingerprint.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStandardInput = "-";
constexpr std::size_t kReadBlockBytes = std::size_t{1} << 18;
// Linux limits a name to 255 bytes; a temporary name adds far less than 100 to the stem.
constexpr std::size_t kMaxStemBytes = 100;
constexpr auto kForeignAge = std::chrono::hours(24);

struct Closer {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using OpenFile = std::unique_ptr<std::FILE, Closer>;

// The message of an errno value.
std::string reason(int error_number) {
  const std::string message = std::generic_category().message(error_number);
  const bool is_full = error_number == ENOSPC || error_number == EDQUOT;
  return is_full ? message + "; free some space" : message;
}

[[noreturn]] void throw_write_error(const fs::path& target, const std::string& why) {
  throw Error("cannot write " + target.string() + ": " + why);
}

fs::path follow_link(fs::path target) {
  std::error_code error;
  if (!fs::is_symlink(target, error)) return target;
  fs::path resolved = fs::weakly_canonical(target, error);
  if (error) throw_write_error(target, error.message());
  return resolved;
}

void check_target(const fs::path& target) {
  if (!target.has_filename()) {
    throw Error("cannot write '" + target.string() + "': it names no file");
  }
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  if (fs::is_directory(status)) {
    throw_write_error(target, "it is a directory; name a file in it");
  }
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw_write_error(target, "it is not a regular file");
  }
  const fs::path directory = directory_of(target);
  if (!fs::is_directory(directory, error)) {
    throw_write_error(target,
                      directory.string() + " is not an existing directory; create it first");
  }
  if (access(directory.c_str(), W_OK | X_OK) != 0) throw_write_error(target, reason(errno));
}

// Renames without replacing; 0 or an errno value (EEXIST). Some network file systems do not support
// the flag (rename(2): EINVAL); link() also fails where the name exists.
int rename_new(const fs::path& from, const fs::path& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
  return link(from.c_str(), to.c_str()) == 0 && unlink(from.c_str()) == 0 ? 0 : errno;
}

// fsync of a file or directory; 0 or an errno value. Some file systems cannot sync a directory and
// return EINVAL (fsync(2)); no data is lost.
int sync_to_disk(const fs::path& path) {
  const OpenFile file(std::fopen(path.c_str(), "re"));
  return file && (fsync(fileno(file.get())) == 0 || errno == EINVAL) ? 0 : errno;
}

// Writes a file that does not exist yet; 0 or an errno value.
int write_bytes(const fs::path& path, std::span<const std::byte> bytes) {
  OpenFile file(std::fopen(path.c_str(), "wxe"));
  const bool written =
      file && std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size() &&
      std::fclose(file.release()) == 0;  // network file systems report failed writes here
  return written ? 0 : errno;
}

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

// Whether a temporary was left by a process that does not run any more. Of this process's id, it is
// of an earlier process: the directory is looked through before this one makes any in it.
bool is_abandoned(const std::string& system, pid_t process, const fs::path& path) {
  if (system == system_id()) {
    const bool is_running = kill(process, 0) == 0 || errno == EPERM;
    return process == getpid() || !is_running;
  }
  std::error_code error;
  const fs::file_time_type changed = fs::last_write_time(path, error);
  return !error && fs::file_time_type::clock::now() - changed > kForeignAge;
}

void remove_abandoned_temporaries(const fs::path& directory) {
  static const std::regex pattern(R"(\..*\.([0-9a-f]{8})-([0-9]{1,9})\.[0-9]+\.partial(\.[^.]*)?)");
  std::error_code error;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    std::smatch parts;
    if (!name.starts_with('.') || !std::regex_match(name, parts, pattern)) continue;
    if (!is_abandoned(parts[1], static_cast<pid_t>(std::stol(parts[2])), entry->path())) continue;
    std::error_code stays;
    fs::remove_all(entry->path(), stays);
  }
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

std::string read_up_to(std::size_t max_bytes, std::FILE* file, const std::string& name) {
  std::string bytes;
  std::vector<char> block(kReadBlockBytes);
  while (file != nullptr && bytes.size() < max_bytes && std::feof(file) == 0) {
    const std::size_t wanted = std::min(block.size(), max_bytes - bytes.size());
    bytes.append(block.data(), std::fread(block.data(), 1, wanted, file));
    if (std::ferror(file) != 0) break;
  }
  if (file == nullptr || std::ferror(file) != 0) {
    throw Error("cannot read " + name + ": " + reason(errno));
  }
  return bytes;
}

void require_at_most(std::size_t max_bytes, const std::string& bytes, const std::string& name) {
  if (bytes.size() <= max_bytes) return;
  throw Error(name + ": larger than " + std::to_string(max_bytes) +
              " bytes; is it the right file?");
}

}  // namespace

AtomicFile::AtomicFile(fs::path target) : target_(follow_link(std::move(target))) {
  check_target(target_);
  temporary_ = temporary_beside(target_);
}

AtomicFile::~AtomicFile() {
  std::error_code ignored;
  if (!committed_) fs::remove(temporary_, ignored);
}

void AtomicFile::commit() {
  if (const int error = sync_to_disk(temporary_)) throw_write_error(target_, reason(error));
  if (std::rename(temporary_.c_str(), target_.c_str()) != 0) {
    throw_write_error(target_, reason(errno));
  }
  committed_ = true;
  const int error = sync_to_disk(directory_of(target_));
  if (error != 0) throw_write_error(target_, reason(error));
}

void write_file_atomically(const fs::path& target, std::span<const std::byte> bytes) {
  AtomicFile output(target);
  if (const int error = write_bytes(output.temporary_path(), bytes)) {
    throw_write_error(target, reason(error));
  }
  output.commit();
}

void write_new_file(const fs::path& target, std::span<const std::byte> bytes) {
  const fs::path temporary = temporary_beside(target);
  fs::path made = temporary;
  int error = write_bytes(temporary, bytes);
  if (error == 0) error = sync_to_disk(temporary);
  if (error == 0) error = rename_new(temporary, target);
  if (error == 0) {
    made = target;
    error = sync_to_disk(directory_of(target));
  }
  if (error == 0) return;
  std::error_code ignored;
  fs::remove(made, ignored);
  if (error == EEXIST) {
    throw Error(target.string() + " already exists and is not overwritten; move it elsewhere");
  }
  throw_write_error(target, reason(error));
}

void sync_directory(const fs::path& directory) {
  const int error = sync_to_disk(directory);
  if (error != 0) throw Error("cannot sync " + directory.string() + ": " + reason(error));
}

void write_file_atomically(const fs::path& target, std::string_view text) {
  write_file_atomically(target, std::as_bytes(std::span(text)));
}

fs::path directory_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

void make_directories(const fs::path& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) throw Error("cannot make " + directory.string() + ": " + error.message());
}

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

NamelessFile::NamelessFile(const fs::path& directory) {
  // Under a name that is known to be left over if the program is killed before the next line.
  const fs::path path = temporary_beside(directory / "values");
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor_ < 0) {
    throw Error(fmt::format("{}: cannot write there: {}", directory.string(), reason(errno)));
  }
  ::unlink(path.c_str());
}

NamelessFile::~NamelessFile() { ::close(descriptor_); }

void require_regular_file(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (fs::is_regular_file(status)) return;
  std::string why = error.message();
  if (!error) {
    why = fs::is_directory(status) ? reason(EISDIR) : "Is a named pipe, socket or device";
    why += "; give a regular file";
  }
  throw Error("cannot read " + file.string() + ": " + why);
}

std::string read_file(const fs::path& file, std::size_t max_bytes) {
  // One byte more than allowed shows that a file is too large.
  std::string bytes = read_file_prefix(file, std::max(max_bytes, max_bytes + 1));
  require_at_most(max_bytes, bytes, file.string());
  return bytes;
}

std::string read_file_or_stdin(const fs::path& file, std::size_t max_bytes) {
  if (file != kStandardInput) return read_file(file, max_bytes);
  std::string bytes = read_up_to(max_bytes + 1, stdin, input_name(file));
  require_at_most(max_bytes, bytes, input_name(file));
  return bytes;
}

std::string input_name(const fs::path& file) {
  return file == kStandardInput ? "standard input" : file.string();
}

std::string read_file_prefix(const fs::path& file, std::size_t max_bytes) {
  require_regular_file(file);
  const OpenFile open(std::fopen(file.c_str(), "re"));
  return read_up_to(max_bytes, open.get(), file.string());
}

}  // namespace raywalk
