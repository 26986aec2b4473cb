// Surfaces with procedural patterns or pictures.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>

#include "simulator/room/color.h"
#include "simulator/room/texture.h"

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
  kPainting,   // a painting of shapes over hills
  kPicture,    // a picture file
  kLamp,       // a paper lamp: emits light, with ribs along s
  kSky,        // seen through a window, infinitely far
  kMirror,     // reflects
  kGlass       // a pane that reflects and is seen through; all other patterns are diffuse
};
inline constexpr std::array kPatterns{
    Pattern::kPlain,  Pattern::kPlaster,  Pattern::kBricks,  Pattern::kWallpaper, Pattern::kBoards,
    Pattern::kTiles,  Pattern::kWood,     Pattern::kFabric,  Pattern::kRug,       Pattern::kBook,
    Pattern::kLeaf,   Pattern::kPainting, Pattern::kPicture, Pattern::kLamp,      Pattern::kSky,
    Pattern::kMirror, Pattern::kGlass};
// As scene files have it: "wallpaper".
const char* name_of(Pattern pattern);

// Lengths are in metres.
struct Surface {
  Pattern pattern = Pattern::kPlain;
  Color base{0.5F, 0.5F, 0.5F};
  Color accent{0.5F, 0.5F, 0.5F};
  float period = 0.25F;  // of patterns that repeat: a tile's side, a board's width
  // Size of the patterned area, for patterns that do not repeat (kPainting, kRug, kBook, kLeaf),
  // and of a picture.
  Eigen::Vector2f extent{1.0F, 1.0F};
  std::uint32_t seed = 0;
  std::shared_ptr<const Texture> picture{};  // of kPicture
};

// Reflectance at the texture coordinates `at` (s to the right and t upwards), averaged over a pixel
// whose side covers `footprint`. For kLamp it is the emitted light relative to white; kSky, kMirror
// and kGlass give black.
Color albedo_at(const Surface& surface, const Eigen::Vector2f& at, float footprint);

// The mean of albedo_at over the surface, for the light that it scatters.
Color mean_albedo(const Surface& surface);

}  // namespace raywalk::capture
