// A contiguous HDF5 dataset mapped read-only into memory, so that a view loads only the pages it
// reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/room/hdf5_file.h"

namespace raywalk {

// Of this machine's memory.
std::size_t page_bytes();

class MappedDataset {
 public:
  // Throws Error as Hdf5File::place_of does, or if the file cannot be mapped.
  MappedDataset(const Hdf5File& hdf5, const std::string& dataset, ElementType type);
  ~MappedDataset();
  MappedDataset(const MappedDataset&) = delete;
  MappedDataset& operator=(const MappedDataset&) = delete;

  const void* data() const { return data_; }

  // Disables read-ahead, for reads of a few kilobytes in thousands of places. Advice only.
  void expect_scattered_reads() const;
  // Starts reading bytes of data() from disk without waiting. Advice only.
  void fetch(const void* begin, std::size_t bytes) const;
  // Whether a byte of data() is in memory. True where the system cannot tell.
  bool in_memory(const void* byte) const;

 private:
  void release();

  int file_ = -1;  // descriptor
  void* mapping_ = nullptr;
  std::size_t mapping_bytes_ = 0;
  const std::byte* data_ = nullptr;
  std::uint64_t begin_ = 0;  // of the data in the file
};

}  // namespace raywalk
