// Fewer, larger pages for memory that is written all over.
#pragma once

#include <cstddef>

namespace raywalk {

// Asks for huge pages where whole ones lie within the memory. It is advice: where the system has
// none to give, or the pages are in use already, nothing changes.
void advise_huge_pages(void* data, std::size_t bytes);

}  // namespace raywalk
