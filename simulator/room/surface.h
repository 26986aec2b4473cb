// Surfaces with procedural patterns or pictures.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace raywalk::simulator {

// Light and reflectance in linear RGB.
using Color = Eigen::Vector3f;

// Linear interpolation: `a` at share 0, `b` at share 1.
inline Color mix(const Color& a, const Color& b, float share) { return a + share * (b - a); }

// Relative luminance of linear sRGB primaries (ITU-R BT.709).
inline float luminance(const Color& color) { return color.dot(Color(0.2126F, 0.7152F, 0.0722F)); }

// A picture file on a surface.
class Texture {
 public:
  // Throws Error if the file cannot be read as a picture.
  explicit Texture(const std::filesystem::path& file);

  // The reflectance at `at`, where the picture lies between (0, 0), its lower left corner, and
  // (1, 1), and repeats beyond; averaged over a square of the side `footprint`.
  Color at(const Eigen::Vector2f& at, float footprint) const;

 private:
  std::vector<cv::Mat> levels_;  // CV_32FC3, BGR, linear; each half as wide as the one before
};

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

// Light of the sky in a unit direction of the world frame (sphere.h), relative to white: a gradient
// with clouds, a bright haze at the horizon, hills below. `pixel_rad` is the angular pixel size.
Color sky_light(const Eigen::Vector3d& direction, float pixel_rad, std::uint32_t seed);

}  // namespace raywalk::simulator
