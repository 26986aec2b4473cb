// Huge pages for large buffers, to reduce page faults and TLB misses.
#pragma once

#include <cstddef>

namespace raywalk {

// Asks for huge pages (madvise, MADV_HUGEPAGE) for those that lie entirely within [data, data +
// bytes). Advice only: nothing changes if the system has none available or the pages are already in
// use.
void advise_huge_pages(void* data, std::size_t bytes);

}  // namespace raywalk
