// The distance maps of a volume whose datasets HDF5's own filters compress, shuffle and deflate, a
// chunk to a map: each is decoded when it is first asked for, and kept.
//
// HDF5 itself is not used for reading, as its packaged libraries are not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "core/room/hdf5_file.h"

namespace raywalk {

class DeflatedMaps {
 public:
  // Datasets `distance_m` and `confidence`. Throws Error naming the file where they are not such
  // datasets of one shape [map][theta][phi].
  explicit DeflatedMaps(const Hdf5File& hdf5);
  ~DeflatedMaps();
  DeflatedMaps(const DeflatedMaps&) = delete;
  DeflatedMaps& operator=(const DeflatedMaps&) = delete;

  const std::vector<std::size_t>& shape() const { return shape_; }
  // All maps one after the other; a map may be read after load(map).
  const float* distance_m() const { return static_cast<const float*>(distance_m_.memory); }
  const std::uint8_t* confidence() const {
    return static_cast<const std::uint8_t*>(confidence_.memory);
  }
  // From any thread. Throws Error naming the file where the map is damaged.
  void load(std::size_t map);

 private:
  struct Dataset {
    std::string name{};
    std::size_t element_bytes = 0;
    std::vector<Hdf5File::ChunkPlace> chunks{};
    void* memory = nullptr;  // address space for all maps
  };
  std::size_t map_bytes(const Dataset& dataset) const;
  void reserve(Dataset* dataset) const;
  void decode(const Dataset& dataset, std::size_t map) const;

  std::filesystem::path path_;
  std::vector<std::size_t> shape_;
  Dataset distance_m_{"distance_m", sizeof(float)};
  Dataset confidence_{"confidence", sizeof(std::uint8_t)};
  int file_ = -1;
  std::vector<std::once_flag> loaded_;
};

}  // namespace raywalk
