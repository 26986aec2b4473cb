// The rays of one line, mapped from `lines/<id>.h5`.
//
// Dataset `rays`: uint8 [station][theta][phi][rgb], stored contiguously; theta index = u (pixel
// column), phi index = v (pixel row, 0 at the top). One output column is one contiguous read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "core/geometry/sphere.h"
#include "core/room/mapped_dataset.h"

namespace raywalk {

// The root attribute `format` of lines/<id>.h5.
inline constexpr const char* kLineVolumeFormat = "raywalk-line";

class LineVolume {
 public:
  // Maps the volume read-only. Throws Error naming the file when it is missing, not HDF5, cut
  // short, of a newer format version, or its shape is not [stations][width][height][3].
  static LineVolume open(const std::filesystem::path& file, int stations, PanoramaSize panorama);

  int stations() const { return stations_; }
  PanoramaSize panorama() const { return panorama_; }
  // height * 3 bytes, RGB, top to bottom. `theta` in [0, width), `station` in [0, stations).
  std::span<const std::uint8_t> column(int station, int theta) const {
    const size_t bytes = static_cast<size_t>(panorama_.height) * 3;
    const size_t index = static_cast<size_t>(station) * static_cast<size_t>(panorama_.width) +
                         static_cast<size_t>(theta);
    return {static_cast<const std::uint8_t*>(rays_.data()) + index * bytes, bytes};
  }

 private:
  MappedDataset rays_;
  int stations_ = 0;
  PanoramaSize panorama_;
};

}  // namespace raywalk
