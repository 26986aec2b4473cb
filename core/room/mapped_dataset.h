// A contiguous HDF5 dataset mapped read-only into memory, so that a view loads only the pages it
// reads. H5Dget_offset gives the dataset's offset in the file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace raywalk {

enum class ElementType { kUint8, kFloat32, kInt32, kUint64 };

class MappedDataset {
 public:
  MappedDataset() = default;
  MappedDataset(MappedDataset&& other) noexcept;
  MappedDataset& operator=(MappedDataset&& other) noexcept;
  MappedDataset(const MappedDataset&) = delete;
  MappedDataset& operator=(const MappedDataset&) = delete;
  ~MappedDataset();

  // Maps `dataset` of `file`. Throws Error naming both when the file is missing, is not HDF5, the
  // dataset is missing, of another element type, not contiguous, or reaches past the end of the
  // file (truncated).
  static MappedDataset open(const std::filesystem::path& file, const std::string& dataset,
                            ElementType type);

  const std::vector<std::size_t>& shape() const { return shape_; }
  const void* data() const { return data_; }

  // Disables read-ahead (madvise, MADV_RANDOM), for reads of a few kilobytes in thousands of
  // places. Advice only.
  void expect_scattered_reads() const;

  // Starts reading bytes of data() from disk (madvise, MADV_WILLNEED) without waiting. Advice only.
  void fetch(const void* begin, std::size_t bytes) const;
  // Whether the page of a byte of data() is in memory, by mincore(2). Linux reports files that the
  // caller neither owns nor may write as always in memory.
  bool in_memory(const void* byte) const;

 private:
  void* mapping_ = nullptr;
  std::size_t mapping_bytes_ = 0;
  const void* data_ = nullptr;
  std::vector<std::size_t> shape_;
};

}  // namespace raywalk
