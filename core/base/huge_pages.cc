#include "core/base/huge_pages.h"

#include <sys/mman.h>

#include <memory>

namespace raywalk {

void advise_huge_pages(void* data, std::size_t bytes) {
  constexpr std::size_t kHugePage = std::size_t{2} << 20;
  std::size_t left = bytes;
  void* first = std::align(kHugePage, kHugePage, data, left);
  if (first == nullptr) return;
  ::madvise(first, left / kHugePage * kHugePage, MADV_HUGEPAGE);
}

}  // namespace raywalk
