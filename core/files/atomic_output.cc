#include "core/files/atomic_output.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/temporary_names.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kReadBlockBytes = std::size_t{1} << 20;
constexpr std::size_t kEndBytes = std::size_t{4} << 10;  // asked for where the end is expected
constexpr const char* kStandardInput = "-";

// The message of an errno value.
std::string reason(int error_number) { return std::generic_category().message(error_number); }

[[noreturn]] void throw_write_error(const fs::path& target, int error_number) {
  throw Error("cannot write " + target.string() + ": " + reason(error_number));
}

// Owns a file descriptor.
class Descriptor {
 public:
  Descriptor(const fs::path& file, int flags) : fd_(open(file.c_str(), flags | O_CLOEXEC, 0666)) {}
  // Takes over an open descriptor.
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  bool valid() const { return fd_ >= 0; }
  int get() const { return fd_; }
  // Closes now; false on failure: network file systems report failed writes here.
  bool close() { return ::close(std::exchange(fd_, -1)) == 0; }

 private:
  int fd_;
};

fs::path follow_link(fs::path target) {
  std::error_code error;
  if (!fs::is_symlink(target, error)) return target;
  fs::path resolved = fs::weakly_canonical(target, error);
  if (error) throw Error("cannot write " + target.string() + ": " + error.message());
  return resolved;
}

void check_target(const fs::path& target) {
  if (!target.has_filename()) {
    throw Error("cannot write '" + target.string() + "': it names no file");
  }
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  if (fs::is_directory(status)) {
    throw Error("cannot write " + target.string() + ": it is a directory; name a file in it");
  }
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw Error("cannot write " + target.string() + ": it is not a regular file");
  }
  const fs::path directory = directory_of(target);
  if (!fs::is_directory(directory, error)) {
    throw Error("cannot write " + target.string() + ": " + directory.string() +
                " is not an existing directory; create it first");
  }
  if (access(directory.c_str(), W_OK | X_OK) != 0) throw_write_error(target, errno);
}

// Why something that exists cannot be read.
std::string what_is(fs::file_type type) {
  constexpr const char* kAdvice = "; give a regular file";
  switch (type) {
    case fs::file_type::not_found:
      return reason(ENOENT);
    case fs::file_type::directory:
      return reason(EISDIR) + kAdvice;
    case fs::file_type::fifo:
      return std::string("Is a named pipe") + kAdvice;
    case fs::file_type::socket:
      return std::string("Is a socket") + kAdvice;
    default:
      return std::string("Is a device") + kAdvice;
  }
}

std::string read_up_to(const Descriptor& descriptor, const std::string& name,
                       std::size_t max_bytes) {
  if (!descriptor.valid()) throw Error("cannot read " + name + ": " + reason(errno));
  // The size is only used to reserve memory: pipes have none, and a file may be growing.
  struct stat status = {};
  const bool sized = fstat(descriptor.get(), &status) == 0 && status.st_size > 0;
  const std::size_t expected = sized ? static_cast<std::size_t>(status.st_size) : kReadBlockBytes;

  std::string bytes;
  std::size_t block = std::min(expected, max_bytes);
  while (bytes.size() < max_bytes) {
    const std::size_t before = bytes.size();
    bytes.resize(before + std::min(block, max_bytes - before));
    const ssize_t count = read(descriptor.get(), bytes.data() + before, bytes.size() - before);
    const int error = errno;
    bytes.resize(before + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    if (count < 0 && error == EINTR) continue;
    if (count < 0) throw Error("cannot read " + name + ": " + reason(error));
    if (count == 0) break;
    block = sized && bytes.size() == expected ? kEndBytes : kReadBlockBytes;
  }
  return bytes;
}

std::string read_limited(const Descriptor& descriptor, const std::string& name,
                         std::size_t max_bytes) {
  // Reads one byte more than allowed to detect a file that is too large.
  std::string bytes = read_up_to(descriptor, name, std::max(max_bytes, max_bytes + 1));
  if (bytes.size() > max_bytes) {
    throw Error(name + ": larger than " + std::to_string(max_bytes) +
                " bytes; is it the right file?");
  }
  return bytes;
}

// fsync of a file or directory; 0 or an errno value. Some file systems cannot sync a directory and
// return EINVAL (fsync(2)); no data is lost.
int sync_to_disk(const fs::path& path) {
  const Descriptor descriptor(path, O_RDONLY);
  if (!descriptor.valid()) return errno;
  return fsync(descriptor.get()) == 0 || errno == EINVAL ? 0 : errno;
}

// 0 or an errno value.
int write_all(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return 0;
}

}  // namespace

fs::path directory_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

AtomicFile::AtomicFile(fs::path target) : target_(follow_link(std::move(target))) {
  check_target(target_);
  temporary_ = temporary_beside(target_);
}

AtomicFile::~AtomicFile() {
  std::error_code ignored;
  if (!committed_) fs::remove(temporary_, ignored);
}

void AtomicFile::commit() {
  if (const int error = sync_to_disk(temporary_)) throw_write_error(target_, error);
  if (std::rename(temporary_.c_str(), target_.c_str()) != 0) throw_write_error(target_, errno);
  committed_ = true;
  if (const int error = sync_to_disk(directory_of(target_))) throw_write_error(target_, error);
}

void write_file_atomically(const fs::path& target, std::span<const std::byte> bytes) {
  AtomicFile output(target);
  Descriptor descriptor(output.temporary_path(), O_WRONLY | O_CREAT | O_EXCL);
  if (!descriptor.valid()) throw_write_error(target, errno);
  if (const int error = write_all(descriptor.get(), bytes)) throw_write_error(target, error);
  if (!descriptor.close()) throw_write_error(target, errno);
  output.commit();
}

void write_file_atomically(const fs::path& target, std::string_view text) {
  write_file_atomically(target, std::as_bytes(std::span(text)));
}

void make_directories(const fs::path& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) throw Error("cannot make " + directory.string() + ": " + error.message());
}

void require_regular_file(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (fs::is_regular_file(status)) return;
  throw Error("cannot read " + file.string() + ": " +
              (error ? error.message() : what_is(status.type())));
}

std::string read_file(const fs::path& file, std::size_t max_bytes) {
  require_regular_file(file);
  return read_limited(Descriptor(file, O_RDONLY), file.string(), max_bytes);
}

std::string read_file_or_stdin(const fs::path& file, std::size_t max_bytes) {
  if (file != kStandardInput) return read_file(file, max_bytes);
  return read_limited(Descriptor(::dup(STDIN_FILENO)), input_name(file), max_bytes);
}

std::string input_name(const fs::path& file) {
  return file == kStandardInput ? "standard input" : file.string();
}

std::string read_file_prefix(const fs::path& file, std::size_t max_bytes) {
  require_regular_file(file);
  return read_up_to(Descriptor(file, O_RDONLY), file.string(), max_bytes);
}

}  // namespace raywalk
