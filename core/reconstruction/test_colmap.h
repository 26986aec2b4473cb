// For tests: what only newer versions of COLMAP write.
#pragma once

#include <cstdint>
#include <string>

#include "core/reconstruction/colmap_bytes.h"

namespace raywalk {

// A cameras.bin of COLMAP 4.1 with a camera of panoramas, id 1.
inline std::string equirectangular_camera_bytes() {
  ColmapBytes out;
  out.put_count(1);
  out.put(std::uint32_t{1});
  out.put(std::int32_t{17});  // EQUIRECTANGULAR: the parameters are width and height
  out.put(std::uint64_t{4096});
  out.put(std::uint64_t{2048});
  out.put(4096.0);
  out.put(2048.0);
  return out.bytes();
}

}  // namespace raywalk
