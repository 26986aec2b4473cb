#include "simulator/room/facets.h"

namespace raywalk::capture {

int Facets::add_surface(const Surface& surface) {
  surfaces.push_back(surface);
  return static_cast<int>(surfaces.size()) - 1;
}

}  // namespace raywalk::capture
