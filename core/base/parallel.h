// Loops over all cores, on TBB.
#pragma once

#include <functional>

namespace raywalk {

// Sets how many threads parallel_for and OpenCV's own loops use; 0 = all cores, 1 = the calling
// thread alone. Call it before parallel work starts (the --threads flag). Throws UsageError for a
// negative count.
void set_thread_count(int threads);

// Threads in use; at least 1.
int thread_count();

// Calls body(chunk_begin, chunk_end) for consecutive chunks that cover [begin, end) exactly once,
// on several threads and in no particular order. A chunk holds at most `grain` indices (values
// below 1 count as 1); interrupts are checked between chunks. An empty range makes no calls. The
// first exception thrown by a body, or Interrupted after Ctrl-C, ends the loop: chunks that have
// started finish, the others are skipped, and the exception is rethrown here.
void parallel_for(int begin, int end, int grain, const std::function<void(int, int)>& body);

// Calls check(i) for every i in [0, count), in parallel. Of the exceptions that checks throw the
// one of the least i is rethrown, so that the message does not depend on timing; checks of larger i
// may be skipped then.
void check_in_parallel(int count, const std::function<void(int)>& check);

}  // namespace raywalk
