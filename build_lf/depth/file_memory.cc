#include "build_lf/depth/file_memory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk::build_lf {
namespace {

// Reserves the blocks of an empty file and maps them; MAP_FAILED with errno.
void* map_reserved(const NamelessFile& file, std::size_t bytes) {
  do {
    errno = ::posix_fallocate(file.descriptor(), 0, static_cast<off_t>(bytes));
  } while (errno == EINTR);
  if (errno != 0) return MAP_FAILED;
  return ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file.descriptor(), 0);
}

}  // namespace

FileMemory::FileMemory(std::filesystem::path directory) : directory_(std::move(directory)) {}

// mmap returns whole pages, which are more than any alignment of values.
void* FileMemory::do_allocate(std::size_t bytes, std::size_t /*alignment*/) {
  const NamelessFile file(directory_);
  void* const memory = map_reserved(file, std::max<std::size_t>(bytes, 1));
  if (memory == MAP_FAILED) {
    throw Error(fmt::format("{}: cannot hold {:.0f} MB of intermediate values: {}",
                            directory_.string(), static_cast<double>(bytes) / 1e6,
                            std::generic_category().message(errno)));
  }
  return memory;
}

void FileMemory::do_deallocate(void* memory, std::size_t bytes, std::size_t /*alignment*/) {
  ::munmap(memory, std::max<std::size_t>(bytes, 1));
}

bool FileMemory::do_is_equal(const std::pmr::memory_resource& other) const noexcept {
  return this == &other;
}

}  // namespace raywalk::build_lf
