// Distance maps on a graphics card, and the distances of a view.

struct MapPlace {
  vec4 from_centre;  // of its station, from the view's centre, metres
  int layer, width, rows;
  int masks;                    // layer of `masks`; -1: all of the station may be used
  int moved_width, moved_rows;  // of the panoramas in which what moved is marked; 0: nothing moved
  int unused_0, unused_1;
};
// First those that distances are gathered from, nearest first.
layout(std430, binding = 0) readonly buffer MapPlaces { MapPlace map_places[]; };

uniform int gathered;         // number of maps that distances are gathered from
uniform sampler2DArray maps;  // x: row, y: column; inverse distances, 1/m, negative where unknown

float held_in(MapPlace map, int column, int row) {
  return texelFetch(maps, ivec3(row, column, map.layer), 0).r;
}

// Inverse distances, then how far they can be relied on, and smooth ones (SmoothDistances).
layout(std430, binding = 1) buffer Distances { float distances[]; };
float inverse_at(int column, int row) { return distances[column * distance_size.y + row]; }
