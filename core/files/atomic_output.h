// Whole files: read, and written under a temporary name beside the target that is then renamed to
// it, so that a file is there only when it is complete.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace raywalk {

// Write the file at temporary_path(); commit() flushes it to disk and renames it to the target.
// Without commit() the destructor removes it, so a failure leaves nothing behind; what a killed
// process leaves, the next one that writes to the directory removes.
class AtomicFile {
 public:
  // Throws Error if the target's directory does not exist or is not writable, or the target exists
  // and is not a regular file. A symbolic link is followed: the file it names is replaced and the
  // link stays.
  explicit AtomicFile(std::filesystem::path target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // In the target's directory, with the target's extension (encoders use it); does not exist yet.
  const std::filesystem::path& temporary_path() const { return temporary_; }
  // fsync, rename, fsync of the directory. Throws Error (disk full, permissions).
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
  bool committed_ = false;
};

// Writes a whole file atomically. Throws Error naming the target (unwritable, disk full).
void write_file_atomically(const std::filesystem::path& target, std::span<const std::byte> bytes);
void write_file_atomically(const std::filesystem::path& target, std::string_view text);

// Writes a new file: complete and on the disk when it returns, or not there at all. Throws Error
// naming the target (its name is taken, also by a symbolic link; disk full).
void write_new_file(const std::filesystem::path& target, std::span<const std::byte> bytes);

// Returns once names made, changed or removed in the directory are on the disk. Throws Error.
void sync_directory(const std::filesystem::path& directory);

// The directory a file lies in; "." for a bare name.
std::filesystem::path directory_of(const std::filesystem::path& file);

// Creates a directory and its missing parents. Throws Error naming it.
void make_directories(const std::filesystem::path& directory);

// A path that does not exist yet, beside the target and with its extension, for a file or directory
// that is not finished: ".<stem>.<system>-<process>.<n>.partial<extension>". The dot hides it from
// listings. The first time in a directory, what killed processes left there under such names is
// removed: that of processes of this system that are no longer running, and that of another system
// (another computer or container on a shared disk, or this one before it was restarted) once it is
// a day old.
std::filesystem::path temporary_beside(const std::filesystem::path& target);

// An open file, empty, to read and write, whose name is removed at once: it is gone when the
// program ends, however it ends.
class NamelessFile {
 public:
  // Throws Error naming the directory if no file can be made there.
  explicit NamelessFile(const std::filesystem::path& directory);
  ~NamelessFile();
  NamelessFile(const NamelessFile&) = delete;
  NamelessFile& operator=(const NamelessFile&) = delete;

  int descriptor() const { return descriptor_; }

 private:
  int descriptor_ = -1;
};

// Throws Error naming the file unless it is, or links to, a regular file: opening a named pipe
// would wait for a writer, reading a device may never end.
void require_regular_file(const std::filesystem::path& file);

// Reads a whole file. Throws Error naming it when missing, unreadable, not a regular file, or
// larger than max_bytes.
std::string read_file(const std::filesystem::path& file,
                      std::size_t max_bytes = std::size_t{1} << 30);

// The same, or standard input up to its end for "-".
std::string read_file_or_stdin(const std::filesystem::path& file,
                               std::size_t max_bytes = std::size_t{1} << 30);
// What messages call it: the file's name or "standard input".
std::string input_name(const std::filesystem::path& file);

// The first max_bytes bytes of a file, or all of it if it is shorter. Throws Error as read_file.
std::string read_file_prefix(const std::filesystem::path& file, std::size_t max_bytes);

}  // namespace raywalk
