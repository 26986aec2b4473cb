// Diffuse surfaces with procedural patterns.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "simulator/room/color.h"

namespace raywalk::capture {

enum class Pattern {
  kPlain,      // uniform paint
  kPlaster,    // stained and speckled paint
  kBricks,     // rows of bricks in mortar
  kWallpaper,  // a motif that repeats exactly
  kBoards,     // floor boards along s
  kTiles,      // square tiles
  kWood,       // grain along s
  kFabric,     // stripes and weave
  kRug,        // a bordered carpet of diamonds
  kBook,       // the spine of a book, t upwards
  kLeaf,       // a leaf with veins along t
  kPicture,    // a painting of shapes over hills
  kShade,      // a paper lamp: emits light, with ribs along s
  kSky,        // seen through a window, infinitely far
  kMirror      // reflects; all other patterns are diffuse
};

// Lengths are in room units (see room_plan.h).
struct Surface {
  Pattern pattern = Pattern::kPlain;
  Color base{0.5F, 0.5F, 0.5F};
  Color accent{0.5F, 0.5F, 0.5F};
  float period = 0.25F;  // of patterns that repeat: a tile's side, a board's width
  // Size of the patterned area, for patterns that do not repeat (kPicture, kRug, kBook, kLeaf).
  Eigen::Vector2f extent{1.0F, 1.0F};
  std::uint32_t seed = 0;
};

// Reflectance at the texture coordinates `at` (room units, s to the right and t upwards), averaged
// over a pixel whose side covers `footprint` room units. For kShade it is the emitted light
// relative to white; kSky and kMirror give black.
Color albedo_at(const Surface& surface, const Eigen::Vector2f& at, float footprint);

// The mean of albedo_at over the surface, for the light that it scatters.
Color mean_albedo(const Surface& surface);

}  // namespace raywalk::capture
