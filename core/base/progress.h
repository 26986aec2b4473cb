// Progress output: a live line with rate and remaining time on a terminal, plain lines in a log.
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace raywalk {

// Counts finished units of a task; thread-safe. Prints to stderr: on a terminal one line, rewritten
// at most ten times a second; elsewhere one line after a second, then one per tenth of the work, at
// most one a second. The destructor ends the live line. Prints nothing where the
// logger shows no information, as under --quiet.
class Progress {
 public:
  // Steps that are short for most rooms are only worth a line where they take longer than a second.
  enum class Shown { kAlways, kIfLong };

  Progress(std::string what, std::int64_t total, std::string unit, Shown shown = Shown::kAlways);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance(std::int64_t units = 1);

 private:
  void print(bool final);

  std::mutex mutex_;
  std::string what_;
  std::string unit_;
  std::int64_t total_;
  Shown shown_;
  std::int64_t done_ = 0;
  std::int64_t printed_ = -1;
  bool terminal_ = false;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_print_;
};

}  // namespace raywalk
