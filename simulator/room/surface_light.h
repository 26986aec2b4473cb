// What a ray sees of a patterned surface.
#pragma once

#include "simulator/room/embree_scene.h"
#include "simulator/room/facets.h"

namespace raywalk::capture {

// albedo_at (surface.h) where the ray meets the facet, `distance` from the ray's origin, filtered
// for a pixel that is `across` room units wide there, across the ray.
Color seen_albedo(const Facet& facet, const Surface& surface, const Ray& ray, double distance,
                  double across);

}  // namespace raywalk::capture
