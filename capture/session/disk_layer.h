// The few calls by which a frame gets onto the disk, as an interface: a test's disk is full in
// mid-frame or loses power between any two of them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

namespace raywalk::capture {

// A new file that is being written. The destructor closes it without syncing.
class DiskFile {
 public:
  virtual ~DiskFile() = default;

  // Writes all bytes.
  virtual void write(std::span<const std::byte> bytes) = 0;
  // Returns once the written bytes are on the disk.
  virtual void sync() = 0;
  // Closes the file: network file systems report failed writes here.
  virtual void close() = 0;
};

// Every call throws std::system_error with the errno of the failed operation.
class DiskLayer {
 public:
  virtual ~DiskLayer() = default;

  // EEXIST if the name exists.
  virtual std::unique_ptr<DiskFile> create(const std::filesystem::path& file) = 0;
  // Renames within a directory without replacing; EEXIST if `to` exists.
  virtual void rename_new(const std::filesystem::path& from, const std::filesystem::path& to) = 0;
  // Returns once names created, changed or removed in the directory are on the disk.
  virtual void sync_directory(const std::filesystem::path& directory) = 0;
  virtual void remove(const std::filesystem::path& file) = 0;
};

// The disk of the machine.
DiskLayer& system_disk();

}  // namespace raywalk::capture
