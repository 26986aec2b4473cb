// One timing run at a time on this machine: two would time each other, on whatever rooms.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace raywalk {

// The file that all timing runs of a machine lock, whoever starts them.
std::filesystem::path machine_timing_lock();

// Holds a lock (flock) on a file, which the system releases when the process ends or crashes. The
// file says who holds it and is left behind.
class TimingLock {
 public:
  // Waits while another process holds the lock, after one line on the log that says which; calls
  // `pause` between tries. `work` is what this process is going to time, for the others' line.
  // Throws Error where the file cannot be opened or locked; Interrupted.
  TimingLock(const std::filesystem::path& file, const std::string& work,
             const std::function<void()>& pause = a_moment);
  ~TimingLock();
  TimingLock(const TimingLock&) = delete;
  TimingLock& operator=(const TimingLock&) = delete;

 private:
  static void a_moment();

  int fd_ = -1;
};

}  // namespace raywalk
