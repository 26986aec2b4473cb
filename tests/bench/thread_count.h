// Benchmarks with a number of threads of their own.
#pragma once

#include "core/base/parallel.h"

namespace raywalk::bench {

// Restores the number of threads on destruction.
class ThreadCount {
 public:
  ThreadCount() = default;
  ~ThreadCount() { set_thread_count(before_); }
  ThreadCount(const ThreadCount&) = delete;
  ThreadCount& operator=(const ThreadCount&) = delete;

 private:
  int before_ = thread_count();
};

}  // namespace raywalk::bench
