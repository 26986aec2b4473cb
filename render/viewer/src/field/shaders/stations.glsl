// The stations' distance maps as the engine's shaders want them (src/engine/lookup.glsl). Vectors
// are in Raywalk's world: x right, y up, z forward. A panorama has its middle column at +z.

precision highp sampler2D;
precision highp usampler2D;

struct MapPlace {
  vec4 from_centre;  // of the station, from the viewpoint, metres
  int layer, width, rows;
};

uniform MapPlace map_places[MAX_MAPS];  // those that distances are gathered from, nearest first
uniform int gathered;                   // their number
uniform usampler2DArray maps;           // inverse distances in steps
uniform float inverse_step_per_m;

float held_in(MapPlace map, int column, int row) {
  return float(texelFetch(maps, ivec3(column, row, map.layer), 0).r) * inverse_step_per_m;
}

// Columns beside the picture that points are drawn into.
int margin_of(ivec2 size) { return size.x / 16 + 1; }
