// The resident memory of this process as Linux reports it: proc(5), /proc/self/status and
// clear_refs. Pages of mapped files count once they have been touched.
#pragma once

namespace raywalk {

// VmRSS, bytes.
double resident_bytes();

// RssFile, bytes: the resident pages of mapped files. Linux also maps up to 16 cached pages around
// each page touched, so this is an upper bound of what was read.
double mapped_resident_bytes();

// VmHWM, bytes: the largest resident set since the process started or the last reset.
double peak_resident_bytes();

// Resets the peak to the current resident set.
void reset_peak_resident();

// Returns freed memory from the allocator to the system, so that later allocations show in the
// resident set.
void release_free_memory();

}  // namespace raywalk
