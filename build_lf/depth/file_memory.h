// Memory that lies in files, for values that need more than the machine has.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory_resource>

namespace raywalk::build_lf {

// Every allocation is a file of its own, without a name, mapped into memory: the kernel writes
// pages out and reads them again as it needs the room. Slower than memory, but never too small, and
// also within a control group, whose limit such pages do not exceed. For few large allocations. Can
// be used by several threads at once.
class FileMemory : public std::pmr::memory_resource {
 public:
  // `directory`: where the files are made; it must exist. It should lie on a disk, not in memory
  // (tmpfs).
  explicit FileMemory(std::filesystem::path directory);

 private:
  // Zeroed. The blocks of the file are reserved, as writing to a page without one would end the
  // process (SIGBUS). Throws Error naming the directory if it cannot hold them.
  void* do_allocate(std::size_t bytes, std::size_t alignment) override;
  void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override;
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override;

  std::filesystem::path directory_;
};

}  // namespace raywalk::build_lf
