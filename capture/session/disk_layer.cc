#include "capture/session/disk_layer.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>
#include <system_error>
#include <utility>

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& call) {
  throw std::system_error(errno, std::generic_category(), call);
}

// File systems that cannot sync return EINVAL (fsync(2)); that is not a failed write.
void sync_descriptor(int fd) {
  if (fsync(fd) != 0 && errno != EINVAL) fail("fsync");
}

class SystemFile final : public DiskFile {
 public:
  explicit SystemFile(const fs::path& file)
      : fd_(::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)) {
    if (fd_ < 0) fail("open");
  }
  ~SystemFile() override {
    if (fd_ >= 0) ::close(fd_);
  }
  SystemFile(const SystemFile&) = delete;
  SystemFile& operator=(const SystemFile&) = delete;

  void write(std::span<const std::byte> bytes) override {
    while (!bytes.empty()) {
      const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail("write");
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
  }
  void sync() override { sync_descriptor(fd_); }
  void close() override {
    if (::close(std::exchange(fd_, -1)) != 0) fail("close");
  }

 private:
  int fd_;
};

// Fallback for file systems without RENAME_NOREPLACE (some network ones): link() also fails if the
// name exists.
void link_then_unlink(const fs::path& from, const fs::path& to) {
  if (::link(from.c_str(), to.c_str()) != 0) fail("link");
  if (::unlink(from.c_str()) != 0) fail("unlink");
}

class SystemDisk final : public DiskLayer {
 public:
  std::unique_ptr<DiskFile> create(const fs::path& file) override {
    return std::make_unique<SystemFile>(file);
  }
  void rename_new(const fs::path& from, const fs::path& to) override {
    if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return;
    // rename(2): EINVAL from a file system that does not support the flag.
    if (errno != EINVAL && errno != ENOSYS) fail("rename");
    link_then_unlink(from, to);
  }
  void sync_directory(const fs::path& directory) override {
    const int fd = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) fail("open");
    const bool synced = fsync(fd) == 0 || errno == EINVAL;
    const int error = errno;
    ::close(fd);
    if (!synced) throw std::system_error(error, std::generic_category(), "fsync");
  }
  void remove(const fs::path& file) override {
    if (::unlink(file.c_str()) != 0) fail("unlink");
  }
};

}  // namespace

DiskLayer& system_disk() {
  static SystemDisk disk;
  return disk;
}

}  // namespace raywalk::capture
