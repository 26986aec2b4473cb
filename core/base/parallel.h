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
// on several threads at a time and in no particular order. A chunk holds at most `grain` indices
// (below 1 counts as 1), so that is the longest a Ctrl-C has to wait. An empty range makes no
// calls. The first exception of a body, or Interrupted once the user has asked to stop, ends the
// loop: chunks that have started finish, the others are dropped, and it is thrown from here.
void parallel_for(int begin, int end, int grain, const std::function<void(int, int)>& body);

}  // namespace raywalk
