// A contiguous HDF5 dataset mapped read-only into memory, so that a view touches only the pages it
// reads. HDF5 gives the offset of a contiguous dataset's bytes in the file (H5Dget_offset).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace raywalk {

enum class ElementType { kUint8, kFloat32, kInt32 };

class MappedDataset {
 public:
  MappedDataset() = default;
  MappedDataset(MappedDataset&& other) noexcept;
  MappedDataset& operator=(MappedDataset&& other) noexcept;
  MappedDataset(const MappedDataset&) = delete;
  MappedDataset& operator=(const MappedDataset&) = delete;
  ~MappedDataset();

  // Maps `dataset` of `file`. Throws Error naming both when the file is missing, is not HDF5, the
  // dataset is missing, of another element type, not stored contiguously, or reaches past the end
  // of the file (a volume cut short).
  static MappedDataset open(const std::filesystem::path& file, const std::string& dataset,
                            ElementType type);

  const std::vector<std::size_t>& shape() const { return shape_; }
  const void* data() const { return data_; }

  // Tells the system that a few kilobytes will be read in each of thousands of places, where
  // reading ahead from the disk would fetch many times what is needed. Advice only.
  void expect_scattered_reads() const;

  // Asks the system to begin fetching bytes of data() from the disk; does not wait for them. Advice
  // only.
  void fetch(const void* begin, std::size_t bytes) const;
  // Whether a byte of data() can be read without waiting for the disk, as far as the system tells;
  // it tells of nobody else's files, which all count as in memory.
  bool in_memory(const void* byte) const;

 private:
  void* mapping_ = nullptr;
  std::size_t mapping_bytes_ = 0;
  const void* data_ = nullptr;
  std::vector<std::size_t> shape_;
};

}  // namespace raywalk
