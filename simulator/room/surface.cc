#include "simulator/room/surface.h"

#include "simulator/room/patterns.h"

namespace raywalk::capture {

const char* name_of(Pattern pattern) {
  constexpr std::array<const char*, kPatterns.size()> kNames{
      "plain", "plaster", "bricks",   "wallpaper", "boards", "tiles", "wood",   "fabric", "rug",
      "book",  "leaf",    "painting", "picture",   "lamp",   "sky",   "mirror", "glass"};
  return kNames[static_cast<std::size_t>(pattern)];
}

Color albedo_at(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  switch (surface.pattern) {
    case Pattern::kPlain:
      return surface.base;
    case Pattern::kPlaster:
      return plaster_albedo(surface, at, footprint);
    case Pattern::kBricks:
      return brick_albedo(surface, at, footprint);
    case Pattern::kWallpaper:
      return wallpaper_albedo(surface, at, footprint);
    case Pattern::kBoards:
      return board_albedo(surface, at, footprint);
    case Pattern::kTiles:
      return tile_albedo(surface, at, footprint);
    case Pattern::kWood:
      return wood_albedo(surface, at, footprint);
    case Pattern::kFabric:
      return fabric_albedo(surface, at, footprint);
    case Pattern::kRug:
      return rug_albedo(surface, at, footprint);
    case Pattern::kBook:
      return book_albedo(surface, at, footprint);
    case Pattern::kLeaf:
      return leaf_albedo(surface, at, footprint);
    case Pattern::kPainting:
      return painting_albedo(surface, at, footprint);
    case Pattern::kPicture:
      return surface.picture->at(at.cwiseQuotient(surface.extent), footprint / surface.extent.x());
    case Pattern::kLamp:
      return lamp_emission(surface, at, footprint);
    case Pattern::kSky:
    case Pattern::kMirror:
    case Pattern::kGlass:
      break;
  }
  return Color::Zero();
}

Color mean_albedo(const Surface& surface) {
  constexpr int kSide = 12;
  Color sum = Color::Zero();
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const Eigen::Vector2f share((static_cast<float>(i) + 0.5F) / kSide,
                                  (static_cast<float>(j) + 0.5F) / kSide);
      sum += albedo_at(surface, share.cwiseProduct(surface.extent), 0.02F);
    }
  }
  return sum / static_cast<float>(kSide * kSide);
}

}  // namespace raywalk::capture
