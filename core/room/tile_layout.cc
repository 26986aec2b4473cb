#include "core/room/tile_layout.h"

namespace raywalk {

int usual_tile_columns(PanoramaSize size) {
  constexpr int kPixels = 16384;
  constexpr int kLeast = 16;
  constexpr int kBlock = 8;  // JPEG codes blocks of 8 x 8 pixels
  const int columns = (kPixels / size.height + kBlock - 1) / kBlock * kBlock;
  return std::min(std::max(columns, kLeast), size.width);
}

}  // namespace raywalk
