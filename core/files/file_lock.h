// A lock on a file (flock), which keeps two processes from writing the same output. It is held
// through an open descriptor, so the system releases it when the process ends or crashes.
//
// Several processes can share a lock to work in one folder; what changes the folder as a whole
// needs it alone. Between machines it works where the shared file system passes flock on: NFS does,
// Lustre if it is mounted with `flock`.
#pragma once

#include <filesystem>
#include <string>

namespace raywalk {

class FileLock {
 public:
  enum class Use { kAlone, kShared };

  // Creates the file if it is missing and locks it. Throws Error: "cannot write <directory>: ..."
  // if it cannot be created, "<directory>: <busy>" if another process holds the lock or has just
  // removed the file, "cannot lock <file>: ..." if the file system does not support locks.
  //
  // kShared: the lock is held alone() if nobody else has it, so that the folder can be prepared,
  // until share(); else it is shared with those who share it. A process that prepares is waited
  // for, 10 s at most; throws Interrupted meanwhile.
  FileLock(const std::filesystem::path& file, const std::string& busy, Use use = Use::kAlone);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  bool alone() const { return alone_; }
  // From now on others can share the lock. Another process may hold it alone for a moment before
  // this one shares it. Throws Error as the constructor does.
  void share();
  // Whether the lock could be taken alone. If not, it may be lost.
  bool try_alone();

 private:
  // Shares the lock, waiting for a while; with `may_be_alone` takes it alone if that is possible.
  void wait_to_share(bool may_be_alone);
  bool lock(int how);  // whether it is held; throws if the file system does not support locks

  std::filesystem::path file_;
  std::string busy_;
  int fd_ = -1;
  bool alone_ = false;
};

}  // namespace raywalk
