// What views of a room read, on a graphics card: panoramas, distance maps and what must not be
// used.
#pragma once

#include <memory>
#include <span>

#include "core/room/room.h"
#include "core/view/gpu/layered_texture.h"
#include "core/view/map_choice.h"

namespace raywalk {

// All is called during a Turn (gpu_context.h), and throws GpuError where the card fails.
class RoomTextures {
 public:
  // With the stations' gains or without; panoramas in at most `most_bytes` of the card's memory.
  // The room must outlive the object.
  RoomTextures(const Room& room, bool gains, std::uint64_t most_bytes);

  // As many stations as fit at once.
  std::size_t most_stations() const { return stations_->layers(); }
  void require_stations(std::span<const ImageKey> stations);
  int station_layer(ImageKey station) const { return stations_->layer(station); }
  // Maps by their lines and their indices there.
  void require_maps(std::span<const ImageKey> maps);
  int map_layer(ImageKey map) const { return maps_->layer(map); }
  // What is masked in stations, and what moved there.
  void require_masks(std::span<const ImageKey> stations);
  int mask_layer(ImageKey station) const { return masks_ ? masks_->layer(station) : -1; }

  // stations: RGBA, [theta][phi]: the colours, and in the fourth channel 255 where they may be
  // used, 128 where something moved, 0 where they are masked. maps: inverse distances, 1/m,
  // [theta][phi]. masks: as in fill.glsl.
  enum Unit : GLuint { kStations, kMaps, kMasks };
  void bind() const;

 private:
  void upload_station(ImageKey station, int layer);
  void upload_mask(ImageKey station, int layer);

  const Room& room_;
  bool gains_;
  int mask_width_ = 0, mask_height_ = 0;
  std::unique_ptr<LayeredTexture> stations_;
  std::unique_ptr<LayeredTexture> maps_, masks_;  // null where the room has none
};

}  // namespace raywalk
