// The memory this process holds, as Linux counts it: proc(5), /proc/self/status and clear_refs.
// Pages of mapped files count as soon as they have been touched.
#pragma once

namespace raywalk {

// VmRSS, bytes.
double resident_bytes();

// RssFile, bytes: the part of it that is pages of mapped files. Linux maps up to 16 pages around
// each one touched where they are in its cache already, so this is an upper bound of what was read.
double mapped_resident_bytes();

// VmHWM, bytes: the largest resident set since the process started or the last reset.
double peak_resident_bytes();

// Starts the peak again from what is resident now.
void reset_peak_resident();

// Gives back to the system what the allocator keeps of freed memory, which would hide how much is
// taken afterwards.
void release_free_memory();

}  // namespace raywalk
