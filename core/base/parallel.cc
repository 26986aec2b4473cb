#include "core/base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <opencv2/core/utility.hpp>
#include <utility>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#ifdef RAYWALK_SANITIZE_THREAD
#include <sanitizer/tsan_interface.h>
#endif

namespace raywalk {
namespace {

// What happens before give(tag) on one thread happens before what follows take(tag) on another. TBB
// ensures that anyway, but ThreadSanitizer cannot see it: neither libtbb nor this file, with TBB's
// tasks, is instrumented (CMakeLists.txt).
#ifdef RAYWALK_SANITIZE_THREAD
void give(void* tag) { __tsan_release(tag); }
void take(void* tag) { __tsan_acquire(tag); }
#else
void give(void*) {}
void take(void*) {}
#endif

// Calls a function at the end of its scope, be it left by an exception.
template <typename Function>
class AtEnd {
 public:
  explicit AtEnd(Function function) : function_(std::move(function)) {}
  ~AtEnd() { function_(); }
  AtEnd(const AtEnd&) = delete;
  AtEnd& operator=(const AtEnd&) = delete;

 private:
  Function function_;
};

}  // namespace

void set_thread_count(int threads) {
  if (threads < 0) {
    throw UsageError("the number of threads is " + std::to_string(threads) +
                     "; give 0 for all cores, or at least 1");
  }
  // TBB uses the smallest limit of all live global_control objects, so the old one is destroyed
  // first.
  static std::mutex mutex;
  static std::unique_ptr<tbb::global_control> limit;
  const std::lock_guard lock(mutex);
  limit.reset();
  if (threads > 0) {
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  static_cast<std::size_t>(threads));
  }
  // OpenCV takes 0 as "no threading", so it gets the resolved count.
  cv::setNumThreads(thread_count());
}

int thread_count() {
  return static_cast<int>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void parallel_for(int begin, int end, int grain, const std::function<void(int, int)>& body) {
  if (begin >= end) return;
  const auto chunk = static_cast<std::size_t>(std::max(grain, 1));
  char to_bodies = 0, from_bodies = 0;
  give(&to_bodies);
  const AtEnd take_at_end([&] { take(&from_bodies); });
  // The simple partitioner splits until a chunk holds at most `grain` indices; the default one may
  // make far larger chunks, which would delay the response to Ctrl-C.
  tbb::task_group_context context;
  tbb::parallel_for(
      tbb::blocked_range<int>(begin, end, chunk),
      [&](const tbb::blocked_range<int>& range) {
        take(&to_bodies);
        const AtEnd give_at_end([&] { give(&from_bodies); });
        throw_if_interrupted();
        body(range.begin(), range.end());
      },
      tbb::simple_partitioner(), context);
  // Where another body of an outer loop has failed, TBB ends this one without its bodies.
  if (context.is_group_execution_cancelled()) throw Interrupted("interrupted");
}

void check_in_parallel(int count, const std::function<void(int)>& check) {
  constexpr int kGrain = 8;
  std::atomic<int> least = count;
  std::exception_ptr failure;
  std::mutex mutex;
  parallel_for(0, count, kGrain, [&](int begin, int end) {
    for (int i = begin; i < std::min(end, least.load()); ++i) {
      try {
        check(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (i >= least) continue;
        least = i;
        failure = std::current_exception();
      }
    }
  });
  if (failure) std::rethrow_exception(failure);
}

}  // namespace raywalk
