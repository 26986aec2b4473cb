#include "core/view/map_lookup.h"

namespace raywalk {

RAYWALK_VECTOR_CLONES void look_up_points(ColumnLookup map, const float* sin_phi,
                                          const float* cos_phi, const float* inverse, int count,
                                          float tolerance, float* part, float* held) {
  RAYWALK_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const HeldPoint point = look_up_point(map, sin_phi[i], cos_phi[i], inverse[i], tolerance);
    part[i] = point.part;
    held[i] = point.inverse;
  }
}

}  // namespace raywalk
